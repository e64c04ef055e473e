# SPDX-License-Identifier: Apache-2.0
"""Pictures that explain: the G-buffer pass, its edges, cool-to-warm tones and hatching."""

from quadshade.style.cartoon import smooth_tones
from quadshade.style.edges import EdgeMaps, draw_edges, find_edges
from quadshade.style.gbuffer import GBuffer, draw_gbuffer, sample_normals
from quadshade.style.gooch import gooch_material
from quadshade.style.hatch import hatch
from quadshade.style.illustrate import illustrate

__all__ = [
    "EdgeMaps",
    "GBuffer",
    "draw_edges",
    "draw_gbuffer",
    "find_edges",
    "gooch_material",
    "hatch",
    "illustrate",
    "sample_normals",
    "smooth_tones",
]
