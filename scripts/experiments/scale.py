#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
What tiles cost against one screen that were large enough, and how fast several boards draw a picture.

Every tile is cut and packed, its frames' bytes are counted, read back the golden model packs its pixels, and
the golden model says the core's clocks. Boards take tiles as the pool gives them out, the dearest first. Some
tiles are drawn by the simulated board as well, and its clocks compared; a picture of 4096x4096 is drawn on
boards of 160x120, and compared with the golden model's. Writes docs/reports/scale.md and scale.json.
"""

from __future__ import annotations

import tempfile
import zlib
from pathlib import Path

import click
import numpy as np

import quadshade
from quadshade.board import Board, BoardSettings
from quadshade.contract.formats import Formats
from quadshade.files.markdown import markdown_table
from quadshade.setup.tile import Rectangle
from scripts.experiments.real_meshes import BUNNY, bunny
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    met,
    output_option,
    paragraph,
    write_report,
)
from scripts.experiments.tile_costs import CRC, PACKED, WHOLE, picture_of, schedule, take
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "scale.md"
WANTED_BYTES, WANTED_SPEED = 1.15, 3.6
ICEBREAKER = Formats(
    num_channels=1, with_depth=0, depth_bits=1, word_width=19, frac_bits=9, subpixel_bits=4, coord_bits=9
)
BOARDS = {
    "ULX3S 25F": (BoardSettings(screen_width=160, screen_height=120), 100_000_000),
    "ULX3S 85F": (BoardSettings(screen_width=320, screen_height=240), 100_000_000),
    "iCEBreaker": (
        BoardSettings(
            ICEBREAKER,
            screen_width=320,
            screen_height=240,
            single_port_memory=1,
            single_buffer=1,
            with_packed_read=0,
            crc_cycles=8,
        ),
        24_000_000,
    ),
}
"""Settings of each, but for its clock, and the clock in hertz."""

TILED = (
    ("sphere:690", 320, 240),
    ("sphere:690", 640, 480),
    ("torus:1152", 320, 240),
    (BUNNY, 640, 480),
)
"""Scenes and sizes that are compared with one large screen, on tiles of 160 x 120."""

SHARED = ("sphere:690", BUNNY)
SHARED_SIZE = (1280, 960)
COUNTS = (1, 2, 4, 8)
BAUDS = (1_000_000, 3_000_000)
LARGE = ("sphere:690", 4096)


def compare(scene: str, path: str, width: int, height: int) -> list[dict]:
    """Bytes and core clocks in tiles, and those of one screen: read whole, and packed."""
    rows: list[dict] = []
    settings = BoardSettings()
    picture = picture_of(path, (width, height), settings.formats)
    for way in (PACKED, WHOLE):
        row: dict = {"scene": scene, "size": [width, height], "read": way}
        for name, screen in (("one", (width, height)), ("tiles", (160, 120))):
            board = settings.with_generics({"screen_width": screen[0], "screen_height": screen[1]})
            plan = [cost.tile for cost in picture.plan(screen, ("colour",), packed=way == PACKED)]
            # What one board of one screen does, without tiles: the whole picture is read.
            plan = plan if name == "tiles" else [Rectangle(0, 0, width, height)]
            taken = [take(picture, board, tile)[way] for tile in plan]
            row[name] = {
                "tiles": len(plan),
                "sent": sum(one.sent for one in taken),
                "received": sum(one.received for one in taken),
                # Clearing is quick, and hidden behind what is sent.
                "core": sum(one.core for one in taken) - len(plan) * screen[0] * screen[1],
            }
        rows.append(row)
    return rows


def share(scene: str, path: str, name: str) -> list[dict]:
    """How long a picture takes on several boards of a kind, over the baud rates and ways to read."""
    settings, hertz = BOARDS[name]
    picture = picture_of(path, SHARED_SIZE, settings.formats)
    screen, packed = (settings.screen_width, settings.screen_height), bool(settings.with_packed_read)
    plans = {
        count: [cost.tile for cost in picture.plan(screen, ("colour",), count, packed)] for count in COUNTS
    }
    taken = {
        tile: take(picture, settings, tile) for tile in {tile for plan in plans.values() for tile in plan}
    }
    rows: list[dict] = []
    for baud in BAUDS:
        for way in (PACKED if packed else WHOLE, CRC):
            clocks = {
                count: schedule([taken[tile][way].clocks(baud, hertz) for tile in plan], count)
                for count, plan in plans.items()
            }
            rows.append(
                {
                    "scene": scene,
                    "board": name,
                    "baud": baud,
                    "read": way,
                    "triangles": picture.triangles,
                    "tiles": [len(plans[count]) for count in COUNTS],
                    "clocks": [round(clocks[count]) for count in COUNTS],
                    "frames_a_second": [hertz / clocks[count] for count in COUNTS],
                    "speed_up": [clocks[1] / clocks[count] for count in COUNTS],
                }
            )
    return rows


def check(scene: str, tiles: int) -> list[dict]:
    """Clocks of tiles on the simulated board, and those computed, in every way of reading."""
    rows = []
    for way in (WHOLE, PACKED, CRC):
        settings = BoardSettings(with_packed_read=int(way != WHOLE))
        picture = picture_of(scene, (320, 240), settings.formats)
        with Board("sim", settings=settings, engine="verilator") as board:
            if board.simulated is None:
                raise AssertionError("a simulated board is simulated")
            engine = board.simulated.engine
            for cost in picture.plan((160, 120), ("colour",))[:tiles]:
                before = engine.counters()  # type: ignore[attr-defined]
                picture.draw_tile(board, cost.tile, ("colour",), "crc" if way == CRC else "picture")
                after = engine.counters()  # type: ignore[attr-defined]
                clocks = {key: after[key] - before[key] for key in after}
                taken = take(picture, settings, cost.tile)[way]
                computed = taken.clocks(settings.baud, settings.clk_frequency_hz)
                rows.append({"read": way, "tile": list(cost.tile), "computed": round(computed), **clocks})
    return rows


def large(scene: str, side: int) -> dict:
    """A picture far beyond a board's screen, on two boards of 160x120, beside the golden model's."""
    model = quadshade.render(scene, size=(side, side), engine="model").array
    drawn = quadshade.render(scene, size=(side, side), port="sim:2", engine="model", verify="crc")
    line = drawn.stats.line or {}
    return {
        "scene": scene,
        "size": [side, side],
        "tiles": int(line["tiles"]),
        "bytes": int(line["bytes_sent"] + line["bytes_received"]),
        "differing": int(np.count_nonzero((drawn.array != model).any(axis=2))),
        "crc": f"{zlib.crc32(drawn.array.tobytes()):08x}",
        "model_crc": f"{zlib.crc32(model.tobytes()):08x}",
    }


def _tiled_row(row: dict) -> tuple:
    one, tiles = row["one"], row["tiles"]
    ratio = (tiles["sent"] + tiles["received"]) / (one["sent"] + one["received"])
    clocks = tiles["core"] / one["core"]
    return (
        row["scene"],
        "x".join(map(str, row["size"])),
        row["read"],
        tiles["tiles"],
        f"{one['sent']} + {one['received']}",
        f"{tiles['sent']} + {tiles['received']}",
        f"{ratio:.3f}",
        f"{tiles['sent'] / one['sent']:.3f}",
        f"{clocks:.3f}",
        met(max(ratio, clocks), WANTED_BYTES, most=True),
    )


def _shared_row(row: dict) -> tuple:
    four = row["speed_up"][COUNTS.index(4)]
    return (
        row["scene"],
        row["board"],
        row["baud"],
        row["read"],
        row["tiles"][0],
        *(f"{rate:.3g}" for rate in row["frames_a_second"]),
        f"{four:.2f}",
        f"{row['speed_up'][-1]:.2f}",
        met(four, WANTED_SPEED),
    )


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    tiled = [_tiled_row(row) for row in results["tiled"]]
    shared = [_shared_row(row) for row in results["shared"]]
    checked = [
        (
            row["read"],
            "x".join(map(str, row["tile"][2:])),
            row["computed"],
            row["clocks"],
            row["receiving"] + row["sending"],
            f"{row['clocks'] / row['computed']:.3f}",
        )
        for row in results["checked"]
    ]
    far = results["large"]
    equal = "equal" if not far["differing"] and far["crc"] == far["model_crc"] else "DIFFERENT"
    triangles = max(row["triangles"] for row in results["shared"])
    about = f"""
        Written by `{results["command"]}` (`make scale`). All pictures are drawn exactly (`--pack-error 0`):
        each is the golden model's byte for byte. *packed*: read back from boards that
        [pack what is read](readback.md); *whole*: from those that cannot, as iCEBreaker; *crc*: with
        `--verify crc`, which reads the CRC of a tile alone. {BUNNY} is the Stanford bunny of Debian's
        glmark2-data, a scan of 69,666 triangles, of which {triangles} face the viewer.
    """
    tiles_text = """
        *One* is a screen as large as the picture, which is drawn and read whole. Bytes are to the board
        + from it; CLEAR, words, questions, answers, CRCs are among them. Triangles across a seam are sent for
        each side of it, but a tile covers only what is drawn, so fewer pixels are read. *sent*: of the bytes
        to the board alone. Clocks of the core are those of drawing.
    """
    shared_text = f"""
        {SHARED_SIZE[0]}x{SHARED_SIZE[1]} pixels on 1, 2, 4 and 8 boards. Computed: a tile takes the
        clocks of the bytes that are sent, or of clearing and drawing where these take longer; then
        those of the bytes that are read, of the CRC over the screen, and of counting a packed answer's
        bits. Boards take tiles as they get free, the dearest first. Frames a second of one picture
        after the other, each in tiles; `turn` deals whole frames instead where there are enough of
        them, and then no board waits for another. An iCEBreaker takes 26 ms for the CRC of a screen of
        320x240, for every tile, and four of them have three times as many tiles of the bunny as one:
        where the line is fast that is the limit.
    """
    check_text = """
        Tiles of sphere:168 on the simulated board in Verilator, UART pins included, at 5 clocks a bit: clocks
        from the first byte to the last, beside those computed, and those in which the line is busy. The
        difference is the host's own time, in which the simulation runs on.
    """
    large_text = f"""
        {far["scene"]} at {far["size"][0]}x{far["size"][1]}, drawn on two boards of 160x120 in their
        golden model, line included, in {far["tiles"]} tiles with {far["bytes"]} bytes on both lines;
        each tile's CRC is the board's own. Against the golden model's picture, drawn at once:
        **{equal}**, {far["differing"]} pixels differ, CRC-32 {far["crc"]} and {far["model_crc"]}.
    """
    heads = (
        "scene",
        "size",
        "read",
        "tiles",
        "bytes, one",
        "bytes, tiles",
        "all bytes",
        "sent",
        "core clocks",
    )
    rates = ("1, frames/s", "2", "4", "8")
    return f"""\
{LICENCE}
# Tiles, and boards that share them

{paragraph(about)}

## Tiles against one screen

{paragraph(tiles_text)}

{markdown_table((*heads, "target"), tiled)}

## Boards

{paragraph(shared_text)}

{
        markdown_table(
            ("scene", "board", "baud", "read", "tiles, 1", *rates, "4 times one", "8 times one", "target"),
            shared,
        )
    }

## The computed clocks, checked

{paragraph(check_text)}

{markdown_table(("read", "tile", "computed", "simulated", "line busy", "simulated / computed"), checked)}

## A picture far beyond the screen

{paragraph(large_text)}
"""


@click.command(help=__doc__)
@click.option("--tiles", default=3, show_default=True, help="Drawn by the simulated board too, in each way.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(tiles: int, output: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        paths = {BUNNY: str(bunny(Path(folder)))}
        results: dict = {"command": command_line("scale", tiles=tiles)}
        click.echo("checking the clocks on the simulated board", err=True)
        results["checked"] = check("sphere:168", tiles)
        click.echo("comparing tiles with one screen", err=True)
        results["tiled"] = [
            row for scene, *size in TILED for row in compare(scene, paths.get(scene, scene), *size)
        ]
        results["shared"] = []
        for scene in SHARED:
            for name in BOARDS:
                click.echo(f"{scene} on {name}", err=True)
                results["shared"] += share(scene, paths.get(scene, scene), name)
        click.echo(f"drawing {LARGE[0]} at {LARGE[1]}x{LARGE[1]}", err=True)
        results["large"] = large(*LARGE)
    write_report(output, report(results), results)
    click.echo(report(results))


if __name__ == "__main__":
    main()
