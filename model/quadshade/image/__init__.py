# SPDX-License-Identifier: Apache-2.0
"""Framebuffer, PNG files and picture comparison."""

from quadshade.image.compare import Comparison, compare, largest_and_rms, write_heatmap
from quadshade.image.png import encode_png, read_picture, write_png
from quadshade.image.visible import paint, resolve, visible

__all__ = [
    "Comparison",
    "compare",
    "encode_png",
    "largest_and_rms",
    "paint",
    "read_picture",
    "resolve",
    "visible",
    "write_heatmap",
    "write_png",
]
