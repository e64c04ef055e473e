# SPDX-License-Identifier: Apache-2.0
"""A sweep on other processes: killed and gone on with, and on a Dask cluster."""

from __future__ import annotations

import contextlib
import gc
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from distributed import Client, LocalCluster

from quadshade.cli.main import main
from quadshade.trade import workers

SIZE = ("--size", "96x96", "--no-area", "--shadings", "flat,gouraud,quadratic")
POINTS = 60


def trade(*arguments: str | Path):
    return CliRunner().invoke(main, ["trade", "sphere:168", *SIZE, *map(str, arguments)])


def content(folder: Path) -> dict:
    """What a sweep wrote, but for the host's time, which is never the same twice."""
    written = json.loads((folder / "trade.json").read_text())
    for point in written["points"]:
        assert point.pop("host_seconds") > 0
    return written


def test_a_killed_sweep_goes_on(tmp_path: Path) -> None:
    fractions = ("--fractions", "8,9,10,11,12,13,14,15,16,17", "--subdivisions", "none,all:1")
    command = [sys.executable, "-c", "from quadshade.cli.main import main; main()", "trade", "sphere:168"]
    # One worker: the kill comes while most points are still to be measured.
    killed = subprocess.Popen(
        [*command, *SIZE, *fractions, "-o", tmp_path / "sweep", "--jobs", "1"], start_new_session=True
    )
    folder = tmp_path / "sweep" / "points"
    while len(list(folder.glob("*/record.json"))) < 3 and killed.poll() is None:
        time.sleep(0.001)
    os.killpg(killed.pid, signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    assert not (tmp_path / "sweep" / "trade.json").exists()
    # A folder with a name is whole; what was half-written has none yet.
    before = {path: path.stat().st_mtime_ns for path in folder.glob("[!.]*")}
    assert 3 <= len(before) < POINTS
    for path in before:
        assert {file.name for file in path.iterdir()} == {"record.json", "picture.png", "error.png"}
    # What a kill in the middle of writing leaves.
    (folder / ".half-1" / "point").mkdir(parents=True)

    run = trade(*fractions, "-o", tmp_path / "sweep", "--jobs", "1")
    assert run.exit_code == 0, run.output
    assert f"{POINTS} points, {len(before)} from before, 0 refused" in run.output
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert len(list(folder.iterdir())) == POINTS
    whole = trade(*fractions, "-o", tmp_path / "whole", "--jobs", "1")
    assert f"{POINTS} points, 0 from before" in whole.output
    assert content(tmp_path / "sweep") == content(tmp_path / "whole")


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """Address of a scheduler of this machine with two workers."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as local:
        yield local.scheduler_address


def test_dask_gives_the_same(tmp_path: Path, cluster: str) -> None:
    few = ("--fractions", "8,22", "--subdivisions", "none,all:1")
    run = trade(*few, "-o", tmp_path / "dask", "--dask", cluster)
    assert run.exit_code == 0, run.output
    with Client(cluster) as client:
        loaded = client.run(lambda: "quadshade.trade.measure" in __import__("sys").modules)
    # The points were measured there: the scheduler gives all to one worker only if the other is busy.
    assert len(loaded) == 2
    assert any(loaded.values())
    assert trade(*few, "-o", tmp_path / "here", "--jobs", "1").exit_code == 0
    assert content(tmp_path / "dask") == content(tmp_path / "here")
    for name in [path.relative_to(tmp_path / "here") for path in (tmp_path / "here").rglob("*.png")]:
        assert (tmp_path / "dask" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


def told(run: Result) -> str:
    """What a command says but for steps, which it says where they take over two seconds."""
    return "\n".join(line for line in run.output.splitlines() if not line.endswith(" ..."))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:{port}", "nonsense://host:1"])
def test_no_scheduler_is_one_line(tmp_path: Path, address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quadshade.cluster.CONNECT_SECONDS", 0.5)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = address.format(port=free.getsockname()[1])
        run = trade("-o", tmp_path, "--fractions", "8", "--subdivisions", "none", "--dask", address)
    assert run.exit_code == 2
    assert told(run).startswith(f"quadshade: error: no Dask scheduler answers at {address}; start one by")
    assert len(told(run).splitlines()) == 1


def test_another_server_is_no_scheduler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quadshade.cluster.CONNECT_SECONDS", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            with contextlib.suppress(OSError):
                while True:
                    caller, _ = server.accept()
                    caller.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")

        threading.Thread(target=answer, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        run = trade("-o", tmp_path, "--fractions", "8", "--subdivisions", "none", "--dask", address)
    assert run.exit_code == 2
    assert told(run).startswith(f"quadshade: error: no Dask scheduler answers at {address}; start one by")
    # One that is left open closes itself when it is collected, in any thread, and may wait there for ever.
    clients = [one for one in gc.get_objects() if isinstance(one, Client)]
    assert [client.status for client in clients if client.status != "closed"] == []


def test_no_more_processes_than_points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    real = workers.joblib.Parallel
    monkeypatch.setattr(
        workers.joblib,
        "Parallel",
        lambda n_jobs, **others: asked.append(n_jobs) or real(n_jobs=1, **others),
    )
    few = ("-o", tmp_path, "--fractions", "8,9", "--subdivisions", "none")
    assert trade(*few, "--jobs", "200").exit_code == 0
    assert asked == [6]
    assert trade(*few, "--jobs", "100000").exit_code == 2


def test_without_dask_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    run = trade("-o", tmp_path, "--fractions", "8", "--subdivisions", "none", "--dask", "tcp://127.0.0.1:1")
    assert run.exit_code == 2
    assert run.output == "quadshade: error: Dask is not installed; run `pip install quadshade[dask]`\n"
