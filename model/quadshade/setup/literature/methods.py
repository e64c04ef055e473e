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

Vector: TypeAlias = Floats | tuple[float, float, float]


@njit(cache=True, error_model="numpy")
def _dot(one: Vector, first: int, two: Vector, second: int) -> float:
    """Scalar product of two vectors, each three entries of an array."""
    return one[first] * two[second] + one[first + 1] * two[second + 1] + one[first + 2] * two[second + 2]


@njit(cache=True, error_model="numpy")
def _middle(normals: Floats, first: int, second: int, light: Vector) -> float:
    """L . N with the normal in the middle of an edge (Barrera et al., equation 4)."""
    x = normals[first] + normals[second]
    y = normals[first + 1] + normals[second + 1]
    z = normals[first + 2] + normals[second + 2]
    length = np.sqrt(x * x + y * y + z * z)
    return light[0] * (x / length) + light[1] * (y / length) + light[2] * (z / length)


@njit(cache=True, error_model="numpy")
def _six_samples(normals: Floats, light: Vector) -> Six:
    """I1, I2, I3, I12, I13, I23 of nine numbers, three normals (Barrera et al., equations 1-6)."""
    return (
        _dot(light, 0, normals, 0),
        _dot(light, 0, normals, 3),
        _dot(light, 0, normals, 6),
        _middle(normals, 0, 3, light),
        _middle(normals, 0, 6, light),
        _middle(normals, 3, 6, light),
    )


@njit(cache=True, error_model="numpy")
def _legs(vertices: Floats) -> Legs:
    """Second and third vertex of six numbers, counted from the first."""
    x, y = vertices[0], vertices[1]
    return vertices[2] - x, vertices[3] - y, vertices[4] - x, vertices[5] - y


@njit(cache=True, error_model="numpy")
def _abbas(samples: Six, legs: Legs) -> Six:
    """T0 to T5 (Abbas et al., section 3)."""
    i1, i2, i3, i12, i13, i23 = samples
    x2, y2, x3, y3 = legs
    c2 = 4 * i12 - 3 * i1 - i2
    c12 = i1 + i2 - 2 * i12
    c3 = 4 * i13 - 3 * i1 - i3
    c13 = i1 + i3 - 2 * i13
    c23 = 4 * i1 - 4 * i12 - 4 * i13 + 4 * i23
    t1 = (c3 * x2 - c2 * x3) / (x2 * y3 - y2 * x3)
    t2 = (c2 * y3 - c3 * y2) / (x2 * y3 - y2 * x3)
    t4 = (
        (4 * c13 * y2 - c23 * y3) * (2 * x2 * x2 * y3 - 2 * x2 * y2 * x3)
        - (4 * c12 * y3 - c23 * y2) * (2 * y2 * x3 * x3 - 2 * x2 * x3 * y3)
    ) / (
        (2 * x2 * x2 * y3 - 2 * x2 * y2 * x3) * (y2 * x3 * y3 - x2 * y3 * y3)
        - (x2 * y2 * y3 - y2 * y2 * x3) * (2 * y2 * x3 * x3 - 2 * x2 * x3 * y3)
    )
    t5 = (
        (4 * c12 * y3 - c23 * y2) * (y2 * x3 * y3 - x2 * y3 * y3)
        - (4 * c13 * y2 - c23 * y3) * (x2 * y2 * y3 - y2 * y2 * x3)
    ) / (
        (2 * x2 * x2 * y3 - 2 * x2 * y2 * x3) * (y2 * x3 * y3 - x2 * y3 * y3)
        - (x2 * y2 * y3 - y2 * y2 * x3) * (2 * y2 * x3 * x3 - 2 * x2 * x3 * y3)
    )
    t3 = (2 * c12 - t5 * x2 * x2 - t4 * x2 * y2) / (y2 * y2)
    return i1, t1, t2, t3, t4, t5


@njit(cache=True, error_model="numpy")
def _unit_triangle(samples: Six) -> Six:
    """2a to 2e, and f (Barrera et al., equation 16; doubled so that nothing need be halved later)."""
    i1, i2, i3, i12, i13, i23 = samples
    a = 4 * (i1 + i2 - 2 * i12)
    b = 4 * (i1 + i3 - 2 * i13)
    c = 8 * (i1 + i23 - i13 - i12)
    return a, b, c, 2 * (i2 - i1) - a, 2 * (i3 - i1) - b, i1


@njit(cache=True, error_model="numpy")
def _x_shading(i1: float, i2: float, i3: float, factor12: float, factor13: float, factor23: float) -> Six:
    """2a to 2e, and f, from the vertices' samples and Ni . Nj - 1 (Barrera et al., equation 32)."""
    a = (i1 + i2) * factor12
    b = (i1 + i3) * factor13
    c = a + b - (i2 + i3) * factor23
    return a, b, c, 2 * (i2 - i1) - a, 2 * (i3 - i1) - b, i1


@njit(cache=True, error_model="numpy")
def _slopes(legs: Legs, half: float) -> Legs:
    """Half of alpha_u, beta_u, alpha_v, beta_v (Barrera et al., 20 and 21); ``half`` in their arithmetic."""
    x1, y1, x2, y2 = legs
    omega = half / (x1 * y2 - x2 * y1)
    return y2 * omega, -x2 * omega, -y1 * omega, x1 * omega


@njit(cache=True, error_model="numpy")
def _on_screen(unit: Six, slopes: Legs) -> Six:
    """
    T0 to T5 of 2a to 2e, f and halved slopes: the powers of two cancel, exactly.

    Barrera et al., equation 22, through the gradients of the second-order part along x and y: a third fewer
    products than printed.
    """
    a, b, c, d, e, f = unit
    alpha_u, beta_u, alpha_v, beta_v = slopes
    xu, xv = 2 * a * alpha_u + c * alpha_v, 2 * b * alpha_v + c * alpha_u
    yu, yv = 2 * a * beta_u + c * beta_v, 2 * b * beta_v + c * beta_u
    return (
        f,
        d * beta_u + e * beta_v,
        d * alpha_u + e * alpha_v,
        yu * beta_u + yv * beta_v,
        2 * (xu * beta_u + xv * beta_v),
        xu * alpha_u + xv * alpha_v,
    )


@njit(cache=True, error_model="numpy")
def _put(out: Floats, row: int, terms: Six) -> None:
    out[row, 0], out[row, 1], out[row, 2], out[row, 3], out[row, 4], out[row, 5] = terms


@njit(cache=True, error_model="numpy")
def _run_abbas(vertices: Floats, normals: Floats, factors: Floats, light: Floats, out: Floats) -> None:
    towards = light[0], light[1], light[2]
    for row in range(len(out)):
        legs = _legs(vertices[row])
        _put(out, row, _abbas(_six_samples(normals[row], towards), legs))


@njit(cache=True, error_model="numpy")
def _run_general(vertices: Floats, normals: Floats, factors: Floats, light: Floats, out: Floats) -> None:
    towards = light[0], light[1], light[2]
    rows = np.empty((6, 7))
    for row in range(len(out)):
        legs = _legs(vertices[row])
        _put(out, row, general(_six_samples(normals[row], towards), legs, rows))


@njit(cache=True, error_model="numpy")
def _run_unit_triangle(
    vertices: Floats, normals: Floats, factors: Floats, light: Floats, out: Floats
) -> None:
    towards = light[0], light[1], light[2]
    for row in range(len(out)):
        slopes = _slopes(_legs(vertices[row]), 0.5)
        _put(out, row, _on_screen(_unit_triangle(_six_samples(normals[row], towards)), slopes))


@njit(cache=True, error_model="numpy")
def _run_x_shading(vertices: Floats, normals: Floats, factors: Floats, light: Floats, out: Floats) -> None:
    towards = light[0], light[1], light[2]
    for row in range(len(out)):
        slopes = _slopes(_legs(vertices[row]), 0.5)
        n = normals[row]
        i1, i2, i3 = _dot(towards, 0, n, 0), _dot(towards, 0, n, 3), _dot(towards, 0, n, 6)
        f12, f13, f23 = _dot(n, 0, n, 3) - 1, _dot(n, 0, n, 6) - 1, _dot(n, 3, n, 6) - 1
        unit = _x_shading(i1, i2, i3, f12, f13, f23)
        _put(out, row, _on_screen(unit, slopes))


@njit(cache=True, error_model="numpy")
def _run_x_shading_stored(
    vertices: Floats, normals: Floats, factors: Floats, light: Floats, out: Floats
) -> None:
    towards = light[0], light[1], light[2]
    for row in range(len(out)):
        slopes = _slopes(_legs(vertices[row]), 0.5)
        n = normals[row]
        i1, i2, i3 = _dot(towards, 0, n, 0), _dot(towards, 0, n, 3), _dot(towards, 0, n, 6)
        unit = _x_shading(i1, i2, i3, factors[row, 0], factors[row, 1], factors[row, 2])
        _put(out, row, _on_screen(unit, slopes))


METHODS = {
    "abbas": _run_abbas,
    "general": _run_general,
    "unit_triangle": _run_unit_triangle,
    "x_shading": _run_x_shading,
    "x_shading_stored": _run_x_shading_stored,
}
"""
Kernels of (n, 6) vertices, (n, 9) normals, (n, 3) factors, (3,) light, and the (n, 6) coefficients written.
The vertices come first in each, so that the division runs while the normals are multiplied.
"""

FITS = {"abbas": 0, "general": 1, "unit_triangle": 2}
"""Methods that go through six samples."""


@njit(cache=True, error_model="numpy")
def _fit(vertices: Floats, samples: Floats, which: int, rows: Floats, out: Floats) -> None:
    for row in range(len(out)):
        s = samples[row]
        six = s[0], s[1], s[2], s[3], s[4], s[5]
        legs = _legs(vertices[row])
        if which == 0:
            _put(out, row, _abbas(six, legs))
        elif which == 1:
            _put(out, row, general(six, legs, rows))
        else:
            _put(out, row, _on_screen(_unit_triangle(six), _slopes(legs, 0.5)))


def edge_factors(normals: np.ndarray) -> np.ndarray:
    """
    What X-shading can store with a mesh: Ni . Nj - 1 (Barrera et al., equation 32 and the text below it).

    Parameters
    ----------
    normals : (n, 3, 3) float
      Unit normals at the vertices.

    Returns
    -------
    (n, 3) float64
      Of the edges 12, 13, 23.
    """
    one, two, three = (np.asarray(normals, dtype=np.float64)[:, corner] for corner in range(3))
    pairs = (one, two), (one, three), (two, three)
    return np.stack([np.einsum("ni,ni->n", *pair) - 1 for pair in pairs], axis=1)


def kernel_arguments(
    vertices: np.ndarray, normals: np.ndarray, light: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    What the kernels of ``METHODS`` take, from the arrays that :func:`coefficients` takes.

    Returns
    -------
    tuple
      (n, 6), (n, 9), (n, 3) and (3,) float64, and room for the (n, 6) coefficients.
    """
    count = len(vertices)
    return (
        np.ascontiguousarray(vertices, dtype=np.float64).reshape(count, 6),
        np.ascontiguousarray(normals, dtype=np.float64).reshape(count, 9),
        edge_factors(normals),
        np.ascontiguousarray(light, dtype=np.float64),
        np.empty((count, 6)),
    )


def coefficients(method: str, vertices: np.ndarray, normals: np.ndarray, light: np.ndarray) -> np.ndarray:
    """
    Coefficients of the light that a directional light gives, from the vertices' normals.

    Parameters
    ----------
    method : str
      One of ``METHODS``.
    vertices : (n, 3, 2) float
      On the screen, in any unit; not on one line.
    normals : (n, 3, 3) float
      Unit normals at the vertices.
    light : (3,) float
      Towards the light (or the half vector, for the cosine of a highlight), unit length.

    Returns
    -------
    (n, 6) float64
      T0 to T5; not finite where the method divides by zero.

    Raises
    ------
    QuadshadeError
      An unknown method.
    """
    if method not in METHODS:
        raise QuadshadeError(f"there is no set-up method {method!r}", f"the methods are {', '.join(METHODS)}")
    arguments = kernel_arguments(vertices, normals, light)
    METHODS[method](*arguments)
    return arguments[-1]


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
    if method == "abbas":
        return _plain(_abbas)(samples, legs)
    half = Fraction(1, 2) if isinstance(legs[0], Fraction) else 0.5
    slopes = _plain(_slopes)(legs, half)
    unit = _plain(_unit_triangle)(samples) if method == "unit_triangle" else _plain(_x_shading)(*samples)
    return _plain(_on_screen)(unit, slopes)


def _plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function's Python source, for other numbers than float64."""
    return getattr(function, "py_func", function)
