# SPDX-License-Identifier: Apache-2.0
"""The archive of a release, unpacked in a folder of its own: every file of it is used as its README says."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from quadshade.contract.releases import definition_hash
from quadshade.files.word_file import table_path
from quadshade.rendering.groups import SetupChoice
from quadshade.rendering.words import file_words
from scripts.release import fusesoc
from scripts.release.__main__ import BOARDS, archive, bitstreams, changes, files, without_bitstream

ROOT = Path(__file__).resolve().parents[1]
DESIGN = ROOT / "examples" / "design"
PIXELS = 1112
FUSESOC = Path(sys.executable).with_name("fusesoc")


def run(command: list[str | Path] | str, folder: Path) -> str:
    done = subprocess.run(
        command if isinstance(command, list) else ["/bin/bash", "-e", "-o", "pipefail", "-c", command],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"HOME": str(folder), "PYTHONPATH": ""},
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def content() -> dict[str, bytes]:
    return files()


@pytest.fixture(scope="module")
def unpacked(content: dict[str, bytes], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("release")
    packed = archive(content, "quadshade")
    subprocess.run(["tar", "-xz", "-C", str(folder)], input=packed, check=True)
    return folder / "quadshade"


def test_the_sums_are_of_all_files(content: dict[str, bytes], unpacked: Path) -> None:
    said = run(["sha256sum", "--check", "SHA256SUMS"], unpacked)
    assert said.count(": OK") == len(content) - 1
    assert archive(content, "quadshade") == archive(dict(reversed(content.items())), "quadshade")


def test_bitstreams_are_those_that_this_host_talks_to(tmp_path: Path) -> None:
    row = {
        "device": "ecp5-25k-6",
        "screen": "160 x 120",
        "clocks": {"clk": [101.5, 100.0]},
        "definition": f"{definition_hash():08x}",
    }
    for name, about in (
        ("now.bit", row),
        ("before.bin", row | {"definition": "d74b0fed"}),
        ("alone.fs", None),
    ):
        (tmp_path / name).write_bytes(b"bits")
        if about:
            (tmp_path / name).with_suffix(".json").write_text(json.dumps(about))
    found, old = bitstreams(tmp_path)
    text, data = found.pop("bitstreams/now.bit")
    assert not found and old == ["alone.fs", "before.bin"] and data == b"bits"
    assert text == "`now` for ecp5-25k-6, screen 160 x 120, MHz after place-and-route: clk 101.5 of 100"


def test_boards_without_a_bitstream_are_named(content: dict[str, bytes]) -> None:
    """With what builds one, in one line, on the screen and in the archive's README."""
    boards = {path.stem for path in BOARDS.glob("*.toml")}
    assert {*re.findall(r"[\w-]+", without_bitstream([]).split(";")[0])} >= boards
    line = without_bitstream(["bitstreams/colorlight-i5.bit"], ["ulx3s-85f.bit"])
    assert not {"colorlight-i5", "ulx3s-85f"} & {*re.findall(r"[\w-]+", line)}
    assert "icebreaker, " in line and "`make bitstream BOARD=icebreaker`" in line and "\n" not in line
    assert without_bitstream([f"bitstreams/{name}.bit" for name in boards]) == ""
    readme = content["README.md"].decode()
    built = [name for name in content if name.startswith("bitstreams/")]
    assert without_bitstream(built) in readme


def test_its_readme_runs(unpacked: Path) -> None:
    """VHDL in one order in a library of its own, and the Verilog netlist; the pixels are the model's."""
    readme = (unpacked / "README.md").read_text()
    commands = re.findall(r"^    (.+)", readme, re.MULTILINE)
    said = "".join(run(command, unpacked) for command in commands)
    assert said.count(f"{PIXELS} pixels are equal") == 2
    assert set(re.findall(r"`(netlists/\w+\.v)`", readme)) == {
        str(path.relative_to(unpacked)) for path in unpacked.glob("netlists/*")
    }


@pytest.mark.parametrize("target", ["sim", "lint_axis", "lint_board"])
def test_fusesoc_takes_it(unpacked: Path, tmp_path: Path, target: str) -> None:
    """From an empty folder; the two that only elaborate hold every fileset."""
    command = [FUSESOC, "--cores-root", unpacked, "run", f"--target={target}", "quadshade::quadshade"]
    said = run(command, tmp_path)
    assert ("pixels are equal" in said) == (target == "sim")


def test_fusesoc_maps_it(unpacked: Path, tmp_path: Path) -> None:
    """Yosys takes minutes: one that only parses gets the family's commands and a whole netlist."""
    yosys = tmp_path / "yosys"
    yosys.write_text("""#!/bin/sh
echo "$2" > commands
iverilog -g2005 -tnull -s raster_core raster_core.v || exit 1
echo mapped > raster_core.cells
""")
    yosys.chmod(0o755)
    command = ["env", f"YOSYS={yosys}", FUSESOC, "--cores-root", unpacked, "run", "--target=synth_gowin"]
    assert "\nmapped\n" in run([*command, "quadshade::quadshade"], tmp_path)
    (folder,) = tmp_path.glob("build/*/synth_gowin")
    text = (folder / "commands").read_text()
    assert "synth_gowin -top raster_core -noiopads" in text and "keep_hierarchy 1 channel_lane*" in text
    assert '"' not in (folder / "raster_core.v").read_text()


def test_netlists_are_whole(unpacked: Path) -> None:
    for path in sorted(unpacked.glob("netlists/*.v")):
        text = path.read_text()
        assert text.startswith("// SPDX-License-Identifier: Apache-2.0\n")
        assert "Its generics are fixed" in text and str(ROOT) not in text
        modules = re.findall(r"^(.*)\nmodule (\w+)", text, re.MULTILINE)
        kept = {name for before, name in modules if before == '(* keep_hierarchy = "yes" *)'}
        assert kept == {name for _, name in modules if name.startswith("channel_lane")} != set()
        top = re.findall(r"^// (\w+) of Quadshade", text, re.MULTILINE)
        run(["iverilog", "-g2005", "-tnull", "-s", *top, path], unpacked)
        run(["verilator", "--lint-only", "-Wno-fatal", "--top-module", *top, path], unpacked)


def test_it_says_what_has_changed(unpacked: Path) -> None:
    assert (unpacked / "CHANGES.md").read_text() == changes()
    assert changes().startswith("## ") and changes().count("\n## ") == 0
    assert (unpacked / "VERSION").read_text().split()[0] in (unpacked / "README.md").read_text()


def test_the_bench_has_the_models_words() -> None:
    words = file_words(DESIGN / "triangles.json", {}, SetupChoice())
    assert (DESIGN / "words.hex").read_text().split() == [f"{word:08x}" for word in words.words]
    rows = np.loadtxt(table_path(DESIGN / "words.hex", "pixels"), delimiter=",", skiprows=1, dtype=np.int64)
    pixels = words.pixels
    assert len(rows) == PIXELS
    assert np.array_equal(rows[:, 1:7], np.column_stack([pixels.x, pixels.y, pixels.value]))
    assert np.array_equal(rows[:, 7] != 0, words.last)


def test_the_core_file_is_current() -> None:
    assert fusesoc.CORE.read_text() == fusesoc.text()
