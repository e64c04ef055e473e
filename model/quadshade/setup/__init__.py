# SPDX-License-Identifier: Apache-2.0
"""
Set-up on the host: exact edges, colour words with their error bound, and the set-up packet.

With what a program needs that sends words to a core of its own: triangles, formats, and the two steps
between them.
"""

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.files.triangle_file import open_triangles
from quadshade.setup.edges import Cut, cut_triangles
from quadshade.setup.packet import Primitives, pack
from quadshade.setup.triangle_setup import setup_triangles

__all__ = [
    "Cut",
    "Formats",
    "Primitives",
    "ScreenTriangles",
    "cut_triangles",
    "open_triangles",
    "pack",
    "setup_triangles",
]
