# SPDX-License-Identifier: Apache-2.0
"""
Coefficients of a triangle's quadratic by the methods of the literature, side by side.

All give the same six numbers, ``I(X, Y) = T5 X^2 + T4 X Y + T3 Y^2 + T2 X + T1 Y + T0`` with X and Y
counted from the triangle's first vertex (Abbas et al., equation 4; A, C, B, D, E, F in Barrera et al.,
equation 7), for one directional light L:

``abbas``             the formulas of Abbas et al., section 3, as printed, from six samples
``general``           their six equations (Barrera et al., equations 8-11) by elimination with pivots
``unit_triangle``     Barrera et al., equations 16 and 18-22, from six samples
``x_shading``         equation 32 instead of 16: from the vertex normals, no sample between them
``x_shading_stored``  the same with Ni . Nj - 1 stored with the mesh, as their section 4 proposes: a mesh that
                      moves or turns keeps them

The first three take their samples as Barrera et al. count them in Table 1: L . N at the vertices, and in the
middles of the edges with the normal ``(N1 + N2) / |N1 + N2|`` (equations 1-6).

Abbas et al. divide by Y2 squared: a triangle whose first two vertices are at one height has no coefficients.
None of the others divides by anything but the doubled area. The hardware's words are set up by
:mod:`quadshade.setup.coefficients`, from the unit triangle and directly on the pixel lattice.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats
from quadshade.errors import QuadshadeError
from quadshade.setup.literature.general_solution import Legs, Six, general

Three: TypeAlias = tuple[float, float, float]

formula = njit(inline="always", error_model="numpy")
"""
A formula takes on the arithmetic of the loop that it stands in: its type, and whether products are fused with
sums. Whole numbers are sums of ``one``, which is of that type too, so that no literal widens it.
"""


@formula
def dot(left: Three, right: Three) -> float:
    """Scalar product."""
    return left[0] * right[0] + left[1] * right[1] + left[2] * right[2]


@formula
def edge_factor(left: Three, right: Three, one: float) -> float:
    """Ni . Nj - 1 (Barrera et al., equation 32)."""
    return left[0] * right[0] - one + left[1] * right[1] + left[2] * right[2]


@formula
def middle(left: Three, right: Three, light: Three) -> float:
    """L . N with the normal in the middle of an edge (Barrera et al., equation 4)."""
    x, y, z = left[0] + right[0], left[1] + right[1], left[2] + right[2]
    length = np.sqrt(x * x + y * y + z * z)
    return light[0] * (x / length) + light[1] * (y / length) + light[2] * (z / length)


@formula
def six_samples(normals: tuple[Three, Three, Three], light: Three) -> Six:
    """I1, I2, I3, I12, I13, I23 of three normals (Barrera et al., equations 1-6)."""
    first, second, third = normals
    return (
        dot(light, first),
        dot(light, second),
        dot(light, third),
        middle(first, second, light),
        middle(first, third, light),
        middle(second, third, light),
    )


@formula
def abbas(samples: Six, legs: Legs, one: float) -> Six:
    """T0 to T5 (Abbas et al., section 3)."""
    two, three, four = one + one, one + one + one, one + one + one + one
    i1, i2, i3, i12, i13, i23 = samples
    x2, y2, x3, y3 = legs
    c2 = four * i12 - three * i1 - i2
    c12 = i1 + i2 - two * i12
    c3 = four * i13 - three * i1 - i3
    c13 = i1 + i3 - two * i13
    c23 = four * i1 - four * i12 - four * i13 + four * i23
    t1 = (c3 * x2 - c2 * x3) / (x2 * y3 - y2 * x3)
    t2 = (c2 * y3 - c3 * y2) / (x2 * y3 - y2 * x3)
    t4 = (
        (four * c13 * y2 - c23 * y3) * (two * x2 * x2 * y3 - two * x2 * y2 * x3)
        - (four * c12 * y3 - c23 * y2) * (two * y2 * x3 * x3 - two * x2 * x3 * y3)
    ) / (
        (two * x2 * x2 * y3 - two * x2 * y2 * x3) * (y2 * x3 * y3 - x2 * y3 * y3)
        - (x2 * y2 * y3 - y2 * y2 * x3) * (two * y2 * x3 * x3 - two * x2 * x3 * y3)
    )
    t5 = (
        (four * c12 * y3 - c23 * y2) * (y2 * x3 * y3 - x2 * y3 * y3)
        - (four * c13 * y2 - c23 * y3) * (x2 * y2 * y3 - y2 * y2 * x3)
    ) / (
        (two * x2 * x2 * y3 - two * x2 * y2 * x3) * (y2 * x3 * y3 - x2 * y3 * y3)
        - (x2 * y2 * y3 - y2 * y2 * x3) * (two * y2 * x3 * x3 - two * x2 * x3 * y3)
    )
    t3 = (two * c12 - t5 * x2 * x2 - t4 * x2 * y2) / (y2 * y2)
    return i1, t1, t2, t3, t4, t5


@formula
def unit_triangle(samples: Six, one: float) -> Six:
    """2a to 2e, and f (Barrera et al., equation 16; doubled so that nothing need be halved later)."""
    two, four, eight = one + one, one + one + one + one, one + one + one + one + one + one + one + one
    i1, i2, i3, i12, i13, i23 = samples
    a = four * (i1 + i2 - two * i12)
    b = four * (i1 + i3 - two * i13)
    c = eight * (i1 + i23 - i13 - i12)
    return a, b, c, two * (i2 - i1) - a, two * (i3 - i1) - b, i1


@formula
def x_shading(samples: Three, factors: Three) -> Six:
    """2a to 2e, and f, from the vertices' samples and Ni . Nj - 1 (Barrera et al., equation 32)."""
    i1, i2, i3 = samples
    a = (i1 + i2) * factors[0]
    b = (i1 + i3) * factors[1]
    c = a + b - (i2 + i3) * factors[2]
    u, v = i2 - i1, i3 - i1
    return a, b, c, u + u - a, v + v - b, i1


@formula
def slopes(legs: Legs, one: float) -> Legs:
    """Half of alpha_u, -beta_u, -alpha_v, beta_v (Barrera et al., equations 20 and 21); no sign is turned."""
    x1, y1, x2, y2 = legs
    omega = one / (one + one) / (x1 * y2 - x2 * y1)
    return y2 * omega, x2 * omega, y1 * omega, x1 * omega


@formula
def on_screen(unit: Six, halved: Legs) -> Six:
    """
    T0 to T5 of 2a to 2e and f, and halved slopes: the powers of two cancel, exactly.

    Barrera et al., equation 22. The second-order part goes through its gradients along x and y, whose two
    sides share the product of c and the sum of the slopes: 20 products with the slopes' own, instead of 29.
    """
    a, b, c, d, e, f = unit
    right_u, down_u, right_v, down_v = halved
    own_u, own_v = a + a - c, b + b - c
    right, down = c * (right_u - right_v), c * (down_v - down_u)
    xu, xv = own_u * right_u + right, right - own_v * right_v
    yu, yv = down - own_u * down_u, own_v * down_v + down
    mixed = xv * down_v - xu * down_u
    return (
        f,
        e * down_v - d * down_u,
        d * right_u - e * right_v,
        yv * down_v - yu * down_u,
        mixed + mixed,
        xu * right_u - xv * right_v,
    )


FITS = {"abbas": 0, "general": 1, "unit_triangle": 2}
"""Methods that go through six samples."""


@njit(cache=True, error_model="numpy")
def _fit(vertices: Floats, samples: Floats, which: int, rows: Floats, out: Floats) -> None:
    for row in range(len(out)):
        s = samples[row]
        six = s[0], s[1], s[2], s[3], s[4], s[5]
        v = vertices[row]
        legs = v[2] - v[0], v[3] - v[1], v[4] - v[0], v[5] - v[1]
        if which == 0:
            terms = abbas(six, legs, 1.0)
        elif which == 1:
            terms = general(six, legs, rows)
        else:
            terms = on_screen(unit_triangle(six, 1.0), slopes(legs, 1.0))
        for term in range(6):
            out[row, term] = terms[term]


def fit(method: str, vertices: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """
    Coefficients of the quadratic through six samples.

    Parameters
    ----------
    method : str
      One of ``FITS``.
    vertices : (n, 3, 2) float
    samples : (n, 6) float
      I1, I2, I3, I12, I13, I23.

    Returns
    -------
    (n, 6) float64
      T0 to T5; not finite where the method divides by zero.

    Raises
    ------
    QuadshadeError
      A method that takes no samples.
    """
    if method not in FITS:
        raise QuadshadeError(f"the method {method!r} fits no samples", f"give one of {', '.join(FITS)}")
    out = np.empty((len(samples), 6))
    flat = np.ascontiguousarray(vertices, dtype=np.float64).reshape(-1, 6)
    _fit(flat, np.ascontiguousarray(samples, dtype=np.float64), FITS[method], np.empty((6, 7)), out)
    return out


def terms_in(method: str, legs: tuple[Any, ...], samples: tuple[Any, ...]) -> tuple[Any, ...]:
    """
    The formulas themselves, in whatever arithmetic their arguments bring with them.

    Parameters
    ----------
    method : str
      ``abbas``, ``unit_triangle`` or ``x_shading``.
    legs : 4 numbers, or arrays of one shape
      X2, Y2, X3, Y3: float32, float64, or :class:`fractions.Fraction`.
    samples : 6 numbers or arrays
      I1, I2, I3, I12, I13, I23; for ``x_shading`` I1, I2, I3 and the edges' Ni . Nj - 1.

    Returns
    -------
    6 numbers or arrays
      T0 to T5.
    """
    one = Fraction(1) if isinstance(legs[0], Fraction) else 1.0
    if method == "abbas":
        return _plain(abbas)(samples, legs, one)
    if method == "unit_triangle":
        unit = _plain(unit_triangle)(samples, one)
    else:
        unit = _plain(x_shading)(samples[:3], samples[3:])
    return _plain(on_screen)(unit, _plain(slopes)(legs, one))


def _plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function's Python source, for other numbers than float64."""
    return getattr(function, "py_func", function)
