#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
What tiles cost against one screen that were large enough, and how fast several boards draw a picture.

Every tile is cut and packed, its frames' bytes are counted, and the golden model says the core's clocks. A
tile takes the clocks of the bytes that are sent, or of the core where it is slower, and those of the bytes
that are read. Boards take tiles as the pool gives them out, the dearest first. Some tiles are drawn by the
simulated board as well, and its clocks compared. Writes docs/reports/scale.md and scale.json.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import click

from quadshade.board import Board, BoardSettings
from quadshade.board.fallbacks import host_formats
from quadshade.board.tiled_picture import TiledPicture
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import MAX_PAYLOAD, PAYLOADS, WORD_BYTES, Opcode
from quadshade.engine.draw import draw_words
from quadshade.files.markdown import markdown_table
from quadshade.link.planes import pieces
from quadshade.packing.line import frame_bytes, frames_bytes
from quadshade.packing.pack import unpack
from quadshade.scene import fit_camera, load_scene, project
from quadshade.setup.refit import picture_formats
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

REPORT = REPORTS / "scale.md"
BITS_OF_A_BYTE = 10
WANTED_BYTES, WANTED_SPEED = 1.15, 3.6
ICEBREAKER = Formats(
    num_channels=1, with_depth=0, depth_bits=1, word_width=19, frac_bits=9, subpixel_bits=4, coord_bits=9
)
BOARDS = {
    "ULX3S 25F": (BoardSettings(screen_width=160, screen_height=120), 100_000_000),
    "ULX3S 85F": (BoardSettings(screen_width=320, screen_height=240), 100_000_000),
    "iCEBreaker": (
        BoardSettings(ICEBREAKER, screen_width=320, screen_height=240, single_port_memory=1, single_buffer=1),
        24_000_000,
    ),
}
"""Settings of each, but for its clock, and the clock in hertz."""

TILED = (
    ("sphere:690", 320, 240),
    ("icosphere:5", 320, 240),
    ("sphere:690", 640, 480),
    ("torus:1152", 320, 240),
)
"""Scenes and sizes that are compared with one large screen, on tiles of 160 x 120."""

SHARED = ("sphere:690", "icosphere:5")
SHARED_SIZE = (1280, 960)
COUNTS = (1, 2, 4, 8)
BAUDS = (1_000_000, 3_000_000)


class Taken(NamedTuple):
    """What a tile takes: bytes to the board and from it, clocks of the core."""

    sent: int
    received: int
    core: int

    def clocks(self, baud: int, hertz: int) -> float:
        """Clocks of the board: it draws while it is sent to, and then it is read."""
        byte = BITS_OF_A_BYTE * hertz / baud
        return max(self.sent * byte, float(self.core)) + self.received * byte


@cache
def picture_of(scene: str, size: tuple[int, int], board: Formats) -> TiledPicture:
    """A scene, set up for a board's formats."""
    formats = picture_formats([board], *size)
    mesh, shading = load_scene(scene), host_formats(formats)
    projected = project(mesh, fit_camera(mesh), *size, shading)
    picture = TiledPicture(formats, *size)
    picture.draw(sample(projected, "quadratic", formats=shading), 0.0)
    return picture


def frame(opcode: Opcode, more: int = 0) -> int:
    """Bytes of a frame on the line, with ``more`` bytes behind its fields."""
    return frame_bytes(PAYLOADS[opcode].field_bytes + more)


def take(picture: TiledPicture, board: Formats, tile: Rectangle) -> Taken:
    """What a session with a board of some formats sends and gets for a tile, and what its core takes."""
    parts = picture.parts(tile, board)
    size = board.emitted_channels
    reads = [piece.width * piece.height * size for piece in pieces(0, 0, tile.width, tile.height, size)]
    words = sum(len(part.words) for part in parts)
    acknowledged = 1 + sum(-(-len(part.words) * WORD_BYTES // MAX_PAYLOAD) for part in parts)
    # Whether the board was reset is asked before the picture is read, and before its CRC.
    asked = [Opcode.FRAME_CRC, Opcode.STATUS, Opcode.STATUS]
    answered = [Opcode.FRAME_CRC_ANSWER, Opcode.STATUS_ANSWER, Opcode.STATUS_ANSWER]
    sent = (
        frame(Opcode.CLEAR) + frames_bytes(words) + len(reads) * frame(Opcode.READ) + sum(map(frame, asked))
    )
    received = acknowledged * frame(Opcode.ACK) + sum(map(frame, answered))
    received += sum(frame(Opcode.READ_ANSWER, count) for count in reads)
    core = sum(draw_words(unpack(part.words, board), board).clocks for part in parts)
    return Taken(sent, received, core)


def compare(scene: str, width: int, height: int) -> dict:
    """Bytes and core clocks in tiles, and those of one screen."""
    row: dict = {"scene": scene, "size": [width, height]}
    formats = Formats()
    picture = picture_of(scene, (width, height), formats)
    for name, screen in (("one", (width, height)), ("tiles", (160, 120))):
        plan = [cost.tile for cost in picture.plan(screen, ("colour",))]
        # What one board of one screen does, without tiles: the whole picture is read.
        plan = plan if name == "tiles" else [Rectangle(0, 0, width, height)]
        taken = [take(picture, formats, tile) for tile in plan]
        row[name] = {
            "tiles": len(plan),
            "sent": sum(one.sent for one in taken),
            "received": sum(one.received for one in taken),
            "core": sum(one.core for one in taken),
        }
    return row


def schedule(jobs: list[float], count: int) -> float:
    """When the last of some boards is done that take jobs in their order, each as it gets free."""
    free = [0.0] * count
    for job in jobs:
        free[free.index(min(free))] += job
    return max(free)


def share(scene: str, name: str) -> list[dict]:
    """How long a picture takes on several boards of a kind, over the baud rates."""
    settings, hertz = BOARDS[name]
    picture = picture_of(scene, SHARED_SIZE, settings.formats)
    rows: list[dict] = []
    screen = (settings.screen_width, settings.screen_height)
    plans = {count: [cost.tile for cost in picture.plan(screen, ("colour",), count)] for count in COUNTS}
    wanted = {tile for plan in plans.values() for tile in plan}
    taken = {tile: take(picture, settings.formats, tile) for tile in wanted}
    for baud in BAUDS:
        one = 0.0
        for count, plan in plans.items():
            clocks = schedule([taken[tile].clocks(baud, hertz) for tile in plan], count)
            one = clocks if count == 1 else one
            rows.append(
                {
                    "scene": scene,
                    "board": name,
                    "baud": baud,
                    "boards": count,
                    "tiles": len(plan),
                    "clocks": round(clocks),
                    "frames_a_second": hertz / clocks,
                    "speed_up": one / clocks,
                }
            )
    return rows


def check(scene: str, tiles: int) -> list[dict]:
    """Clocks of tiles on the simulated board, and those computed."""
    settings = BoardSettings(screen_width=160, screen_height=120, with_packed_read=0)
    picture = picture_of(scene, (320, 240), settings.formats)
    rows = []
    with Board("sim", settings=settings, engine="verilator") as board:
        if board.simulated is None:
            raise AssertionError("a simulated board is simulated")
        engine = board.simulated.engine
        for cost in picture.plan((160, 120), ("colour",))[:tiles]:
            before = engine.counters()  # type: ignore[attr-defined]
            picture.draw_tile(board, cost.tile, ("colour",), "picture")
            after = engine.counters()  # type: ignore[attr-defined]
            clocks = {key: after[key] - before[key] for key in after}
            computed = take(picture, settings.formats, cost.tile).clocks(
                settings.baud, settings.clk_frequency_hz
            )
            rows.append({"tile": list(cost.tile), "computed": round(computed), **clocks})
    return rows


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    tiled = []
    for row in results["tiled"]:
        one, tiles = row["one"], row["tiles"]
        ratio = (tiles["sent"] + tiles["received"]) / (one["sent"] + one["received"])
        clocks = tiles["core"] / one["core"]
        verdict = "met" if max(ratio, clocks) <= WANTED_BYTES else "MISSED"
        tiled.append(
            (
                row["scene"],
                "x".join(map(str, row["size"])),
                tiles["tiles"],
                f"{one['sent']} + {one['received']}",
                f"{tiles['sent']} + {tiles['received']}",
                f"{ratio:.3f}",
                f"{tiles['sent'] / one['sent']:.3f}",
                f"{clocks:.3f}",
                f"≤ {WANTED_BYTES} {verdict}",
            )
        )
    shared = []
    for row in results["shared"]:
        four = row["boards"] == 4
        shared.append(
            (
                row["scene"],
                row["board"],
                row["baud"],
                row["boards"],
                row["tiles"],
                f"{row['clocks'] / 1e6:.1f}",
                f"{row['frames_a_second']:.3f}",
                f"{row['speed_up']:.2f}",
                f"≥ {WANTED_SPEED} {'met' if row['speed_up'] >= WANTED_SPEED else 'MISSED'}" if four else "",
            )
        )
    checked = [
        (
            "x".join(map(str, row["tile"][2:])),
            row["computed"],
            row["clocks"],
            row["receiving"] + row["sending"],
            f"{row['clocks'] / row['computed']:.3f}",
        )
        for row in results["checked"]
    ]
    about = f"""
        Written by `{results["command"]}` (`make scale`). All pictures are drawn exactly (`--pack-error 0`),
        and read whole, without packing; each is the golden model's byte for byte. Boards that
        [pack what is read](readback.md) take a part of the bytes that are read here.
    """
    tiles_text = """
        *One* is a screen as large as the picture, which is drawn and read whole. Bytes are to the board
        + from it; CLEAR, words, questions, answers, CRCs are among them. Triangles across a seam are sent for
        each side of it, but a tile covers only what is drawn, so fewer pixels are read.
    """
    shared_text = f"""
        {SHARED_SIZE[0]}x{SHARED_SIZE[1]} pixels. A tile takes the clocks of the bytes that are sent, or of
        the core where it is slower, and those of the bytes that are read; boards take tiles as they get
        free, the dearest first. Millions of clocks of the board until the last tile is read.
    """
    check_text = """
        Tiles of sphere:168 on the simulated board in Verilator, UART pins included, at 5 clocks a bit: clocks
        from the first byte to the last, beside those computed, and those in which the line is busy. The
        difference is the host's own time, in which the simulation runs on.
    """
    return f"""\
{LICENCE}
# Tiles, and boards that share them

{paragraph(about)}

## Tiles against one screen

{paragraph(tiles_text)}

{
        markdown_table(
            (
                "scene",
                "size",
                "tiles",
                "bytes, one",
                "bytes, tiles",
                "all bytes",
                "sent",
                "core clocks",
                "target",
            ),
            tiled,
        )
    }

## Boards

{paragraph(shared_text)}

{
        markdown_table(
            (
                "scene",
                "board",
                "baud",
                "boards",
                "tiles",
                "Mclocks",
                "frames a second",
                "times one",
                "target",
            ),
            shared,
        )
    }

## The computed clocks, checked

{paragraph(check_text)}

{markdown_table(("tile", "computed", "simulated", "line busy", "simulated / computed"), checked)}
"""


@click.command(help=__doc__)
@click.option("--tiles", default=3, show_default=True, help="Drawn by the simulated board too.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(tiles: int, output: Path) -> None:
    click.echo("comparing tiles with one screen", err=True)
    results = {
        "command": command_line("scale", tiles=tiles),
        "tiled": [compare(*case) for case in TILED],
        "shared": [row for scene in SHARED for name in BOARDS for row in share(scene, name)],
        "checked": check("sphere:168", tiles),
    }
    write_report(output, report(results), results)
    click.echo(report(results))


if __name__ == "__main__":
    main()
