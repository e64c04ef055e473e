# SPDX-License-Identifier: Apache-2.0
"""Tools under other names and with arguments, and folders whose names have blanks and signs."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.engine.draw import default_engine, draw_words
from quadshade.engine.tool_runner import TOOLS, missing_tool, tool_command
from quadshade.engine.verilator import build_verilator
from quadshade.errors import QuadshadeError
from tests.support.golden_stimuli import triangle_words

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("variable", TOOLS)
@pytest.mark.parametrize(
    ("text", "command"),
    [
        ("", None),
        ("  ", None),
        ("other", ["other"]),
        ("ccache other -m64", ["ccache", "other", "-m64"]),
        ("'/my dir/other' -D'A B'", ["/my dir/other", "-DA B"]),
    ],
)
def test_commands(
    variable: str, text: str, command: list[str] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, text)
    assert tool_command(variable) == (command or [TOOLS[variable]])


@pytest.mark.parametrize("variable", TOOLS)
@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("/nowhere/tool -x", "/nowhere/tool is not installed"),
        ("'open", "No closing quotation"),
    ],
)
def test_a_wrong_command_is_said_and_no_other_engine_taken(
    variable: str, text: str, problem: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, text)
    assert f"{variable} is " in missing_tool([variable]) and problem in missing_tool([variable])
    for draw in (default_engine, lambda: build_verilator(Formats())):
        with pytest.raises(QuadshadeError, match=f"{variable} is .*{problem}; run `make setup`"):
            draw()


def test_usual_commands_that_are_missing_leave_the_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The Makefile exports GHDL=ghdl: that is nobody's wish for an engine."""
    for variable, command in TOOLS.items():
        monkeypatch.setenv(variable, command)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert default_engine() == "model"


@pytest.mark.skipif(shutil.which("verilator") is None, reason="needs Verilator: run `make setup`")
def test_a_checkout_in_a_folder_with_blanks_and_signs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator
) -> None:
    """GHDL and Verilator, with a compiler that has arguments, draw what the model draws."""
    root = tmp_path / "my dir (1) '&$HOME;#=x"
    for name in ("rtl", "sim"):
        shutil.copytree(ROOT / name, root / name)
    monkeypatch.setenv("QUADSHADE_ROOT", str(root))
    monkeypatch.setenv("CXX", "env A=1 g++ -m64 -DX='$a b'")
    formats = Formats(num_channels=1, max_order=0, with_depth=0, word_width=20, frac_bits=8, coord_bits=8)
    words = triangle_words(formats, rng, 20)
    pictures = [draw_words(words, formats, engine) for engine in ("model", "ghdl", "verilator")]
    assert len(pictures[0].x)
    for picture in pictures[1:]:
        assert picture.clocks == pictures[0].clocks
        for name in ("x", "y", "value", "packet"):
            assert np.array_equal(getattr(picture, name), getattr(pictures[0], name))
    assert {path.name for path in (root / "build").iterdir()} >= {"ghdl", "netlist", "verilator"}


@pytest.mark.skipif(shutil.which("ghdl") is None, reason="needs GHDL: run `make setup`")
def test_a_temporary_folder_with_a_blank_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "a b"))
    (tmp_path / "a b").mkdir()
    with pytest.raises(
        QuadshadeError, match="make takes no path with a blank; set TMPDIR to a folder without"
    ):
        build_verilator(Formats(num_channels=2), tmp_path / "kept")
    assert not list((tmp_path / "a b").iterdir())


def test_set_up_takes_a_command_with_arguments(tmp_path: Path) -> None:
    """A compiler that is there needs no package: apt-get is not on the path, and would be missed."""
    for name in ("python3", "ghdl", "verilator", "ccache", "iverilog", "chromium", "chromedriver"):
        (tmp_path / name).write_text("#!/bin/sh\nexit 0\n")
        (tmp_path / name).chmod(0o755)
    command = ["/bin/bash", str(ROOT / "scripts" / "install_tools.sh")]
    environment = {"PATH": str(tmp_path), "CXX": "ccache g++ -m64", "GHDL": "ghdl --x", "VERILATOR": ""}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
