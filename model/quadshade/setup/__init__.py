# SPDX-License-Identifier: Apache-2.0
"""Set-up on the host: exact edges, colour words with their error bound, and the set-up packet."""

from quadshade.setup.edges import Cut, cut_triangles
from quadshade.setup.packet import Primitives, pack
from quadshade.setup.triangle_setup import setup_triangles

__all__ = ["Cut", "Primitives", "cut_triangles", "pack", "setup_triangles"]
