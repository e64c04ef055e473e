# SPDX-License-Identifier: Apache-2.0
"""
Bytes of a triangle on the line part by part, and how few they could be; writes docs/reports/link_parts.*.

Beside the packets as they are stands a line that sends points instead: corners and edge middles, shared by
the triangles that have them, each as what a prediction leaves of it in a Rice code. The set-up would be the
board's. Entropies are those of a part's values, kind by kind, each by itself.
"""

from __future__ import annotations

from collections import defaultdict
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
from quadshade.files.markdown import markdown_table
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.packing.pack import Packed, pack_primitives
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.packet import field_values
from quadshade.setup.triangle_setup import setup_triangles
from scripts.experiments.link_bytes import CAMERAS, HEIGHT, WIDTH, triangles_of
from scripts.experiments.report_writer import LICENCE, REPORTS, output_option, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "link_parts.md"
SCENES = ("sphere:690", "torus:288", "icosphere:4", "examples/part.stl", "examples/pawn.obj")
SHADINGS = ("gouraud", "quadratic")

PARTS = ("connectivity", "position", "depth", "colour")
"""Connectivity: what is no number of a triangle, but says which numbers are sent."""

LEVEL = 32
"""Units of a grey level in which points' colours are sent: as much off as packing may add."""

TABLE = 64
"""Corners, and middles, that can be named again: the last ones."""

PREFIX, LONG = 15, 24
"""A Rice code with so many ones before it is sent whole, in so many bits."""

MOST_PARAMETER = 16
STARTS = 2 + 3
"""Bits of a triangle of points that are no number: its start and kind, orders, which corner it drops."""

TRIMS = 2
"""And how many scanlines without a pixel it has at both ends, about."""

EDGES = ((0, 1), (0, 2), (1, 2))


class Costs:
    """
    Bits by part, and the values that they stand for by kind.

    Attributes
    ----------
    bits : dict of str to float
    values : dict of (str, str) to list of int
      By part and kind.
    """

    def __init__(self) -> None:
        self.bits: dict[str, float] = defaultdict(float)
        self.values: dict[tuple[str, str], list[int]] = defaultdict(list)

    def add(self, part: str, kind: str, value: int, bits: float) -> None:
        """A value that takes some bits."""
        self.bits[part] += bits
        self.values[part, kind].append(int(value))

    def entropies(self) -> dict[str, float]:
        """Bits by part, if every value took what it tells among those of its kind."""
        out: dict[str, float] = defaultdict(float)
        for (part, _), values in self.values.items():
            _, counts = np.unique(values, return_counts=True)
            out[part] += float(counts @ np.log2(len(values) / counts))
        return out

    def rice(self) -> None:
        """Give every residual the bits of a Rice code, with the best parameter of its kind."""
        for (part, kind), values in self.values.items():
            if kind.startswith("residual"):
                self.bits[part] += rice_bits(np.array(values))


def rice_bits(values: np.ndarray) -> int:
    """Bits of (n,) residuals in the Rice code with the best parameter."""
    folded = np.where(values >= 0, 2 * values, -2 * values - 1)
    sums = []
    for parameter in range(MOST_PARAMETER):
        ones = folded >> parameter
        sums.append(int(np.where(ones < PREFIX, ones + 1 + parameter, PREFIX + LONG).sum()))
    return min(sums)


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


class _Points:
    """Triangles as points: what was sent last, and the costs so far."""

    def __init__(self, triangles: ScreenTriangles) -> None:
        assert triangles.depth is not None
        colours = np.swapaxes(np.rint(triangles.samples * LEVEL).astype(np.int64), 1, 2)
        depth = np.rint(triangles.depth).astype(np.int64)[:, :, None]
        self._corners = np.concatenate([triangles.vertices, depth, colours[:, :3]], axis=2)
        self._middles = colours[:, 3:]
        self._quadratic = triangles.orders.max(axis=1) > LINEAR
        self._tables: tuple[list[tuple], list[tuple]] = ([], [])
        self._last: tuple[list[tuple], dict[frozenset[int], tuple], bool] | None = None
        self.costs = Costs()

    def distinct(self, drawn: np.ndarray) -> tuple[int, int]:
        """How many corners, and middles of curved triangles, some triangles (n,) have in all."""
        corners = {tuple(point) for index in drawn.tolist() for point in self._corners[index].tolist()}
        middles = {
            (frozenset((tuple(self._corners[index, one]), tuple(self._corners[index, two]))), *middle)
            for index in drawn[self._quadratic[drawn]].tolist()
            for (one, two), middle in zip(EDGES, self._middles[index].tolist(), strict=True)
        }
        return len(corners), len(middles)

    def _is_known(self, point: tuple, table: list[tuple]) -> bool:
        """Name a point of a table; else put it there, to be sent."""
        known = point in table
        self.costs.add("connectivity", "named", int(known), 1)
        if known:
            place = len(table) - 1 - table.index(point)
            self.costs.add("connectivity", "place", place, TABLE.bit_length() - 1)
        else:
            table.append(point)
            del table[:-TABLE]
        return known

    def _colours(self, kind: str, left: np.ndarray) -> None:
        """What is left of colours; of all but the first, what is left of that again."""
        for value in np.diff(left, prepend=0):
            self.costs.add("colour", f"residual of a {kind}", value, 0)

    def _corner(self, point: tuple, base: np.ndarray) -> None:
        if not self._is_known(point, self._tables[0]):
            left = np.array(point) - base
            for value in left[:2]:
                self.costs.add("position", "residual", value, 0)
            self.costs.add("depth", "residual", left[2], 0)
            self._colours("corner", left[3:])

    def _middle(self, point: tuple, first: tuple, second: tuple) -> None:
        if not self._is_known(point, self._tables[1]):
            self._colours("middle", np.array(point) - ((np.array(first) + np.array(second))[3:] >> 1))

    def _order(self, corners: list[tuple], middles: dict[frozenset[int], tuple], curved: bool) -> tuple:
        """Which corner of the last triangle this one drops, 3 for no edge in common; its corners' order."""
        for drop in range(3) if self._last and (self._last[2] or not curved) else ():
            before, middles_before, _ = self._last
            kept = [before[corner] for corner in range(3) if corner != drop]
            if not all(point in corners for point in kept):
                continue
            one, two = (corners.index(point) for point in kept)
            pair = frozenset(corner for corner in range(3) if corner != drop)
            if one != two and (not curved or middles_before[pair] == middles[frozenset((one, two))]):
                return drop, [one, two, 3 - one - two]
        return 3, [0, 1, 2]

    def send(self, index: int) -> None:
        """A triangle."""
        corners = [tuple(point) for point in self._corners[index].tolist()]
        middles = {
            frozenset(edge): tuple(self._middles[index, place].tolist()) for place, edge in enumerate(EDGES)
        }
        curved = bool(self._quadratic[index])
        self.costs.bits["connectivity"] += STARTS + TRIMS
        drop, order = self._order(corners, middles, curved)
        sorted_corners = [corners[corner] for corner in order]
        one, two, three = sorted_corners
        if drop == 3:
            base = np.array(self._last[0][2] if self._last else np.zeros(len(one), np.int64))
            self._corner(one, base)
            self._corner(two, np.array(one))
            base = np.array(two)
        else:
            base = np.array(one) + np.array(two) - np.array(self._last[0][drop])
        self._corner(three, base)
        placed = {frozenset(edge): middles[frozenset(order[corner] for corner in edge)] for edge in EDGES}
        for edge in EDGES if curved else ():
            if drop == 3 or edge != (0, 1):
                self._middle(placed[frozenset(edge)], sorted_corners[edge[0]], sorted_corners[edge[1]])
        self._last = sorted_corners, placed, curved


def shared_costs(triangles: ScreenTriangles, drawn: np.ndarray) -> Costs:
    """What the triangles of some indices (n,) would take as points, part by part."""
    points = _Points(triangles)
    for index in drawn.tolist():
        points.send(index)
    points.costs.rice()
    return points.costs


def fixed_bits(triangles: ScreenTriangles, drawn: np.ndarray, formats: Formats) -> dict[str, float]:
    """Bits by part, if every point were sent once and every number in as many bits as any may need."""
    points = _Points(triangles)
    corners, middles = points.distinct(drawn)
    size = 1 << formats.subpixel_bits
    place = (triangles.width * size).bit_length() + (triangles.height * size).bit_length()
    colour = formats.num_channels * (((1 << formats.value_bits) - 1) * LEVEL).bit_length()
    return {
        "connectivity": 2.0 * len(drawn),
        "position": corners * place,
        "depth": corners * formats.depth_bits,
        "colour": (corners + middles) * colour,
    }


def part_rows(batch: Packed, formats: Formats, triangles: ScreenTriangles) -> list[dict]:
    """Bytes a triangle by part: packed, its entropy, as points, their entropy, points at fixed widths."""
    drawn = np.unique(batch.primitives.triangle)
    packed, points = packed_costs(batch, formats), shared_costs(triangles, drawn)
    rows = []
    for way, bits in (
        ("packed", packed.bits),
        ("entropy of packed", packed.entropies()),
        ("points", points.bits),
        ("entropy of points", points.entropies()),
        ("points, fixed widths", fixed_bits(triangles, drawn, formats)),
    ):
        sizes = {part: round(bits[part] / 8 / len(drawn), 2) for part in PARTS}
        rows.append({"way": way, **sizes, "all": round(sum(bits.values()) / 8 / len(drawn), 2)})
    return rows


def measure(scene: str, shading: str) -> list[dict]:
    """Rows of :func:`part_rows` with the scene's name, in perspective."""
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera(CAMERAS["perspective"], mesh), WIDTH, HEIGHT)
    triangles, formats = triangles_of(projected, shading)
    batch = pack_primitives(setup_triangles(triangles, formats, limit=MAX_ERROR), formats)
    return [{"scene": scene, "shading": shading} | row for row in part_rows(batch, formats, triangles)]


def report(rows: list[dict]) -> str:
    """The report's text, from nothing but the numbers."""
    cells = [tuple(str(value or "") for value in row.values()) for row in rows]
    table = markdown_table(("scene", "shading", "bytes of", *PARTS, "all"), cells)
    return f"""\
{LICENCE}
# Bytes on the line, part by part

Written by `make linkbytes`; {WIDTH}x{HEIGHT}, in perspective, packed to {PACK_ERROR:g} grey levels, without
frames.

- Packed: the packets of [packing.md](../reference/packing.md). Connectivity is what says which numbers come.
- Points: a line that would send corners and edge middles, each once for the triangles that have it, as long
  as it is among the last {TABLE}: x and y in sub-pixels, depth in whole units, colours in units of
  1/{LEVEL} grey level, each predicted, and what is left in a Rice code. Such a line needs the set-up on the
  board.
- Points, fixed widths: every point once, connectivity in two bits a triangle, and no code at all.
- Entropy: that of a part's values, kind by kind, each by itself. Of few values it is less than any code
  needs.

{table}

Where neighbours have corners in common, no code of the packets' own numbers comes near the points: what
edges, depth and colours share are those corners. The gear of part.stl has flat faces, whose corners have
colours of their own.
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
