#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Bytes of a triangle on the line, and what fewer of them cost in the picture; writes docs/reports/link_bytes.*.

Every scene is packed at several errors, counted in full frames with COBS, header and CRC, unpacked, drawn by
the golden model, and compared with Phong shading of the same triangles.
"""

from __future__ import annotations

import time
from pathlib import Path

import click
import numpy as np

from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.files.markdown import markdown_table
from quadshade.golden.shade import render_core
from quadshade.image.compare import psnr
from quadshade.packing.frame_file import line_bytes
from quadshade.packing.pack import pack_primitives, unpack
from quadshade.scene import Projected, load_scene, parse_camera, project
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import sample, sample_specular, specular_formats
from quadshade.shading.reference import phong
from scripts.experiments.report_writer import LICENCE, REPORTS, output_option, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "link_bytes.md"
WIDTH, HEIGHT = 320, 240
SCENES = ("sphere:690", "sphere:374", "sphere:168", "torus:288", "icosphere:4")
CAMERAS = {"perspective": "from=0,0,1", "orthographic": "from=0,0,1,ortho=1.05"}
SHADINGS = ("gouraud", "quadratic", "quadratic-specular")
ERRORS = (0.0, 1 / 64, PACK_ERROR, 1 / 16, 1 / 8)
HIGH_DB = 65
"""Above this a pixel that is one grey level off counts."""
PEERS = (("N64_MiSTer RDP", 112), ("RasterIX", 120), ("Celery3D", 121), ("pico-gs", 135), ("graphite", 148))
SPEED_SCENE = "sphere:200x200"


def triangles_of(projected: Projected, shading: str) -> tuple[ScreenTriangles, Formats]:
    """What is drawn, and the formats for it."""
    if shading.endswith("-specular"):
        formats = specular_formats({}, projected)
        return sample_specular(projected, shading, formats=formats), formats
    return sample(projected, shading), Formats()


def picture(words: np.ndarray, formats: Formats, triangles: ScreenTriangles) -> tuple[np.ndarray, tuple]:
    """(h, w, 3) uint8 picture of set-up words, and of what is seen: packet, place, depth order."""
    pixels = render_core.draw(words, formats, triangles.shade)
    colours = formats.emitted_channels
    depth = pixels.value[:, colours]
    # The nearest pixel of each place, the first of equals.
    order = np.lexsort((np.arange(len(depth)), depth, pixels.x, pixels.y))
    place = pixels.y[order].astype(np.int64) * WIDTH + pixels.x[order]
    seen = order[np.concatenate([[True], np.diff(place) != 0])]
    out = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    out[pixels.y[seen], pixels.x[seen]] = pixels.value[seen, :3]
    return out, (pixels.packet[seen], pixels.x[seen], pixels.y[seen])


def measure(scene: str, camera: str, shading: str) -> list[dict]:
    """A row for each error, the set-up words as they are first."""
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera(CAMERAS[camera], mesh), WIDTH, HEIGHT)
    triangles, formats = triangles_of(projected, shading)
    primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
    lanes = pack(primitives, formats)
    drawn = len(np.unique(primitives.triangle))
    whole, (packet, x, y) = picture(lanes, formats, triangles)
    reference = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    reference[y, x] = np.rint(phong(projected, primitives.triangle[packet], x, y))
    row = {"scene": scene, "camera": camera, "shading": shading, "triangles": drawn}
    rows = [
        row
        | {
            "error": None,
            "bytes": round(line_bytes(lanes) / drawn, 2),
            "added": 0.0,
            "psnr": round(float(psnr(whole, reference)), 2),
            "changed": 0,
            "largest": 0,
        }
    ]
    for error in ERRORS:
        batch = pack_primitives(primitives, formats, error, triangles.shade)
        drawing, _ = picture(unpack(batch.words, formats), formats, triangles)
        off = np.abs(drawing.astype(int) - whole).max(axis=2)
        rows.append(
            row
            | {
                "error": error,
                "bytes": round(line_bytes(batch.words) / drawn, 2),
                "added": round(batch.added, 4),
                "psnr": round(float(psnr(drawing, reference)), 2),
                "changed": int(np.count_nonzero(off)),
                "largest": int(off.max()),
            }
        )
    return rows


def triangles_per_second() -> dict[str, float]:
    """How fast the host packs, best of three, on one core."""
    mesh = load_scene(SPEED_SCENE)
    projected = project(mesh, parse_camera("from=0,0,1", mesh), WIDTH, HEIGHT)
    triangles, formats = triangles_of(projected, "quadratic")
    primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
    seconds = []
    for _ in range(3):
        begin = time.perf_counter()
        batch = pack_primitives(primitives, formats)
        seconds.append(time.perf_counter() - begin)
    begin = time.perf_counter()
    unpack(batch.words, formats)
    return {
        "packets": len(primitives),
        "pack_per_second": round(len(primitives) / min(seconds)),
        "unpack_per_second": round(len(primitives) / (time.perf_counter() - begin)),
    }


def label(error: float | None) -> str:
    """Name of a column."""
    return "set-up words" if error is None else f"{error:g}"


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    rows, speed = results["rows"], results["speed"]
    columns = (None, *ERRORS)
    cases = [rows[at : at + len(columns)] for at in range(0, len(rows), len(columns))]

    def table(figure: str) -> str:
        header = ("scene", "camera", "shading", "triangles", *map(label, columns))
        return markdown_table(
            header,
            [
                (
                    case[0]["scene"],
                    case[0]["camera"],
                    case[0]["shading"],
                    str(case[0]["triangles"]),
                    *(str(row[figure]) for row in case),
                )
                for case in cases
            ],
        )

    usual = [(case[0], row) for case in cases for row in case if row["error"] == PACK_ERROR]
    lost = [(whole["psnr"], whole["psnr"] - row["psnr"]) for whole, row in usual]
    usually, most = max(db for whole, db in lost if whole < HIGH_DB), max(db for _, db in lost)
    changed, largest = (max(row[name] for _, row in usual) for name in ("changed", "largest"))
    return f"""\
{LICENCE}
# Bytes on the line

Written by `make linkbytes`; {WIDTH}x{HEIGHT}, depth in every scene, default lights and material.
[packing.md](../reference/packing.md) is the format.

Mean bytes of a drawn triangle, everything on the line counted: TRIANGLES frames of at most 1016 bytes with
COBS, header and CRC. Columns: grey levels that packing may add, {PACK_ERROR:g} by default.

{table("bytes")}

Others, for colour that is linear (Gouraud) with depth, without frames or CRC:
{", ".join(f"{name} {size}" for name, size in PEERS)}.

## The picture

PSNR in dB against Phong shading of the same triangles:

{table("psnr")}

At {PACK_ERROR:g} no picture below {HIGH_DB} dB loses more than {usually:.2f} dB, no other more than
{most:.2f}. At most {changed} pixels of {WIDTH * HEIGHT} differ from the picture of the words as they were,
by {largest} grey level{"s" * (largest != 1)} at most.

## The host

{speed["packets"]} packets of {SPEED_SCENE}, one core: {speed["pack_per_second"]:,} packed a second,
{speed["unpack_per_second"]:,} unpacked.
"""


@click.command(help=__doc__)
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True, help="Repeatable.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scenes: tuple[str, ...], output: Path) -> None:
    rows = [
        row
        for scene in scenes
        for camera in CAMERAS
        for shading in SHADINGS
        for row in measure(scene, camera, shading)
    ]
    results = {"rows": rows, "speed": triangles_per_second()}
    write_report(output, report(results), results)
    click.echo(report(results), nl=False)


if __name__ == "__main__":
    main()
