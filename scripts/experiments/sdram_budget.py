#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
What a picture of 640 x 480 in an SDRAM takes: the memory's time, block RAM of bands, bytes on the line.

The controller's clocks are those of its model. A monitor's scanlines are fetched over many lines while the
other port asks without a pause, run by run. Triangles of real scenes are cut to bands and packed, and drawn
on the simulated board, which counts its clocks.
Writes docs/reports/sdram.md and sdram.json.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np

from quadshade.board import Board
from quadshade.board.settings import board_settings
from quadshade.board.tiled_picture import TiledPicture
from quadshade.choices import PACK_ERROR
from quadshade.contract.protocol import PAYLOADS, Opcode
from quadshade.engine.draw import draw_words
from quadshade.files.markdown import markdown_table
from quadshade.golden.common.sdram_chip import CHIPS, SdramTiming
from quadshade.golden.common.sdram_controller import SdramGenerics
from quadshade.golden.screen.scan_out import Timing
from quadshade.golden.screen.sdram_depth_test import span_clocks
from quadshade.golden.screen.sdram_line_fetch import most_line_clocks
from quadshade.packing.line import frame_bytes, frames_bytes
from quadshade.packing.pack import unpack
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup.tile import Rectangle
from quadshade.shading.sample import sample
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "sdram.md"
BOARD = "ulx3s-85f-sdram"
SETTINGS = board_settings(BOARD, None, {"baud": 1_250_000})
"""Of the simulated board: the fastest line, so that it waits for the memory."""
HERTZ = 100_000_000
CLOCKS_PER_PIXEL = 4
VIDEO = Timing()
SIZE = (VIDEO.columns, VIDEO.lines)
PIXEL_BITS = 16
DEPTH_BITS = 17
BLOCK_BITS = 18 * 1024
BLOCKS = 56
"""Of LFE5U-12F and 25F."""
BITS_OF_A_BYTE = 10
BAUDS = (1_000_000, 3_000_000)
SCENES = ("sphere:690", "torus:1152")
ROWS = (16, 24, 32, 48)
LINE = VIDEO.all_columns * CLOCKS_PER_PIXEL
"""Clocks of a line of the monitor, in which a scanline is fetched."""

MEMORIES = {
    "ULX3S: 16 bits": SdramGenerics(),
    "Tang Nano 20K: 16 of 32 bits": SdramGenerics(row_bits=11, column_bits=8),
}
"""A word is a pixel. The second one's organisation is known; its times are taken to be those of the first."""


class Fetch(NamedTuple):
    """Most clocks of a scanline from when it is wanted to its last word; of a run until it is accepted."""

    line: int
    wait: int


def frame_clocks() -> int:
    """Clocks of a picture on the monitor."""
    return VIDEO.all_columns * VIDEO.all_lines * CLOCKS_PER_PIXEL


def share(generics: SdramGenerics) -> dict:
    """Clocks of the memory in those of one picture on the monitor."""
    words = SIZE[0] * SIZE[1] * PIXEL_BITS // generics.data_bits
    runs = words // generics.run_words
    refreshes = frame_clocks() / generics.refresh_clocks
    return {
        "frame": frame_clocks(),
        "shown": runs * generics.run_clocks(generics.run_words, False),
        "written": runs * generics.run_clocks(generics.run_words, True),
        "refreshed": round(refreshes * generics.rfc_clocks),
    }


def runs(generics: SdramGenerics, lines: int) -> Iterator[tuple[int, int, int]]:
    """
    Runs of ``sdram_line_fetch`` while the second port always asks: line, when asked for, when accepted.

    A scanline is wanted every line of the monitor, and each of its runs a clock after the one before it.
    """
    now, tick = 0, generics.refresh_clocks
    write = generics.run_clocks(generics.run_words, True)
    read = generics.run_clocks(generics.run_words, False)
    for line in range(lines):
        asked = line * LINE + 1
        for _ in range(SIZE[0] // generics.run_words):
            while now < asked or now >= tick:
                if now >= tick:
                    now += generics.rfc_clocks
                    tick += generics.refresh_clocks
                else:
                    now += write
            yield line, asked, now
            asked, now = now + 1, now + read


def fetch(generics: SdramGenerics, lines: int) -> Fetch:
    """The worst of so many lines."""
    line = wait = 0
    for index, asked, accepted in runs(generics, lines):
        line = max(line, accepted + generics.latency() + generics.run_words - 1 - index * LINE)
        wait = max(wait, accepted - asked)
    return Fetch(line, wait)


def blocks(rows: int) -> dict[str, int]:
    """Block RAM of a band: its colours twice, one drawn while the other is written out, and its depths."""
    pixels = SIZE[0] * rows
    colours, depths = (-(-pixels * bits // BLOCK_BITS) for bits in (18, 18))
    return {"rows": rows, "bands": SIZE[1] // rows, "colours": 2 * colours, "depths": depths}


def spans_of(x: np.ndarray, y: np.ndarray, run_words: int) -> np.ndarray:
    """Lengths of spans of the core's pixels in their order; a span ends at a multiple of a run."""
    same = (y[1:] == y[:-1]) & (np.abs(np.diff(x.astype(int))) == 1)
    same &= np.diff(x // run_words) == 0
    starts = np.flatnonzero(np.concatenate(([True], ~same)))
    return np.diff(np.append(starts, len(x)))


def depth_clocks(spans: np.ndarray, generics: SdramGenerics) -> int:
    """Clocks of spans with their depths in the memory: read, then written with the colours."""
    lengths = zip(*np.unique(spans, return_counts=True), strict=True)
    return sum(int(count) * span_clocks(int(length), generics) for length, count in lengths)


def settled(board: Board) -> int:
    """Clocks in which a board was busy, once it is no more: it says so amid what it draws too."""
    busy = -1
    while busy != (busy := board.status()["clocks_busy"]):
        pass
    return busy


def board_clocks(words: np.ndarray) -> int:
    """Clocks in which the board is busy with a clear and packed words, while its monitor is on."""
    with Board("sim", settings=SETTINGS, engine="verilator") as board:
        before = settled(board)
        board.clear()
        board.send(words)
        return settled(board) - before


def scene_costs(scene: str) -> dict:
    """Bytes on the line of a scene in one piece and in bands, with clears and a swap; clocks and spans."""
    formats = SETTINGS.formats
    mesh = load_scene(scene)
    projected = project(mesh, fit_camera(mesh), *SIZE, formats)
    picture = TiledPicture(formats, *SIZE)
    picture.draw(sample(projected, "quadratic", formats=formats), PACK_ERROR)

    def words(rectangle: Rectangle) -> list[np.ndarray]:
        return [part.words for part in picture.parts(rectangle, formats)]

    def sent(rectangle: Rectangle) -> int:
        count = sum(map(len, words(rectangle)))
        return frame_bytes(PAYLOADS[Opcode.CLEAR].field_bytes) + frames_bytes(count)

    swap = frame_bytes(PAYLOADS[Opcode.SWAP].field_bytes)
    everything = Rectangle(0, 0, *SIZE)
    packed = words(everything)[0]
    emitted = draw_words(unpack(packed, formats), formats)
    spans = spans_of(emitted.x, emitted.y, SdramGenerics().run_words)
    bands = []
    for rows in ROWS:
        tops = range(0, SIZE[1], rows)
        bands.append([rows, swap + sum(sent(Rectangle(0, top, SIZE[0], rows)) for top in tops)])
    return {
        "scene": scene,
        "whole": swap + sent(everything),
        "core": emitted.clocks,
        "pixels": len(emitted.x),
        "spans": len(spans),
        "depth": depth_clocks(spans, SdramGenerics()),
        "board": board_clocks(packed),
        "bands": bands,
    }


def pins(timing: SdramTiming) -> dict:
    """
    How far behind the controller's clock that of the chip may be, in ns, with an FPGA without any delay.

    The controller takes a word at the edge ``cas_clocks`` + 1 behind that at which its command leaves, so the
    word has to stay until then; and what leaves at an edge must not change before the chip has taken it.
    """
    period = 1e9 / HERTZ
    return {"from": period - timing.t_oh, "to": period - timing.t_ih, "period": period}


def measure(lines: int) -> dict:
    """Every number of the report."""
    memories = []
    for name, generics in MEMORIES.items():
        memories.append({"name": name, **share(generics), **fetch(generics, lines)._asdict()})
    chips = []
    for name, timing in CHIPS.items():
        names = ("t_rcd", "t_rp", "t_ras", "t_rc", "t_rfc", "t_wr", "t_mrd")
        clocks = [timing.clocks(one, HERTZ) for one in names]
        chips.append({"name": name, "source": timing.source, "clocks": clocks, "pins": pins(timing)})
    return {
        "command": command_line("sdram_budget", lines=lines),
        "lines": lines,
        "generics": asdict(MEMORIES["ULX3S: 16 bits"]),
        "memories": memories,
        "chips": chips,
        "bands": [blocks(rows) for rows in ROWS],
        "scenes": [scene_costs(scene) for scene in SCENES],
    }


def designs(row: dict, memory: dict) -> list[tuple[str, int, float]]:
    """Ways to draw a scene: name, bytes on the line, pictures a second that core and memory can give."""
    found = []
    free = HERTZ * (1 - (memory["shown"] + memory["refreshed"]) / memory["frame"])
    cleared = SIZE[0] * SIZE[1]
    for rows, count in row["bands"]:
        bands = SIZE[1] // rows
        most = min(free / memory["written"], HERTZ / (cleared + row["core"]))
        found.append((f"bands of {rows}, cut by the host", count, most))
        found.append(
            (
                f"bands of {rows}, drawn from words in the memory",
                row["whole"],
                HERTZ / (cleared + bands * row["core"]),
            )
        )
    found.append(("depth in the memory", row["whole"], free / (row["depth"] + 2 * memory["written"])))
    return found


def memory_rows(results: dict) -> list[tuple[str, ...]]:
    """Rows of the table of clocks."""
    rows = []
    for memory in results["memories"]:
        clocks = [memory[name] for name in ("shown", "refreshed", "written")]
        shares = (f"{count:,} ({100 * count / memory['frame']:.1f} %)" for count in clocks)
        rows.append((memory["name"], f"{memory['frame']:,}", *shares))
    return rows


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    generics = results["generics"]
    fetches = [
        (memory["name"], memory["line"], f"{LINE:,}", memory["wait"]) for memory in results["memories"]
    ]
    chips = [
        (chip["name"], chip["source"], *chip["clocks"], f"{chip['pins']['from']:g} to {chip['pins']['to']:g}")
        for chip in results["chips"]
    ]
    bands = [
        (row["rows"], row["bands"], row["colours"], row["depths"], row["colours"] + row["depths"])
        for row in results["bands"]
    ]
    speeds = []
    for row in results["scenes"]:
        for name, count, most in designs(row, results["memories"][0]):
            pictures = (f"{min(most, baud / BITS_OF_A_BYTE / count):.1f}" for baud in BAUDS)
            ratio = f"{count / row['whole']:.2f}"
            speeds.append((row["scene"], name, f"{count:,}", ratio, f"{most:.0f}", *pictures))
    scenes = [
        (
            row["scene"],
            *(f"{row[name]:,}" for name in ("pixels", "spans", "core", "depth", "board")),
            f"{HERTZ / row['board']:.1f}",
        )
        for row in results["scenes"]
    ]
    about = f"""
        Written by `{results["command"]}` (`make sdram`). A calculation for boards such as
        `ulx3s-85f-sdram`, with the clocks of [its units](../reference/sdram.md):
        {HERTZ // 1_000_000} MHz, runs of {generics["run_words"]} words, a refresh every
        {generics["refresh_clocks"]} clocks, a pixel of {PIXEL_BITS} bits, dithered.
    """
    time_text = f"""
        Clocks of the memory in one picture on the monitor, {VIDEO.columns} x {VIDEO.lines} at
        {HERTZ / results["memories"][0]["frame"]:.1f} Hz: to show it, to refresh, and to write a whole
        picture of {PIXEL_BITS} bits a pixel.
    """
    fifo_text = f"""
        A scanline is fetched while the one above it is shown: its runs go first, one after the other, and
        the other port asks without a pause. Over {results["lines"]:,} lines of the monitor, refreshes among
        them: clocks from when a scanline is wanted to its last word, of those in which it has to be there,
        and the longest wait for a run. At most {most_line_clocks(SIZE[0], SdramGenerics())} clocks are
        proved.
    """
    chip_text = """
        Clocks of the data sheets' times, upwards. The last column: how far behind the controller's clock
        that of the chip may come, in ns of 10, from the chip's hold of its output to its own inputs' hold.
        That is with an FPGA without delay: its clock-to-pin time moves the end, its hold the beginning.
    """
    band_text = f"""
        Blocks of 18 kbit: colours of a band twice, so that one is written out while the next is drawn, and
        17 bits of depth. LFE5U-12F and 25F have {BLOCKS}; of these the board without its picture takes 6.
    """
    design_text = """
        Three ways to a whole picture. *Bands cut by the host*: every band's parts of the triangles are
        sent, each exactly cut. *Bands drawn from words in the memory*: the words are sent once and kept,
        and the core draws all of them for each band, whose other pixels are dropped. *Depth in the memory*:
        no bands; the depths of a span are read as a run, compared, and written back with the colours, each
        word masked that is not nearer. Bytes of CLEARs and a SWAP are among those on the line. Pictures a
        second that core and memory can give, then with the line, at 1 and 3 Mbaud.
    """
    scene_text = f"""
        What these come from: pixels of the triangles, their spans, clocks of the core, and of the memory
        with the depth in it. Both clears are added to the last, and showing the picture is taken off the
        memory's time. The last two columns are no calculation: clocks that the simulated board,
        `sim:{BOARD}`, was busy with a clear and the picture, its monitor on, and pictures a second at
        {HERTZ // 1_000_000} MHz on a line that is fast enough. Of those, runs differ by up to a tenth of a
        per cent: the host's commands come at any moment of the monitor's frame.
    """
    return f"""\
{LICENCE}
# A picture in SDRAM: the budget

{paragraph(about)}

## The memory's time

{paragraph(time_text)}

{markdown_table(("memory", "clocks", "shown", "refreshed", "written"), memory_rows(results))}

{paragraph(fifo_text)}

{markdown_table(("memory", "scanline, clocks", "of", "longest wait for a run"), fetches)}

## Chips

{paragraph(chip_text)}

{
        markdown_table(
            ("chip", "data sheet", "tRCD", "tRP", "tRAS", "tRC", "tRFC", "tWR", "tMRD", "clock, ns behind"),
            chips,
        )
    }

## Bands

{paragraph(band_text)}

{markdown_table(("scanlines", "bands", "colours", "depths", "together"), bands)}

## Pictures a second

{paragraph(design_text)}

{markdown_table(("scene", "design", "bytes", "times one", "core and memory", "1 Mbaud", "3 Mbaud"), speeds)}

{paragraph(scene_text)}

{markdown_table(("scene", "pixels", "spans", "core", "memory", "board", "pictures a second"), scenes)}
"""


@click.command(help=__doc__)
@click.option("--lines", type=click.IntRange(1), default=10_000, show_default=True, help="Of the monitor.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(lines: int, output: Path) -> None:
    results = measure(lines)
    write_report(output, report(results), results)
    click.echo(f"wrote {output}")


if __name__ == "__main__":
    main()
