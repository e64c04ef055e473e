# SPDX-License-Identifier: Apache-2.0
"""
Bytes of a triangle on the line part by part, and how few they could be; writes docs/reports/link_parts.*.

Beside both kinds of packets stands a line that sends points: corners and edge middles, shared by the
triangles that have them, each as what a prediction leaves of it in a Rice code; and the limit of a closed
mesh, where each triangle owns half a corner and one and a half middles. Entropies are those of a part's
values, kind by kind, each by itself.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.contract.formats import DIFFERENCES_OF_ORDER, LINEAR, Formats
from quadshade.contract.packed_format import (
    CHANNEL_KINDS,
    KIND_WIDTHS,
    channel_kinds,
    kind_of,
    packed_fields,
    second_at,
)
from quadshade.contract.triangles import ScreenTriangles
from quadshade.contract.vertex_program import LONG_BITS, LONGEST_PREFIX
from quadshade.files.markdown import markdown_table
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.packing.neighbours import ordered_for_vertices
from quadshade.packing.pack import Packed, pack_primitives
from quadshade.packing.pack_vertices import VertexPacked, choose_vertices
from quadshade.packing.vertex_code import BITS, NUM_CODED, ONES, Tokens, code_parameters
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.packet import field_values
from quadshade.setup.triangle_setup import setup_triangles
from scripts.experiments.link_bytes import CAMERAS, HEIGHT, WIDTH, triangles_of
from scripts.experiments.report_writer import LICENCE, REPORTS, output_option, paragraph, write_report
from scripts.experiments.shared_points import LEVEL, TABLE, Costs, SharedPoints, rice_bits, shared_costs
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "link_parts.md"
SCENES = ("sphere:690", "torus:288", "icosphere:4", "examples/part.stl", "examples/pawn.obj")
SHADINGS = ("gouraud", "quadratic")

PARTS = ("connectivity", "position", "depth", "colour")
"""Connectivity: what is no number of a triangle, but says which numbers are sent."""

RESIDUALS = ("position", "colour", "depth", "colour")
"""Parts of a vertex packet's coded numbers, by their kind."""

OWN_CORNERS, OWN_MIDDLES = 1 / 2, 3 / 2
"""Of a triangle of a large closed mesh: it has half as many corners as triangles, and 3/2 as many edges."""

LIMIT_STARTS = 2
"""Bits of a triangle at the limit that are no number."""


def packed_costs(batch: Packed, formats: Formats) -> Costs:
    """What the packets of today take, part by part."""
    costs, unpacker, primitives = Costs(), WordUnpacker(formats), batch.primitives
    fields, kinds = packed_fields(formats), channel_kinds(formats)
    raw = {name: field_values(primitives, name, formats) for name, *_ in fields}
    has_second = primitives.header["has_second"]
    for p, (start, end, _) in enumerate(unpacker.packets(batch.words)):
        widths, known = unpacker.widths, 0
        for name, bits, address, _ in fields[: len(fields) if has_second[p] else second_at(formats)]:
            size = min(widths[address] + 1, bits)
            costs.add("position", kind_of(name), raw[name][p], size)
            known += size
        for channel, kind in enumerate(kinds):
            part = "depth" if CHANNEL_KINDS[kind] == "depth" else "colour"
            for difference in range(DIFFERENCES_OF_ORDER[primitives.orders[p, channel]]):
                address = KIND_WIDTHS * kind + 2 * difference
                below = widths[address]
                size = max(widths[address + 1] + 1 - below, 0)
                word = int(primitives.words[p, channel, difference]) >> below
                costs.add(part, f"difference {difference}", word, size)
                known += size
        costs.bits["connectivity"] += end - start - known
    return costs


def vertex_costs(tokens: Tokens) -> Costs:
    """What packets with vertices take, but for the runs of packed words between them."""
    costs, parameters = Costs(), np.zeros(NUM_CODED, np.int64)
    code_parameters(tokens, len(tokens.kinds), parameters)
    for kind, value, size in zip(*(column.tolist() for column in tokens), strict=True):
        if kind == BITS:
            costs.add("connectivity", f"{size} bits", value, size)
        elif kind == ONES:
            costs.add("connectivity", "trims", value, value + (value < LONGEST_PREFIX))
        elif kind < NUM_CODED:
            k = int(parameters[kind])
            ones = ((2 * value if value >= 0 else -2 * value - 1) >> k) + 1
            size = 2 * ones.bit_length() - 1 + k
            if ones.bit_length() > LONGEST_PREFIX:
                size = LONGEST_PREFIX + LONG_BITS
            costs.add(RESIDUALS[kind], f"kind {kind}", value, size)
    return costs


def fixed_widths(triangles: ScreenTriangles, formats: Formats) -> tuple[int, int, int]:
    """Bits of a place on the screen, of its depth, and of colours: as many as any may need."""
    size = 1 << formats.subpixel_bits
    place = (triangles.width * size).bit_length() + (triangles.height * size).bit_length()
    colour = formats.num_channels * (((1 << formats.value_bits) - 1) * LEVEL).bit_length()
    return place, formats.depth_bits, colour


def fixed_bits(triangles: ScreenTriangles, drawn: np.ndarray, formats: Formats) -> dict[str, float]:
    """Bits by part, if every point were sent once and every number in as many bits as any may need."""
    points = SharedPoints(triangles)
    corners, middles = points.distinct(drawn)
    place, depth, colour = fixed_widths(triangles, formats)
    return {
        "connectivity": LIMIT_STARTS * len(drawn),
        "position": corners * place,
        "depth": corners * depth,
        "colour": (corners + middles) * colour,
    }


def limit_bits(corner: dict[str, float], middle: float) -> dict[str, float]:
    """Bits of a triangle by part, if each owns its share of a corner (by part) and of a middle alone."""
    return {
        "connectivity": LIMIT_STARTS,
        **{part: OWN_CORNERS * corner[part] for part in ("position", "depth")},
        "colour": OWN_CORNERS * corner["colour"] + OWN_MIDDLES * middle,
    }


def coded_limit(points: Costs, formats: Formats) -> dict[str, float]:
    """:func:`limit_bits` where a point takes what the points that were sent take on the average."""
    values = {kind: np.array(values) for kind, values in points.values.items()}
    corners = len(values["depth", "residual"])
    kinds = {"position": "residual", "depth": "residual", "colour": "residual of a corner"}
    middles = values.get(("colour", "residual of a middle"), np.zeros(0, np.int64))
    return limit_bits(
        {part: rice_bits(values[part, kind]) / corners for part, kind in kinds.items()},
        rice_bits(middles) * formats.num_channels / len(middles) if len(middles) else 0.0,
    )


def fixed_limit(triangles: ScreenTriangles, formats: Formats) -> dict[str, float]:
    """:func:`limit_bits` where every number has as many bits as any may need."""
    place, depth, colour = fixed_widths(triangles, formats)
    curved = triangles.orders.max() > LINEAR
    return limit_bits({"position": place, "depth": depth, "colour": colour}, colour if curved else 0)


def part_rows(
    batch: Packed, formats: Formats, triangles: ScreenTriangles, chosen: VertexPacked | None
) -> list[dict]:
    """
    Bytes a triangle by part, and how far all of them are above the limit.

    Parameters
    ----------
    batch : Packed
      The packets as fields.
    formats : Formats
    triangles : ScreenTriangles
    chosen : VertexPacked or None
      What goes as vertices; its rows are of those that do.
    """
    drawn = np.unique(batch.primitives.triangle)
    packed, points = packed_costs(batch, formats), shared_costs(triangles, drawn)
    ways = [("packed", packed.bits, len(drawn)), ("entropy of packed", packed.entropies(), len(drawn))]
    if chosen is not None:
        costs, sent = vertex_costs(chosen.tokens()), int(np.count_nonzero(chosen.sent))
        ways += [("vertices", costs.bits, sent), ("entropy of vertices", costs.entropies(), sent)]
    limit = coded_limit(points, formats)
    ways += [
        ("points", points.bits, len(drawn)),
        ("entropy of points", points.entropies(), len(drawn)),
        ("points, fixed widths", fixed_bits(triangles, drawn, formats), len(drawn)),
        ("limit, fixed widths", fixed_limit(triangles, formats), 1),
        ("limit", limit, 1),
    ]
    rows = []
    for way, bits, count in ways:
        sizes = {part: round(bits.get(part, 0.0) / 8 / count, 2) for part in PARTS}
        total = sum(bits.values()) / 8 / count
        above = round(total - sum(limit.values()) / 8, 2)
        rows.append({"way": way, **sizes, "all": round(total, 2), "above": above})
    return rows


def measure(scene: str, shading: str) -> list[dict]:
    """Rows of :func:`part_rows` with the scene's name, in perspective."""
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera(CAMERAS["perspective"], mesh), WIDTH, HEIGHT)
    triangles, formats = triangles_of(projected, shading)
    # As they are sent: from neighbour to neighbour.
    triangles = ordered_for_vertices(triangles, formats)
    primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
    batch = pack_primitives(primitives, formats)
    chosen = choose_vertices(primitives, triangles, formats, PACK_ERROR)
    rows = part_rows(batch, formats, triangles, chosen)
    return [{"scene": scene, "shading": shading} | row for row in rows]


def report(rows: list[dict]) -> str:
    """The report's text, from nothing but the numbers."""
    cells = [tuple("" if value == 0 else str(value) for value in row.values()) for row in rows]
    table = markdown_table(("scene", "shading", "bytes of", *PARTS, "all", "above the limit"), cells)
    limits = [row["all"] for row in rows if (row["way"], row["shading"]) == ("limit", "quadratic")]
    fixed = [
        row["all"] for row in rows if (row["way"], row["shading"]) == ("limit, fixed widths", "quadratic")
    ]
    last = paragraph(
        f"""
        The limit of a quadratic triangle is {min(limits)} to {max(limits)} bytes, and {max(fixed)} at fixed
        widths; only an entropy can be below it. Where neighbours have corners in common, no code of the
        packed numbers comes near the points: what edges, depth and colours share are those corners.
        """
    )
    return f"""\
{LICENCE}
# Bytes on the line, part by part

Written by `make linkbytes`; {WIDTH}x{HEIGHT}, in perspective, packed to {PACK_ERROR:g} grey levels, without
frames.

- Packed: the packets of [packing.md](../reference/packing.md). Connectivity is what says which numbers come.
- Vertices: those of [vertices.md](../reference/vertices.md), of the triangles that go as vertices.
- Points: a line that would send corners and edge middles, each once for the triangles that have it, as long
  as it is among the last {TABLE}: x and y in sub-pixels, depth in whole units, colours in units of
  1/{LEVEL} grey level, each predicted, and what is left in a Rice code.
- Points, fixed widths: every point once, connectivity in two bits a triangle, and no code at all.
- Limit: a triangle of a large closed mesh owns half a corner and one and a half middles; each takes what
  those points take on the average, and connectivity two bits. Beside it the same at fixed widths.
- Entropy: that of a part's values, kind by kind, each by itself. Of few values it is less than any code
  needs.

{table}

{last}
"""


@click.command(help=__doc__)
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True, help="Repeatable.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scenes: tuple[str, ...], output: Path) -> None:
    rows = [row for scene in scenes for shading in SHADINGS for row in measure(scene, shading)]
    write_report(output, report(rows), rows)
    click.echo(report(rows), nl=False)


if __name__ == "__main__":
    main()
