# SPDX-License-Identifier: Apache-2.0
"""
Rounding of a channel's words, jointly or each by itself, with a rigorous bound of what it costs.

With words off by (v, r, c, rr, rc, cc) units the hardware's sum is off by the polynomial

    E(m, N) = v + m r + C(m, 2) rr + N c + m N rc + C(N + 1, 2) cc

on a primitive's lattice points, which lie in one trapezoid of (m, N) per minor edge. Joint rounding takes the
second differences that leave the least after a fitted linear function (of floor and ceiling each, eight
ways), then d_row and d_col that take that function away, then the value that centres E. The bound is E's true
maximum over the trapezoids: corners, edges, inside.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Ints, Records, record_dtype
from quadshade.contract.formats import CONSTANT, DIFFERENCES_OF_ORDER, QUADRATIC
from quadshade.setup.edges import EdgeState, Head


class Fit:
    """
    Columns of the linear functions of (m, N) nearest to E's three quadratics, a, b and c.

    ``mm``, ``mn`` and ``nn`` are sums over the sample points of products of m and N about their means, ``am``
    to ``cn`` the functions' slopes along m and along N, ``aa`` to ``cc`` sums of products of what the
    functions leave of the quadratics.
    """

    mm: float
    mn: float
    nn: float
    am: float
    bm: float
    cm: float
    an: float
    bn: float
    cn: float
    aa: float
    ab: float
    ac: float
    bb: float
    bc: float
    cc: float


FIT = record_dtype(Fit)
SixFloats: TypeAlias = tuple[float, float, float, float, float, float]

SAMPLE_POINTS = 11
HALF_RANGE = 1.75
"""Half a range over the sample points' standard deviation: that of an even distribution, about."""
LEAST_SPREAD = 2.0**-6

OUTWARD = 2.0**-30
"""
Corners are moved out by this: they are ratios of exact integers, below 2**15, float64 is 2**-37 off at most.
"""
SLACK = 2.0**-18
"""
Rounding in E's own evaluation, in units of the last place: terms below 2**29, a dozen operations of 2**-53.
"""


@njit(cache=True, error_model="numpy")
def _lower(major: EdgeState, k: int) -> float:
    """No pixel of row k has a smaller N: floor((e + k r) / dy) is at least this."""
    return (major.remainder + k * major.increment - major.height + 1) / major.height - OUTWARD


@njit(cache=True, error_model="numpy")
def _upper(major: EdgeState, minor: EdgeState, k: int, since: int) -> float:
    """No pixel of row k has a larger N; the minor edge began ``since`` rows before."""
    ahead = minor.column - major.column - 1 - k * major.step + since * minor.step
    return ahead + (minor.remainder + since * minor.increment) / minor.height + OUTWARD


@njit(cache=True, error_model="numpy")
def region(head: Head, edges: Records, fractional: bool, corners: Floats) -> int:
    """
    Corners (m, N) of the trapezoids that hold a primitive's lattice points (written); their number, 4 or 8.

    Each trapezoid goes round: first row low, first row high, last row high, last row low.
    """
    first, rows = head.rows_first, head.rows_first + head.rows_second
    count = 0
    for which, start, end in ((1, 0, first), (2, first, rows)):
        for side in range(4 if end > start else 0):
            k = start if side < 2 else end - 1
            low, high = _lower(edges[0], k), _upper(edges[0], edges[which], k, k - start)
            if rows <= 2:
                # Two rows: the bounds, less than a pixel from the points, round to them.
                low, high = np.ceil(low), np.floor(high)
            if fractional:
                low, high = 0.0, high - low
            corners[count, 0], corners[count, 1] = k, high if side in (1, 2) else low
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def fit_linear(corners: Floats, count: int, scratch: Floats, fit: Fit) -> None:
    """
    Least-squares linear functions through E's three quadratics, over corners and edge middles of a primitive.

    The quadratics are C(m, 2), m N and C(N + 1, 2). Near-collinear points are held by a small ridge.

    Parameters
    ----------
    corners, count
      From :func:`region`.
    scratch : (SAMPLE_POINTS, 5) float64, written
    fit : Fit, written
    """
    # Top low, top high, knee high, bottom high, bottom low; the middles of these five sides; one inside.
    for place in range(5):
        corner = place if place < 3 else count - 5 + place
        scratch[place, 0], scratch[place, 1] = corners[corner, 0], corners[corner, 1]
    for place in range(5):
        follower = place + 1 if place < 4 else 0
        scratch[5 + place, 0] = 0.5 * (scratch[place, 0] + scratch[follower, 0])
        scratch[5 + place, 1] = 0.5 * (scratch[place, 1] + scratch[follower, 1])
    scratch[10, 0] = 0.5 * (scratch[2, 0] + scratch[9, 0])
    scratch[10, 1] = 0.5 * (scratch[2, 1] + scratch[9, 1])
    mean_m = mean_n = mean_a = mean_b = mean_c = 0.0
    for place in range(SAMPLE_POINTS):
        m, n = scratch[place, 0], scratch[place, 1]
        a, b, c = 0.5 * m * (m - 1.0), m * n, 0.5 * n * (n + 1.0)
        scratch[place, 2], scratch[place, 3], scratch[place, 4] = a, b, c
        mean_m, mean_n = mean_m + m, mean_n + n
        mean_a, mean_b, mean_c = mean_a + a, mean_b + b, mean_c + c
    share = 1.0 / SAMPLE_POINTS
    mean_m, mean_n = mean_m * share, mean_n * share
    mean_a, mean_b, mean_c = mean_a * share, mean_b * share, mean_c * share
    mm = mn = nn = ma = mb = mc = na = nb = nc = aa = ab = ac = bb = bc = cc = 0.0
    for place in range(SAMPLE_POINTS):
        m, n = scratch[place, 0] - mean_m, scratch[place, 1] - mean_n
        a, b, c = scratch[place, 2] - mean_a, scratch[place, 3] - mean_b, scratch[place, 4] - mean_c
        mm, mn, nn = mm + m * m, mn + m * n, nn + n * n
        ma, mb, mc = ma + m * a, mb + m * b, mc + m * c
        na, nb, nc = na + n * a, nb + n * b, nc + n * c
        aa, ab, ac = aa + a * a, ab + a * b, ac + a * c
        bb, bc, cc = bb + b * b, bc + b * c, cc + c * c
    ridge = 1e-9 * (mm + nn) + 1e-9
    held_mm, held_nn = mm + ridge, nn + ridge
    scale = 1.0 / (held_mm * held_nn - mn * mn)
    am, an = (ma * held_nn - na * mn) * scale, (na * held_mm - ma * mn) * scale
    bm, bn = (mb * held_nn - nb * mn) * scale, (nb * held_mm - mb * mn) * scale
    cm, cn = (mc * held_nn - nc * mn) * scale, (nc * held_mm - mc * mn) * scale
    fit.mm, fit.mn, fit.nn = mm, mn, nn
    fit.am, fit.bm, fit.cm = am, bm, cm
    fit.an, fit.bn, fit.cn = an, bn, cn
    fit.aa, fit.ab, fit.ac = aa - am * ma - an * na, ab - am * mb - an * nb, ac - am * mc - an * nc
    fit.bb, fit.bc, fit.cc = bb - bm * mb - bn * nb, bc - bm * mc - bn * nc, cc - cm * mc - cn * nc


@njit(cache=True, error_model="numpy")
def _extremes(corners: Floats, count: int, off: Floats) -> tuple[float, float]:
    """Least and greatest of E without its constant over the trapezoids, for words off by ``off``."""
    rr, rc, cc = off[3], off[4], off[5]
    along_m, along_n = off[1] - 0.5 * rr, off[2] + 0.5 * cc
    least, greatest = np.inf, -np.inf
    low_n, high_n = np.inf, -np.inf
    for first in range(0, count, 4):
        for side in range(4):
            m, n = corners[first + side]
            follower = first + (side + 1 if side < 3 else 0)
            dm, dn = corners[follower, 0] - m, corners[follower, 1] - n
            grad_m, grad_n = along_m + rr * m + rc * n, along_n + rc * m + cc * n
            here = 0.5 * ((along_m + grad_m) * m + (along_n + grad_n) * n)
            low_n, high_n = min(low_n, n), max(high_n, n)
            slope, curve = grad_m * dm + grad_n * dn, rr * dm * dm + 2.0 * rc * dm * dn + cc * dn * dn
            turns = 0.0 < -slope * curve < curve * curve
            there = here - 0.5 * slope * slope / curve if turns else here
            least, greatest = min(least, min(here, there)), max(greatest, max(here, there))
    det = rr * cc - rc * rc
    if det > 0.0:
        m, n = (rc * along_n - cc * along_m) / det, (rc * along_m - rr * along_n) / det
        if 0.0 <= m <= corners[count - 1, 0] and low_n <= n <= high_n:
            here = 0.5 * (along_m * m + along_n * n)
            least, greatest = min(least, here), max(greatest, here)
    return least, greatest


@njit(cache=True, error_model="numpy")
def _second_differences(fraction: Floats | SixFloats, fit: Fit, off: Floats) -> None:
    """Floor or ceiling of each second difference, whatever leaves least to a linear fit (off[3:] written)."""
    aa, ab, ac, bb, bc, cc = fit.aa, fit.ab, fit.ac, fit.bb, fit.bc, fit.cc
    best = np.inf
    # The nearest integers first, then the other choices: x changes fastest, z slowest.
    for other_z in (False, True):
        z = ((fraction[5] > 0.5) != other_z) - fraction[5]
        for other_y in (False, True):
            y = ((fraction[4] > 0.5) != other_y) - fraction[4]
            for other_x in (False, True):
                x = ((fraction[3] > 0.5) != other_x) - fraction[3]
                cost = x * (aa * x + 2.0 * (ab * y + ac * z))
                cost += y * (bb * y + 2.0 * bc * z) + cc * z * z
                # Strictly better only: a difference that no pixel uses stays rounded to nearest.
                if cost < best * (1.0 - 1e-9) - 1e-9:
                    best = cost
                    off[3], off[4], off[5] = x, y, z


@njit(cache=True, error_model="numpy")
def round_words(
    fraction: Floats, order: int, corners: Floats, count: int, fit: Fit, joint: bool, off: Floats
) -> float:
    """
    Round a channel's six words; returns the bound of |E| over the primitive, in units of the last place.

    Parameters
    ----------
    fraction : (6,) float64
      What the words have above their floors.
    order : int
    corners, count, fit
      From :func:`region` and :func:`fit_linear`.
    joint : bool
      False: each word to its nearest.
    off : (6,) float64, written
      Rounded minus true; ``fraction + off`` is the integer to add to the floor.
    """
    for difference in range(6):
        off[difference] = np.floor(fraction[difference] + 0.5) - fraction[difference]
    if order == CONSTANT:
        return abs(off[0])
    if joint:
        if order == QUADRATIC:
            _second_differences(fraction, fit, off)
        want_m = 0.0 - fit.am * off[3] - fit.bm * off[4] - fit.cm * off[5]
        want_n = 0.0 - fit.an * off[3] - fit.bn * off[4] - fit.cn * off[5]
        if fit.mm > 0.0:
            off[1] = np.floor(fraction[1] + want_m + 0.5) - fraction[1]
            # What d_row's rounding leaves, d_col takes up along the primitive's own slant.
            want_n -= (off[1] - want_m) * fit.mn / max(fit.nn, 1e-9)
        if fit.nn > 0.0:
            off[2] = np.floor(fraction[2] + want_n + 0.5) - fraction[2]
    least, greatest = _extremes(corners, count, off)
    if joint:
        off[0] = np.floor(fraction[0] - 0.5 * (least + greatest) + 0.5) - fraction[0]
    return max(abs(off[0] + least), abs(off[0] + greatest)) + SLACK


@njit(cache=True, error_model="numpy")
def largest_error(corners: Floats, count: int, off: Floats) -> float:
    """Most that words off by ``off`` (6,) units are off at a pixel of a region, in last places."""
    least, greatest = _extremes(corners, count, off)
    return max(abs(off[0] + least), abs(off[0] + greatest)) * (1.0 + 2.0**-20) + SLACK


@njit(cache=True, error_model="numpy")
def reach(corners: Floats, count: int) -> tuple[float, float]:
    """Largest m and N of a region."""
    most = corners[0, 1]
    for corner in range(1, count):
        most = max(most, corners[corner, 1])
    return corners[count - 1, 0], most


@njit(cache=True, error_model="numpy")
def carried_error(m: float, n: float, errors: Floats) -> float:
    """Most that errors of the single words (float64 set-up) make at a pixel: E with every term positive."""
    down = m * (errors[1] + 0.5 * max(m - 1.0, 0.0) * errors[3])
    return errors[0] + down + max(n, 0.0) * (errors[2] + m * errors[4] + 0.5 * (n + 1.0) * errors[5])


@njit(cache=True, error_model="numpy")
def difference_spreads(fit: Fit, spreads: Floats) -> None:
    """
    Bits by which a unit of each difference weighs more than one of the value (written, (6,) float64).

    Half the range over the primitive of what the difference is multiplied by: for the second differences, of
    what is left of it after a fitted linear function, because d_row and d_col take that away.
    """
    spreads[0] = 0.0
    for difference, square in (
        (1, fit.mm), (2, fit.nn), (3, fit.aa), (4, fit.bb), (5, fit.cc),
    ):  # fmt: skip
        half_range = HALF_RANGE * np.sqrt(max(square, 0.0) / SAMPLE_POINTS)
        spreads[difference] = np.log2(max(half_range, LEAST_SPREAD)) + 1.0


@njit(cache=True, error_model="numpy")
def coarse_words(
    words: Ints,
    shifts: Ints,
    order: int,
    corners: Floats,
    count: int,
    fit: Fit,
    scaled: Fit,
    off: Floats,
    out: Ints,
) -> float:
    """
    Round a channel's words jointly, each difference to its own multiple of a unit.

    Parameters
    ----------
    words : (6,) int64
    shifts : (6,) int64
      Each word becomes a multiple of 2**shift.
    order : int
    corners, count, fit
      From :func:`region` and :func:`fit_linear`.
    scaled : Fit, off : (6,) float64, both written
    out : (6,) int64, written
      The words, which a carry may have taken one bit beyond their width.

    Returns
    -------
    float
      Bound of what this adds to the error at any pixel of the primitive, in units of the last place.
    """
    used = DIFFERENCES_OF_ORDER[order]
    for difference in range(6):
        unit = np.int64(1) << shifts[difference]
        off[difference] = out[difference] = 0
        if difference < used:
            out[difference] = (words[difference] >> shifts[difference]) << shifts[difference]
            # What is above the floor, in units.
            off[difference] = (words[difference] - out[difference]) / unit
    fraction = (off[0], off[1], off[2], off[3], off[4], off[5])
    size = (
        2.0 ** shifts[0], 2.0 ** shifts[1], 2.0 ** shifts[2], 2.0 ** shifts[3], 2.0 ** shifts[4],
        2.0 ** shifts[5],
    )  # fmt: skip
    for difference in range(6):
        off[difference] = np.floor(fraction[difference] + 0.5) - fraction[difference]
    if order == QUADRATIC:
        scaled.aa, scaled.ab = fit.aa * size[3] * size[3], fit.ab * size[3] * size[4]
        scaled.ac, scaled.bb = fit.ac * size[3] * size[5], fit.bb * size[4] * size[4]
        scaled.bc, scaled.cc = fit.bc * size[4] * size[5], fit.cc * size[5] * size[5]
        _second_differences(fraction, scaled, off)
    for difference in range(6):
        off[difference] *= size[difference]
    least = greatest = 0.0
    if order != CONSTANT:
        want_m = 0.0 - fit.am * off[3] - fit.bm * off[4] - fit.cm * off[5]
        want_n = 0.0 - fit.an * off[3] - fit.bn * off[4] - fit.cn * off[5]
        if fit.mm > 0.0:
            off[1] = (np.floor(fraction[1] + want_m / size[1] + 0.5) - fraction[1]) * size[1]
            want_n -= (off[1] - want_m) * fit.mn / max(fit.nn, 1e-9)
        if fit.nn > 0.0:
            off[2] = (np.floor(fraction[2] + want_n / size[2] + 0.5) - fraction[2]) * size[2]
        least, greatest = _extremes(corners, count, off)
    off[0] = (np.floor(fraction[0] - 0.5 * (least + greatest) / size[0] + 0.5) - fraction[0]) * size[0]
    for difference in range(used):
        out[difference] += (
            np.int64(np.rint(fraction[difference] + off[difference] / size[difference])) << shifts[difference]
        )
    bound = max(abs(off[0] + least), abs(off[0] + greatest))
    return bound * (1.0 + 2.0**-20) + (SLACK if bound > 0.0 else 0.0)
