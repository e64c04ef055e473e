# SPDX-License-Identifier: Apache-2.0
"""The edge map's formulas in floating point: what ``golden.screen.edge_map`` approximates."""

from __future__ import annotations

import numpy as np

from quadshade.golden.screen.edge_map import EIGHT, shifted

EDGE_ERROR = 0.53
"""Bound of the golden model's error in 255ths: half a step of rounding, constants, cut products."""


def edge_intensity(normal: np.ndarray, depth: np.ndarray, variant: int) -> tuple[np.ndarray, np.ndarray]:
    """
    Edge intensities of a G-buffer (Nienhaus and Döllner, Edge-Enhancement, 4.1.2), borders repeated.

    Parameters
    ----------
    normal : (h, w, 3) float
      Encoded normals, 0 .. 1: component c as (c + 1) / 2.
    depth : (h, w) float
      0 .. 1, linear in view distance.
    variant : int
      ``quadshade.golden.screen.edge_map.DIAGONAL`` or ``EIGHT``.

    Returns
    -------
    normal : (h, w) float
      ½((A·H) + (C·F)), clamped to 0 .. 1 as a colour is.
    depth : (h, w) float
      (1 − ½|A − H|)²(1 − ½|C − F|)²; or ⅛(|A − X| + 2|B − X| + ...), clamped to 1.
    """
    a, _, c, _, _, _, f, _, h = shifted(2 * np.asarray(normal, dtype=float) - 1)
    dots = 0.5 * ((a * h).sum(axis=2) + (c * f).sum(axis=2))
    a, b, c, d, x, e, f, g, h = shifted(np.asarray(depth, dtype=float))
    if variant == EIGHT:
        corners = sum(np.abs(z - x) for z in (a, c, f, h))
        jump = np.minimum((corners + 2 * sum(np.abs(z - x) for z in (b, d, e, g))) / 8, 1)
    else:
        jump = (1 - np.abs(a - h) / 2) ** 2 * (1 - np.abs(c - f) / 2) ** 2
    return np.clip(dots, 0, 1), jump
