# SPDX-License-Identifier: Apache-2.0
"""
Set-up by a method of the literature: T0 to T5 in floating point, then the words of the hardware from them.

With X, Y counted from the origin vertex, ``I = T5 X^2 + T4 X Y + T3 Y^2 + T2 X + T1 Y + T0``, a row step
(s, 1) and a column step (c, 0) in pixels (Abbas et al., section 5, at pixel centres or along the fractional
edge):

    dd_row = 2 (T5 s^2 + T4 s + T3)    dd_mixed = 2 T5 s c + T4 c    dd_col = 2 T5 c^2
    d_row  = G . (s, 1) + dd_row / 2   d_col    = G . (c, 0) - dd_col / 2

with G the gradient at the first pixel. Nothing here mends what a method lost before.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.choices import OWN_SAMPLES, SETUPS
from quadshade.contract.arrays import Floats, Ints
from quadshade.errors import QuadshadeError
from quadshade.setup.edges import EdgeState, Head
from quadshade.setup.literature.methods import fit


class Steps(NamedTuple):
    """X and Y of the first pixel from the origin vertex, X of a row step and of a column step, in pixels."""

    x: float
    y: float
    row_x: float
    column_x: float


@dataclass(frozen=True)
class Terms:
    """
    Coefficients of triangles.

    Attributes
    ----------
    origins : (n,) int64
      The vertex from which X and Y are counted.
    values : (n, c, 6) float64
      T0 to T5 of every carried channel in output units and pixels; not finite where a method divides by zero.
    """

    origins: np.ndarray
    values: np.ndarray


def fit_terms(method: str, vertices: np.ndarray, samples: np.ndarray, subpixel_bits: int) -> Terms | None:
    """
    Coefficients of all channels by one of ``SETUPS``.

    Parameters
    ----------
    method : str
    vertices : (n, 3, 2) int64
      Sub-pixels.
    samples : (n, c, 6) float64
    subpixel_bits : int

    Returns
    -------
    Terms or None
      None for the methods that the lattice's own words are set up by.

    Raises
    ------
    QuadshadeError
      An unknown method.
    """
    if method not in SETUPS:
        raise QuadshadeError(f"there is no set-up {method!r}", f"give one of {', '.join(SETUPS)}")
    if method in ("unit", *OWN_SAMPLES):
        return None
    count, channels = samples.shape[:2]
    origins = np.zeros(count, dtype=np.int64)
    if method == "abbas" and count:
        # y points down: the bottom vertex has the largest.
        origins = np.argmax(vertices[:, :, 1], axis=1)
    turned = (origins[:, None] + np.arange(3)) % 3
    # I12, I13, I23 lie opposite the third, second and first vertex.
    middles = 5 - turned[:, ::-1]
    places = np.concatenate([turned, middles], axis=1)[:, None]
    corners = np.take_along_axis(vertices, turned[:, :, None], axis=1) / 2.0**subpixel_bits
    six = np.take_along_axis(samples, np.broadcast_to(places, samples.shape), axis=2)
    repeated = np.repeat(corners, channels, axis=0)
    return Terms(origins, fit(method, repeated, six.reshape(-1, 6)).reshape(count, channels, 6))


@njit(cache=True, error_model="numpy")
def lattice_steps(
    corners: Ints, origin: int, head: Head, major: EdgeState, pixel: int, fractional: bool
) -> Steps:
    """A primitive's first pixel and its steps."""
    x1, y1 = corners[origin, 0], corners[origin, 1]
    y = pixel * (2 * head.y + 1)
    down = (y - 2 * y1) / (2.0 * pixel)
    column_x = -1.0 if head.mirror else 1.0
    top, bottom = head.major_top, head.major_bottom
    if fractional and top >= 0:
        slope = (corners[bottom, 0] - corners[top, 0]) / (corners[bottom, 1] - corners[top, 1])
        along = (y - 2 * corners[top, 1]) / (2.0 * pixel)
        return Steps((corners[top, 0] - x1) / pixel + along * slope, down, slope, column_x)
    column = -1 - major.column if head.mirror else major.column
    x = (pixel * (2 * column + 1) - 2 * x1) / (2.0 * pixel)
    return Steps(x, down, float(-major.step if head.mirror else major.step), column_x)


@njit(cache=True, error_model="numpy")
def term_words(
    terms: Floats, steps: Steps, scale: float, half: float, rows: bool, columns: bool, words: Floats
) -> None:
    """The six differences of one channel in units of the last place (written); unused ones are zero."""
    t0, t1, t2, t3, t4, t5 = terms[0], terms[1], terms[2], terms[3], terms[4], terms[5]
    x, y, s, c = steps
    along_x, along_y = 2.0 * t5 * x + t4 * y + t2, 2.0 * t3 * y + t4 * x + t1
    words[:] = 0.0
    words[0] = (t5 * x * x + t4 * x * y + t3 * y * y + t2 * x + t1 * y + t0 + half) * scale
    if rows:
        words[3] = 2.0 * (t5 * s * s + t4 * s + t3) * scale
        words[1] = (along_x * s + along_y) * scale + 0.5 * words[3]
    if columns:
        words[5] = 2.0 * t5 * c * c * scale
        words[2] = along_x * c * scale - 0.5 * words[5]
    if rows and columns:
        words[4] = (2.0 * t5 * s + t4) * c * scale
