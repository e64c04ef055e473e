# SPDX-License-Identifier: Apache-2.0
"""Options for styles, edges and the G-buffer."""

from __future__ import annotations

import click

from quadshade.choices import EDGE_VARIANTS, GBUFFER_ORDERS, SPACES, STYLES
from quadshade.cli.options import PATH, Decorator, option

STYLE_OPTIONS: list[Decorator] = [
    option(
        "Style",
        "--style",
        type=click.Choice(STYLES),
        default=STYLES[0],
        show_default=True,
        help="cartoon: light in steps (--toon, else 4); gooch: cool-to-warm tones; hatch: strokes.",
    ),
    option(
        "Style",
        "--edges",
        metavar="KIND,...",
        help="Draw edges over the picture: profile (of depth), inner (of normals), or profile,inner.",
    ),
    option(
        "Style",
        "--edge-variant",
        type=click.Choice(EDGE_VARIANTS),
        default=EDGE_VARIANTS[0],
        show_default=True,
        help="Neighbours that depth's edges are found by: the diagonal ones, or all eight.",
    ),
    option(
        "Style",
        "--edge-color",
        "edge_colours",
        multiple=True,
        metavar="KIND=R,G,B",
        help="Colour of profile or inner edges, 0..1 (repeatable).  [default: black, and nearly black]",
    ),
]

GBUFFER_OPTIONS: list[Decorator] = [
    option(
        "Style",
        "--gbuffer",
        type=PATH,
        help="Write normals, depth and the triangle seen at every pixel, drawn by the engine, as NPZ.",
    ),
    option(
        "Style",
        "--gbuffer-order",
        type=click.Choice(tuple(GBUFFER_ORDERS)),
        default="quadratic",
        show_default=True,
        help="How normals are interpolated.",
    ),
    option(
        "Style",
        "--gbuffer-space",
        type=click.Choice(SPACES),
        default=SPACES[0],
        show_default=True,
        help="Axes of the normals.",
    ),
]
