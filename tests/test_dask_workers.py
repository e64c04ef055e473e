# SPDX-License-Identifier: Apache-2.0
"""Tiles and frames on the workers of a Dask scheduler, which are processes of their own and may be killed."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from distributed import Client, LocalCluster

import quadshade
from quadshade import cluster
from quadshade.errors import QuadshadeError
from quadshade.image import read_picture
from quadshade.rendering import Reports
from tests.test_board_api import run

LOOK = {"size": (170, 124), "camera": "from=1,2,3"}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler with two workers, each a process with a board."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", resources={"board": 1}
    ) as local:
        yield local.scheduler_address


def test_workers_draw_the_models_picture(address: str) -> None:
    """With the golden model, with a simulated board each, styles and edges included."""
    for arguments, ports in (({}, (None, "sim")), ({"edges": "profile,inner", "style": "hatch"}, ("sim",))):
        model = quadshade.render("torus:288", engine="model", **LOOK, **arguments)
        for port in ports:
            told: list[str] = []
            drawn = quadshade.render(
                "torus:288",
                dask=address,
                port=port,
                engine="model",
                reports=Reports(notice=told.append),
                **LOOK,
                **arguments,
            )
            assert np.array_equal(drawn.array, model.array), (port, arguments)
            assert f"drawn by the board at {address}, in " in drawn.summary
            assert all("edges found by the host" in text for text in told)


def test_a_worker_killed_in_mid_frame_leaves_the_film_whole(address: str, tmp_path: Path) -> None:
    """Two workers with a board each; one is killed while it draws."""
    scene = ("turn", "sphere:168", "--frames", "8", "--size", "48x32", "--no-errors")
    sim = ("--port", "sim", "--engine", "model")
    home, away = tmp_path / "home", tmp_path / "away"
    code, output = run(*scene, *sim, "-o", home)
    assert code == 0, output
    with Client(address) as client:
        victim = min(client.run(os.getpid).values())
    animation = quadshade.turn(
        "sphere:168",
        frames=8,
        size=(48, 32),
        errors=False,
        port="sim",
        engine="model",
        dask=address,
        reports=Reports(progress=kill_at(3, victim)),
    )
    animation.save(away)
    frames = sorted(path.name for path in home.glob("*.png") if path.stem != "plot")
    assert len(frames) == 8
    for name in frames:
        assert np.array_equal(read_picture(home / name), read_picture(away / name)), name


def kill_at(count: int, process: int):
    """A progress that kills a process once so many frames are drawn."""

    def tell(what: str, done: float, total: float, sent: int) -> None:
        if done == count:
            os.kill(process, signal.SIGKILL)

    return tell


def test_memory_stays_bounded(address: str) -> None:
    """Of many jobs only a few are begun before the first results are taken."""
    begun: list[int] = []

    def jobs() -> Iterator[int]:
        for job in range(200):
            begun.append(job)
            yield job

    with cluster.connect(address) as client:
        seen = 0
        for job, result in cluster.stream(client, abs, jobs(), "numbers", lambda *_: None):
            assert job == result
            seen += 1
            assert len(begun) <= seen + cluster.AHEAD * 2 + 1
    assert seen == 200


def test_the_last_worker_says_what_is_missing(address: str) -> None:
    told: list[tuple[str, str]] = []

    def fail(job: int) -> int:
        raise QuadshadeError("it is broken")

    with (
        cluster.connect(address) as client,
        pytest.raises(QuadshadeError, match="5 tiles are missing.*broken"),
    ):
        list(cluster.stream(client, fail, range(5), "tiles", lambda *said: told.append(said)))
    assert 1 <= len(told) <= 2 and all(reason == "it is broken" for _, reason in told)


def test_a_lost_scheduler_is_one_line(address: str) -> None:
    with cluster.connect(address) as client:
        results = cluster.stream(client, abs, range(40), "numbers", lambda *_: None)
        # Results come as workers finish.
        number, found = next(results)
        assert number == found
        # As Dask itself does where it cannot reach the scheduler any more.
        client.close()
        with pytest.raises(QuadshadeError, match=r"\d+ numbers are missing, as the Dask scheduler is lost"):
            list(results)


def test_bad_schedulers_and_workers_are_one_line(address: str, tmp_path: Path, monkeypatch) -> None:
    base = ("render", "cube:1", "-o", tmp_path / "a.png", "--dask")
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.5)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        nobody = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        cases = [
            ((nobody,), "no Dask scheduler answers"),
            (("what:is:this",), "no Dask scheduler answers"),
            ((address, "--port", "sim:2"), "each worker has one of its own"),
            ((address, "--port", "sim", "--trace"), "no --trace"),
        ]
        for words, said in cases:
            code, output = run(*base, *words)
            assert code == 2 and said in output, output
    monkeypatch.setattr(cluster, "definition_hash", lambda: 1)
    code, output = run(*base, address)
    assert code == 2 and "has another version of Quadshade" in output
    assert output.count("\n") == 1 and not list(tmp_path.iterdir())
