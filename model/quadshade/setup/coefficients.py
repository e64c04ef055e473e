# SPDX-License-Identifier: Apache-2.0
"""
Forward differences of a triangle's quadratic on a primitive's pixel lattice.

Over the unit triangle a channel is ``P(u, v) = a u^2 + b v^2 + c u v + d u + e v + f`` with the coefficients
of Barrera et al., equations 18-22, and (u, v) is linear in the pixel (their equation 16): one division by the
doubled area, no special cases. A lattice point (m, N) lies m rows and N columns from the first pixel,
(u, v) = (u0, v0) + m p + N q, so with the symmetric form
``B(x, y) = 2a xu yu + 2b xv yv + c (xu yv + xv yu)`` and the gradient G at the first pixel

    value = P(u0, v0)      d_row = G(p) + B(p, p) / 2      d_col = G(q) - B(q, q) / 2
    dd_row = B(p, p)       dd_mixed = B(p, q)              dd_col = B(q, q)

and the hardware's sum ``value + m d_row + C(m, 2) dd_row + N d_col + m N dd_mixed + C(N + 1, 2) dd_col`` is P
again, ``value`` taken half a unit of what the lane emits higher, so that dropping the fraction rounds.

Every word is computed in float64 with a bound of its own error; where that is not small, in integers
(:func:`exact_words`).
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import CONSTANT, QUADRATIC
from quadshade.setup.edges import EdgeState, Head


class Frame(NamedTuple):
    """
    u and v of the first pixel, of the row step p and of the column step q, each over its denominator.

    A denominator may be negative.
    """

    u0: int
    v0: int
    den0: int
    pu: int
    pv: int
    denp: int
    qu: int
    qv: int
    denq: int


Ratios: TypeAlias = tuple[float, float, float, float, float, float]
"""u0, v0, p's u and v, q's u and v as floats."""

UNIT_ROUNDOFF = 2.0**-53
ROUNDINGS = 32
"""
No word passes more roundings than this from its samples to the end.

Each of u0, p, q takes three (two conversions, one division), a to f at most four. The longest chain is that
of value: 2 in a, 3 in each u0, 7 operations; d_row has 2 in a, 3 each in u0 and p, 6 operations, and less
through B. The rest covers products of roundings, and the rounding of the bounds themselves.
"""
FLOAT_LIMIT = 2.0**51
"""Above this a float64 has no fraction bit left to round by."""


@njit(cache=True, error_model="numpy")
def lattice_frame(corners: Ints, head: Head, major: EdgeState, pixel: int, fractional: bool) -> Frame:
    """
    Integers of (u0, v0), p and q of a primitive; ``corners`` (3, 2) are the triangle's, in sub-pixels.

    ``fractional`` puts the first pixel of a scanline at the major edge itself, one pixel a step from there
    (Abbas et al., section 5); where the major edge is the screen's border, at the pixel's centre as always.
    Widths: a row step is at most dx / dy + 1 < 2**26.7 / S (two scanlines lie S apart), so all products stay
    below 2**55.
    """
    x1, y1 = corners[0, 0], corners[0, 1]
    x2, y2 = corners[1, 0] - x1, corners[1, 1] - y1
    x3, y3 = corners[2, 0] - x1, corners[2, 1] - y1
    area = x2 * y3 - x3 * y2
    along = -pixel if head.mirror else pixel
    qu, qv = along * y3, -along * y2
    y = pixel * (2 * head.y + 1)
    if fractional and head.major_top >= 0:
        # The major edge runs between two corners, where u and v are 0 or 1.
        top, bottom = head.major_top, head.major_bottom
        height = corners[bottom, 1] - corners[top, 1]
        down = y - 2 * corners[top, 1]
        change_u = int(bottom == 1) - int(top == 1)
        change_v = int(bottom == 2) - int(top == 2)
        u0 = (top == 1) * 2 * height + down * change_u
        v0 = (top == 2) * 2 * height + down * change_v
        return Frame(u0, v0, 2 * height, pixel * change_u, pixel * change_v, height, qu, qv, area)
    column = -1 - major.column if head.mirror else major.column
    step = -major.step if head.mirror else major.step
    x, y = pixel * (2 * column + 1) - 2 * x1, y - 2 * y1
    u0, v0 = x * y3 - y * x3, x2 * y - y2 * x
    pu, pv = pixel * (step * y3 - x3), pixel * (x2 - step * y2)
    return Frame(u0, v0, 2 * area, pu, pv, area, qu, qv, area)


@njit(cache=True, error_model="numpy")
def lattice_ratios(frame: Frame) -> Ratios:
    """(u0, v0), p and q of a frame."""
    return (
        frame.u0 / frame.den0,
        frame.v0 / frame.den0,
        frame.pu / frame.denp,
        frame.pv / frame.denp,
        frame.qu / frame.denq,
        frame.qv / frame.denq,
    )


@njit(cache=True, error_model="numpy")
def float_words(
    samples: Floats,
    order: int,
    ratios: Ratios,
    scale: float,
    half: float,
    rows: bool,
    columns: bool,
    words: Floats,
    errors: Floats,
) -> None:
    """
    The six differences in units of the last place, and a bound of each one's error.

    Both are written, (6,) float64.

    ``ratios`` are :func:`lattice_ratios`; ``rows`` and ``columns`` say whether the primitive has a pixel with
    m > 0, N > 0; unused differences are zero.
    """
    words[:] = 0.0
    errors[:] = 0.0
    unit = ROUNDINGS * UNIT_ROUNDOFF * scale
    i1 = samples[0]
    s1 = abs(i1)
    if order == CONSTANT:
        words[0] = (i1 + half) * scale
        errors[0] = unit * (s1 + half)
        return
    i2, i3 = samples[1], samples[2]
    s2, s3 = abs(i2), abs(i3)
    u0, v0, pu, pv, qu, qv = ratios
    au0, av0, apu, apv, aqu, aqv = abs(u0), abs(v0), abs(pu), abs(pv), abs(qu), abs(qv)
    if order == QUADRATIC:
        i12, i13, i23 = samples[3], samples[4], samples[5]
        a = 2.0 * (i1 + i2 - 2.0 * i12)
        b = 2.0 * (i1 + i3 - 2.0 * i13)
        c = 4.0 * (i1 + i23 - i13 - i12)
        # Sums of magnitudes.
        s12, s13, s23 = abs(i12), abs(i13), abs(i23)
        aa, ab, ac = 2.0 * (s1 + s2 + 2.0 * s12), 2.0 * (s1 + s3 + 2.0 * s13), 4.0 * (s1 + s23 + s13 + s12)
    else:
        a = b = c = aa = ab = ac = 0.0
    d, e = i2 - i1 - a, i3 - i1 - b
    ad, ae = s2 + s1 + aa, s3 + s1 + ab
    words[0] = ((a * u0 + c * v0 + d) * u0 + (b * v0 + e) * v0 + i1 + half) * scale
    errors[0] = ((aa * au0 + ac * av0 + ad) * au0 + (ab * av0 + ae) * av0 + s1 + half) * unit
    gu, gv = 2.0 * a * u0 + c * v0 + d, 2.0 * b * v0 + c * u0 + e
    agu, agv = 2.0 * aa * au0 + ac * av0 + ad, 2.0 * ab * av0 + ac * au0 + ae
    if rows:
        square = 2.0 * (a * pu * pu + b * pv * pv + c * pu * pv)
        bound = 2.0 * (aa * apu * apu + ab * apv * apv + ac * apu * apv)
        words[1] = (gu * pu + gv * pv + 0.5 * square) * scale
        errors[1] = (agu * apu + agv * apv + 0.5 * bound) * unit
        words[3], errors[3] = square * scale, bound * unit
    if columns:
        square = 2.0 * (a * qu * qu + b * qv * qv + c * qu * qv)
        bound = 2.0 * (aa * aqu * aqu + ab * aqv * aqv + ac * aqu * aqv)
        words[2] = (gu * qu + gv * qv - 0.5 * square) * scale
        errors[2] = (agu * aqu + agv * aqv + 0.5 * bound) * unit
        words[5], errors[5] = square * scale, bound * unit
    if rows and columns:
        words[4] = (2.0 * (a * pu * qu + b * pv * qv) + c * (pu * qv + pv * qu)) * scale
        errors[4] = (2.0 * (aa * apu * aqu + ab * apv * aqv) + ac * (apu * aqv + apv * aqu)) * unit


def exact_words(
    samples: np.ndarray,
    order: int,
    frame: Frame,
    frac_bits: int,
    rows: bool,
    columns: bool,
    guard_bits: int = 0,
) -> tuple[np.ndarray, list[int]]:
    """
    The six differences in integers of any size: floor, fraction, for primitives beyond float64's reach.

    Parameters
    ----------
    samples : (6,) float64
    order : int
    frame : Frame
      From :func:`lattice_frame`.
    frac_bits : int
    rows, columns : bool
      As for :func:`float_words`.
    guard_bits : int
      The value is taken half of 2**-guard_bits higher.

    Returns
    -------
    fraction : (6,) float64
      In [0, 1), of a unit in the last place, rounded once.
    whole : list of int
    """
    used = [float(s).as_integer_ratio() for s in samples[: (1, 3, 6)[order]]]
    unit = max(den for _, den in used)
    i1, i2, i3, i12, i13, i23 = ([num * (unit // den) for num, den in used] + [0] * 5)[:6]
    u0, v0, den0, pu, pv, denp, qu, qv, denq = (int(f) for f in frame)
    a = b = c = d = e = 0
    if order == QUADRATIC:
        a, b, c = 2 * (i1 + i2 - 2 * i12), 2 * (i1 + i3 - 2 * i13), 4 * (i1 + i23 - i13 - i12)
    if order != CONSTANT:
        d, e = i2 - i1 - a, i3 - i1 - b

    def form(xu: int, xv: int, yu: int, yv: int) -> int:
        return 2 * a * xu * yu + 2 * b * xv * yv + c * (xu * yv + xv * yu)

    gu, gv = 2 * a * u0 + c * v0 + d * den0, 2 * b * v0 + c * u0 + e * den0
    pp, pq, qq = form(pu, pv, pu, pv), form(pu, pv, qu, qv), form(qu, qv, qu, qv)
    here = a * u0 * u0 + b * v0 * v0 + c * u0 * v0 + (d * u0 + e * v0) * den0 + i1 * den0 * den0
    ratios = [
        ((here << (guard_bits + 1)) + unit * den0 * den0, (den0 * den0) << (guard_bits + 1)),
        (2 * (gu * pu + gv * pv) * denp + pp * den0, 2 * den0 * denp * denp) if rows else (0, 1),
        (2 * (gu * qu + gv * qv) * denq - qq * den0, 2 * den0 * denq * denq) if columns else (0, 1),
        (pp, denp * denp) if rows else (0, 1),
        (pq, denp * denq) if rows and columns else (0, 1),
        (qq, denq * denq) if columns else (0, 1),
    ]
    whole, fraction = [], np.zeros(6)
    for difference, (num, den) in enumerate(ratios):
        quotient, rest = divmod(num << frac_bits, den * unit)
        whole.append(quotient)
        # Python divides integers correctly rounded; a quotient that rounds up to 1 is brought back.
        fraction[difference] = min(rest / (den * unit), 1.0 - UNIT_ROUNDOFF)
    return fraction, whole
