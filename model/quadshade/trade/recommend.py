# SPDX-License-Identifier: Apache-2.0
"""One setting out of a sweep: the one that costs least and keeps an error, with its reason and command."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any, NamedTuple

from quadshade.choices import COSTS, FITS
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.trade.grid import ALL, Point
from quadshade.trade.subdivision import WHOLE
from quadshade.trade.view import View

COST_NAMES = {
    "bytes": "bytes a picture", "clocks": "clocks a picture", "lut4": "LUT4 of the core",
    "line": "bytes on the line",
}  # fmt: skip
CELL_WORDS = {"dsp": "multiplier", "bram": "block RAM"}
NEVER = "1e9"
"""Grey levels of rounding that no triangle reaches."""
COLUMNS = (
    "shading", "subdivision", "lod", "fit", "fraction bits", "largest error", "rms error", "bytes", "line",
    "clocks", "LUT4", "multipliers", "block RAM",
)  # fmt: skip
"""Of :func:`table`."""


class Recommendation(NamedTuple):
    """
    What to take.

    Attributes
    ----------
    record : dict
      The point of the sweep.
    reason : str
      Why it, in parts between semicolons.
    command : str
      A line that draws it.
    """

    record: dict[str, Any]
    reason: str
    command: str


def recommend(
    records: Sequence[dict[str, Any]], max_error: float, minimise: str, view: View, base: Formats
) -> Recommendation:
    """
    The point that costs least of those whose largest error is no more than allowed.

    Parameters
    ----------
    records : sequence of dict
      Of a sweep.
    max_error : float
      Grey levels; the largest difference of any pixel and channel from Phong shading of the same triangles.
    minimise : str
      ``bytes``, ``clocks`` or ``lut4``; of points that take as much of it, what takes less of the others.
    view : View
      Of the sweep, for the command.
    base : Formats
      Generics that the points do not set.

    Raises
    ------
    QuadshadeError
      The cost was not counted, or no point keeps the error.
    """
    drawn = [record for record in records if record["refused"] is None]
    if not drawn:
        raise QuadshadeError("no point of the sweep was drawn", "trade.json says why of each")
    known = [record for record in drawn if record.get(minimise) is not None]
    if not known:
        raise QuadshadeError(f"{COST_NAMES[minimise]} were not counted", "count cells, or give another cost")
    kept = [record for record in known if record["max_error"] <= max_error]
    if not kept:
        nearest = min(known, key=lambda record: record["max_error"])
        raise QuadshadeError(
            f"no point of the sweep has a largest error of {max_error:g} grey levels or less",
            f"the least is {nearest['max_error']} ({nearest['name']}): allow it, or sweep more fraction "
            "bits, shadings or subdivisions",
        )

    def costs(record: dict[str, Any]) -> tuple[float, ...]:
        others = [record[cost] for cost in COSTS if record.get(cost) is not None]
        return record[minimise], *others, record["rms"]

    kept.sort(key=costs)
    best = kept[0]
    few = f"{len(kept)} of {len(drawn)} points keep it" if len(kept) != 1 else "no other point keeps it"
    reason = (
        f"its largest error is {best['max_error']} of {max_error:g} grey {_plural(max_error, 'level')}; {few}"
        f", and this one takes the fewest {COST_NAMES[minimise]}, {best[minimise]}"
    )
    other = next((record for record in kept[1:] if record[minimise] > best[minimise]), None)
    if other is not None:
        reason += f"; the next, {other['name']}, takes {other[minimise]}"
    cheaper = [record for record in known if record[minimise] < best[minimise]]
    if cheaper:
        wrong = min(cheaper, key=lambda record: record["max_error"])
        reason += f"; of those that take less {wrong['name']} errs least, by {wrong['max_error']}"
    if best.get("lut4") is not None:
        multipliers, memories = (_plural(best[name], word) for name, word in CELL_WORDS.items())
        reason += (
            f"; its core takes {best['lut4']} LUT4, {best['dsp']} {multipliers}, {best['bram']} {memories}"
        )
    return Recommendation(best, reason, command(best, view, base))


def _plural(count: float, word: str) -> str:
    return word if count == 1 else f"{word}s"


def command(record: dict[str, Any], view: View, base: Formats) -> str:
    """
    A line that draws a point: ``quadshade render``, or where that cannot divide so, a sweep of one point.

    Parameters
    ----------
    record : dict
    view : View
    base : Formats
    """
    point = Point(record["shading"], record["fraction"], record["subdivision"], record["lod"], record["fit"])
    words = [view.scene, "--size", f"{view.width}x{view.height}"]
    options = (("--camera", view.camera), ("--material", view.material))
    words += [word for name, text in options if text for word in (name, text)]
    words += [word for text in view.lights for word in ("--light", text)]
    numbers = (("--exponent", view.exponent), ("--crease", view.crease))
    words += [word for name, number in numbers if number is not None for word in (name, f"{number:g}")]
    words += [] if view.cull else ["--no-cull"]
    if point.subdivision != WHOLE:
        generics = _given(base.generics(), Formats().generics())
        words += ["--shadings", point.shading, "--fractions", str(point.fraction)]
        words += ["--subdivisions", point.subdivision, *generics, "-o", "recommended"]
        words += [] if point.lod == ALL else ["--lods", point.lod]
        words += [] if point.fit == FITS[0] else ["--fits", point.fit]
        return shlex.join(["quadshade", "trade", *words])
    # An adaptive picture fits the other generics to what it picks.
    wanted = point.formats(base, view.num_lights).generics()
    if point.allowed is None:
        words += ["--shading", point.shading]
    else:
        words += ["--max-error", f"{point.allowed:g}", "--error-measure", "rms", "--shading", "quadratic"]
    words += [] if point.lod == ALL else ["--lod", point.lod]
    words += [] if point.fit == FITS[0] else ["--fit", point.fit]
    # A sweep shows what few fraction bits cost; `render` would divide triangles because of their rounding.
    words += ["--divide", NEVER] if point.fraction < Formats().frac_bits else []
    generics = _given(wanted, Formats().generics())
    return shlex.join(["quadshade", "render", *words, *generics, "-o", "recommended.png"])


def _given(generics: dict[str, int], defaults: dict[str, int]) -> list[str]:
    """Options for generics that are not the defaults."""
    given = [f"{name}={value}" for name, value in generics.items() if value != defaults[name]]
    return [word for text in given for word in ("--generic", text)]


def table(records: Sequence[dict[str, Any]]) -> list[str]:
    """
    Points as aligned columns, with a heading.

    Parameters
    ----------
    records : sequence of dict
      Drawn points; what was not counted is a dash.
    """
    rows: list[tuple[str, ...]] = [COLUMNS]
    for record in records:
        cells = [record.get(name) for name in ("bytes", "line", "clocks", "lut4", "dsp", "bram")]
        rows.append(
            (
                record["shading"], record["subdivision"], record["lod"], record["fit"],
                str(record["fraction"]), str(record["max_error"]),
                f"{record['rms']:.3f}", *("–" if cell is None else str(cell) for cell in cells),
            )
        )  # fmt: skip
    widths = [max(len(row[column]) for row in rows) for column in range(len(COLUMNS))]
    lines = []
    for row in rows:
        # Names to the left, numbers to the right.
        aligned = [
            cell.ljust(width) if column < 4 else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(aligned).rstrip())
    return lines
