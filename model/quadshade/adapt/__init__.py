# SPDX-License-Identifier: Apache-2.0
"""Spend where it shows: which triangles need a higher order or division, for an allowed error or a budget."""

from quadshade.adapt.adapted import ErrorCurve, adapt
from quadshade.adapt.centre_test import centre_error, centre_subdivision
from quadshade.adapt.cho import Subdivided, highlight_subdivision, regular_subdivision
from quadshade.adapt.choose import Goal, choose_orders
from quadshade.adapt.colour_shader import ColourShader
from quadshade.adapt.cosine_shader import CosineShader, LightShader
from quadshade.adapt.costs import ErrorFigures, error_figures, pixel_errors, stream_bytes
from quadshade.adapt.highlight import (
    highlight_centres,
    highlight_possible,
    potentially_highlighted,
    with_neighbours,
)
from quadshade.adapt.result import Adapted, Rival
from quadshade.scene.subdivide import insert_vertices, refine, shared_edges, split_edges

__all__ = [
    "Adapted",
    "ColourShader",
    "CosineShader",
    "ErrorCurve",
    "ErrorFigures",
    "Goal",
    "LightShader",
    "Rival",
    "Subdivided",
    "adapt",
    "centre_error",
    "centre_subdivision",
    "choose_orders",
    "error_figures",
    "highlight_centres",
    "highlight_possible",
    "highlight_subdivision",
    "insert_vertices",
    "pixel_errors",
    "potentially_highlighted",
    "refine",
    "regular_subdivision",
    "shared_edges",
    "split_edges",
    "stream_bytes",
    "with_neighbours",
]
