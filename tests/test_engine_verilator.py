# SPDX-License-Identifier: Apache-2.0
"""The netlist in Verilator gives the golden model's pixels and clocks, and GHDL's."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.contract.formats import QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import default_engine, draw_words
from quadshade.engine.netlist import RENDER_TOP, write_netlist
from quadshade.engine.simplify_netlist import fold
from quadshade.engine.tool_runner import run_tool, tool_command
from quadshade.engine.verilator import (
    VERILATOR_OPTIONS,
    build_verilator,
    draw_verilator,
    missing_program,
    verilator_available,
)
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import EmittedPixels
from quadshade.golden.shade import render_core
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.shade_stimuli import random_state

needs_verilator = pytest.mark.skipif(
    not verilator_available(),
    reason=f"needs {missing_program() or 'the repository'}: run `make setup`",
)

SIZE = 96
CASES = {
    "default": Formats(),
    "shade": Formats(
        with_shade=1, num_channels=4, num_specular=2, value_bits=12, shade_guard_bits=6, frac_bits=18
    ),
    # Ports wider than 64 bits, values across the ports' words, differences of two set-up words, a chain of
    # one span.
    "wide": Formats(
        num_channels=5, value_bits=15, word_width=40, stream_width=128, with_depth=0, span_depth=1
    ),
    "narrow": Formats(
        num_channels=1, value_bits=6, word_width=26, frac_bits=16, depth_bits=20, stream_width=64
    ),
}


def random_words(formats: Formats, rng: np.random.Generator, count: int = 60) -> np.ndarray:
    """Set-up words of random triangles of all orders, some of them beyond the screen's edge."""
    scale = 1 << formats.subpixel_bits
    triangles = ScreenTriangles(
        SIZE,
        SIZE,
        rng.integers(-8 * scale, (SIZE + 8) * scale, (count, 3, 2)),
        rng.uniform(0, (1 << formats.value_bits) - 1, (count, formats.num_channels, 6)),
        rng.integers(0, QUADRATIC + 1, (count, formats.num_channels)),
        rng.uniform(0, (1 << formats.depth_bits) - 1, (count, 3)) if formats.with_depth else None,
        tuple(f"c{channel}" for channel in range(formats.num_channels)),
    )
    return pack(setup_triangles(triangles, formats), formats)


def check_same(got: EmittedPixels, expected: EmittedPixels) -> None:
    """Counts, then every column, with the first pixel that differs."""
    assert (got.clocks, got.packets, len(got.x)) == (expected.clocks, expected.packets, len(expected.x))
    for name in ("packet", "x", "y", "value"):
        one, other = getattr(got, name), getattr(expected, name)
        assert one.dtype == other.dtype and one.shape == other.shape
        wrong = np.flatnonzero((one != other).reshape(len(one), -1).any(axis=1))
        assert not len(wrong), (
            f"{len(wrong)} pixels; {name} of {wrong[0]}: {one[wrong[0]]}, not {other[wrong[0]]}"
        )


@needs_verilator
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("stall_period", [0, 4])
def test_is_the_golden_model(name: str, stall_period: int, rng: np.random.Generator) -> None:
    formats = CASES[name]
    words = random_words(formats, rng)
    state = random_state(formats, rng) if formats.with_shade else None
    expected = render_core.draw(words, formats, state, stall_period)
    assert len(expected.x) > 10_000
    check_same(draw_verilator(words, formats, stall_period, state), expected)


@needs_verilator
@pytest.mark.parametrize("name", ["default", "shade"])
def test_is_ghdl(name: str, rng: np.random.Generator) -> None:
    formats = CASES[name]
    words = random_words(formats, rng, 6)
    state = random_state(formats, rng) if formats.with_shade else None
    drawn = [draw_words(words, formats, engine, state=state) for engine in ("verilator", "ghdl")]
    check_same(*drawn)


@needs_verilator
def test_shade_without_a_state_passes_colours(rng: np.random.Generator) -> None:
    words = random_words(CASES["shade"], rng)
    check_same(draw_verilator(words, CASES["shade"]), render_core.draw(words, CASES["shade"]))


@needs_verilator
def test_empty_stream() -> None:
    drawn = draw_verilator(np.zeros(0, np.uint32), Formats())
    assert (drawn.clocks, drawn.packets, drawn.value.shape) == (0, 0, (0, 4))


@needs_verilator
def test_a_stream_that_ends_within_a_packet_is_an_error(rng: np.random.Generator) -> None:
    with pytest.raises(QuadshadeError, match="render_core failed: error: the core hangs"):
        draw_verilator(random_words(Formats(), rng)[:-1], Formats())


@needs_verilator
def test_render_is_the_same_and_verilator_the_default(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("QUADSHADE_ENGINE")
    files = {}
    for engine in ("model", "verilator", ""):
        files[engine] = tmp_path / f"by_{engine}.png", tmp_path / f"by_{engine}.json"
        command = ["render", "sphere:168", "--size", "64x64", "-o", files[engine][0], "--stats"]
        command += [files[engine][1], *(["--engine", engine] if engine else [])]
        result = CliRunner().invoke(main, [str(word) for word in command])
        assert result.exit_code == 0, result.output
    model, verilator, default = ([path.read_bytes() for path in pair] for pair in files.values())
    assert model[0] == verilator[0]
    assert model[1].replace(b'"model"', b'"verilator"') == verilator[1]
    assert default == verilator


def test_default_engine_without_tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert default_engine() == "model"
    with pytest.raises(
        QuadshadeError, match="ghdl is not installed; run `make setup`, or use --engine model"
    ):
        draw_words(np.ones(1, np.uint32), Formats(), "verilator")


def test_has_no_waves(tmp_path: Path) -> None:
    with pytest.raises(QuadshadeError, match="the engine verilator has no waves; use --engine ghdl"):
        draw_words(np.zeros(0, np.uint32), Formats(), "verilator", tmp_path / "out.ghw")


@pytest.mark.skipif(shutil.which("ghdl") is None, reason="needs GHDL: run `make setup`")
def test_two_at_once_compile_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "log"
    tool = tmp_path / "verilator"
    tool.write_text(
        '#!/bin/sh\n[ "$1" = --version ] && echo 1.0 && exit\n'
        f"sleep 0.3\necho compiled >> {log}\n"
        f"echo core > {RENDER_TOP}\n"
    )
    tool.chmod(0o755)
    monkeypatch.setenv("VERILATOR", str(tool))
    monkeypatch.setenv("CXX", "true")
    with ThreadPoolExecutor(2) as pool:
        programs = list(pool.map(lambda _: build_verilator(Formats(), tmp_path / "kept"), range(2)))
    assert programs[0] == programs[1] and programs[0].read_text() == "core\n"
    assert log.read_text() == "compiled\n"


NETLIST = """\
module unit
  (input  clk,
   input  enable,
   input  ready,
   input  [7:0] data);
  reg [7:0] word;
  wire [7:0] n1_o;
  reg [7:0] n2_q;
  wire moves_1;
  wire [1:0] moves;
  wire [1:0] n3_o;
  always @*
    word = n2_q; // (isignal)
  initial
    word <= 8'b00000000;
  assign moves = n3_o; // (signal)
  assign moves_1 = moves[0] | enable;
  assign n1_o = enable ? data : word;
  always @(posedge clk)
    n2_q <= n1_o;
  initial
    n2_q <= 8'b00000000;
  assign n3_o = {moves_1, ready};
endmodule
"""


def test_fold() -> None:
    folded = fold(NETLIST)
    assert "  wire [7:0] word;\n" in folded and "  assign word = n2_q; // (signal)\n" in folded
    assert "  always @(posedge clk)\n    if (enable) n2_q <= data;\n  initial\n" in folded
    assert "  assign moves_1 = ready | enable;\n" in folded
    assert folded.count("initial") == 1


def test_fold_leaves_what_is_used_elsewhere() -> None:
    # The next value and the row have another reader; the register keeps neither value nor enable.
    text = NETLIST.replace("endmodule", "  assign a = n1_o;\n  assign b = moves;\nendmodule")
    folded = fold(text.replace("enable ? data : word", "enable ? data : data"))
    assert "    n2_q <= n1_o;\n" in folded and "moves[0] | enable" in folded
    assert fold("module other;\nendmodule\n") == "module other;\nendmodule\n"


@pytest.mark.skipif(shutil.which("ghdl") is None, reason="needs GHDL: run `make setup`")
def test_fold_finds_the_enables_of_the_core() -> None:
    netlist = write_netlist(Formats().generics(), RENDER_TOP).read_text()
    folded = fold(netlist)
    assert netlist.count("if (") == 0 and folded.count("    if (") > 50
    assert "always @*" not in folded and "moves[" not in folded


@needs_verilator
def test_a_unit_that_boards_rarely_have_is_clean(tmp_path: Path) -> None:
    """Verilator refuses a netlist with a warning; no other test compiles a board with vertices."""
    path = tmp_path / "vertex_unpacker.v"
    path.write_text(fold(write_netlist({}, "vertex_unpacker").read_text()))
    options = [option for option in VERILATOR_OPTIONS if option not in ("--cc", "--exe", "--build")]
    run_tool([*tool_command("VERILATOR"), "--lint-only", *options, path], tmp_path)
