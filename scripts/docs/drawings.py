# SPDX-License-Identifier: Apache-2.0
"""
The drawings ``docs/images/drawing_*.svg``, from ``drawings.toml``: ``python -m scripts.docs.drawings``.

Colours follow the page that a drawing stands in, or else the reader's choice of light or dark.
"""

from __future__ import annotations

import sys
import tomllib
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from pathlib import Path

from quadshade.files.atomic import write_atomically
from scripts.docs.entity import ROOT

IMAGES = ROOT / "docs" / "images"
WIDTH, PITCH_X = 184, 240
HEIGHT, PITCH_Y = 58, 96
MARGIN, GROUP_MARGIN = 34, 14

STYLE = (
    ".drawing { --ink: var(--md-typeset-color, #1f2328); --fill: var(--md-code-bg-color, #eef1f4);"
    " --ground: var(--md-default-bg-color, #ffffff); }"
    " @media (prefers-color-scheme: dark) {"
    " .drawing { --ink: var(--md-typeset-color, #e6edf3); --fill: var(--md-code-bg-color, #30363d);"
    " --ground: var(--md-default-bg-color, #0d1117); } }"
    " .drawing text { fill: var(--ink); text-anchor: middle; font-size: 13px; }"
    " .drawing .name { font-weight: 600; }"
    " .drawing .title { text-anchor: start; font-weight: 600; }"
    " .drawing .title, .drawing .label { paint-order: stroke; stroke: var(--ground); stroke-width: 5px; }"
    " .drawing rect { fill: var(--fill); stroke: var(--ink); stroke-width: 1; }"
    " .drawing .group { fill: none; stroke-dasharray: 4 4; opacity: .6; }"
    " .drawing path { fill: none; stroke: var(--ink); stroke-width: 1.4; }"
    " .drawing .head { fill: var(--ink); stroke: none; }"
)


@dataclass(frozen=True)
class Box:
    """A box's name, the lines below it, and its corner."""

    name: str
    lines: tuple[str, ...]
    x: float
    y: float

    @property
    def centre(self) -> tuple[float, float]:
        """Its middle."""
        return self.x + WIDTH / 2, self.y + HEIGHT / 2


def descriptions() -> dict[str, dict[str, list]]:
    """What ``drawings.toml`` says of each drawing."""
    return tomllib.loads((Path(__file__).parent / "drawings.toml").read_text())


def draw(description: dict[str, list]) -> str:
    """
    A drawing as SVG.

    Raises
    ------
    KeyError
      An arrow or a group names a box that is not there.
    """
    boxes = {
        name: Box(name, tuple(lines), MARGIN + column * PITCH_X, MARGIN + row * PITCH_Y)
        for name, column, row, *lines in description["boxes"]
    }
    groups = [_group(title, [boxes[name] for name in names]) for title, *names in description["groups"]]
    parts = [frame for frame, _ in groups]
    parts += [_arrow(boxes[start], boxes[end], *rest) for start, end, *rest in description["arrows"]]
    # Last, so that no arrow runs through them.
    parts += [title for _, title in groups]
    parts += [_box(box) for box in boxes.values()]
    width = max(box.x for box in boxes.values()) + WIDTH + MARGIN
    height = max(box.y for box in boxes.values()) + HEIGHT + MARGIN
    size = f'viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}"'
    font = 'font-family="system-ui, sans-serif"'
    head = f'<svg class="drawing" xmlns="http://www.w3.org/2000/svg" {size} {font} role="img">'
    note = "<!-- SPDX-License-Identifier: Apache-2.0; written by scripts/docs/drawings.py -->"
    return "\n".join([head, note, f"<style>{STYLE}</style>", *parts, "</svg>"]) + "\n"


def _box(box: Box) -> str:
    x, y = box.centre
    first = y + 4.5 - 8 * len(box.lines)
    texts = [f'<text class="name" x="{x:g}" y="{first:g}">{escape(box.name.strip())}</text>']
    texts += [
        f'<text x="{x:g}" y="{first + 16 * (index + 1):g}">{escape(line)}</text>'
        for index, line in enumerate(box.lines)
    ]
    corner = f'x="{box.x:g}" y="{box.y:g}" width="{WIDTH}" height="{HEIGHT}" rx="5"'
    return "\n".join([f"<rect {corner} />", *texts])


def _group(title: str, boxes: list[Box]) -> tuple[str, str]:
    """The frame around boxes, and its title."""
    left, top = min(box.x for box in boxes) - GROUP_MARGIN, min(box.y for box in boxes) - GROUP_MARGIN
    right = max(box.x for box in boxes) + WIDTH + GROUP_MARGIN
    bottom = max(box.y for box in boxes) + HEIGHT + GROUP_MARGIN
    size = f'width="{right - left:g}" height="{bottom - top:g}"'
    return (
        f'<rect class="group" x="{left:g}" y="{top:g}" {size} rx="8" />',
        f'<text class="title" x="{left + 2:g}" y="{top - 6:g}">{escape(title)}</text>',
    )


def _arrow(start: Box, end: Box, label: str = "", way: str = "") -> str:
    """A straight arrow, or one with a corner: along the row first, or ``down`` the column first."""
    (x0, y0), (x1, y1) = start.centre, end.centre
    side, below = WIDTH / 2, HEIGHT / 2
    right, down = (1 if x1 > x0 else -1), (1 if y1 > y0 else -1)
    if y0 == y1:
        points = [(x0 + right * side, y0), (x1 - right * side, y1)]
    elif abs(x0 - x1) < side:
        points = [(x0, y0 + down * below), (x0, y1 - down * below)]
    elif way == "down":
        points = [(x0, y0 + down * below), (x0, y1), (x1 - right * side, y1)]
    else:
        points = [(x0 + right * side, y0), (x1, y0), (x1, y1 - down * below)]
    (xa, ya), (xb, yb) = points[-2:]
    path = "M" + " L".join(f"{x:g} {y:g}" for x, y in points)
    parts = [f'<path d="{path}" />', _head(xb, yb, xb - xa, yb - ya)]
    if label:
        # On the longest part of the way: above it, or to its right.
        (xa, ya), (xb, yb) = max(
            pairwise(points),
            key=lambda ends: abs(ends[0][0] - ends[1][0]) + abs(ends[0][1] - ends[1][1]),
        )
        if ya == yb:
            parts.append(f'<text class="label" x="{(xa + xb) / 2:g}" y="{ya - 7:g}">{escape(label)}</text>')
        else:
            place = f'x="{xa + 8:g}" y="{(ya + yb) / 2 + 4:g}" style="text-anchor: start"'
            parts.append(f'<text class="label" {place}>{escape(label)}</text>')
    return "\n".join(parts)


def _head(x: float, y: float, dx: float, dy: float) -> str:
    """An arrow's head, at its end."""
    length = abs(dx) + abs(dy)
    ux, uy = dx / length, dy / length
    corners = [(x, y), (x - 9 * ux - 4 * uy, y - 9 * uy + 4 * ux), (x - 9 * ux + 4 * uy, y - 9 * uy - 4 * ux)]
    return f'<path class="head" d="M{" L".join(f"{a:g} {b:g}" for a, b in corners)} Z" />'


def outdated() -> list[Path]:
    """Drawings that are not as their description says."""
    wanted = {IMAGES / f"drawing_{name}.svg": draw(given) for name, given in descriptions().items()}
    return [path for path, text in wanted.items() if not path.is_file() or path.read_text() != text]


def main() -> None:
    """Write the drawings."""
    for name, description in descriptions().items():
        text = draw(description)
        write_atomically(IMAGES / f"drawing_{name}.svg", lambda path, text=text: path.write_text(text))


if __name__ == "__main__":
    sys.exit(main())
