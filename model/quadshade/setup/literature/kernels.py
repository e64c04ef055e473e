# SPDX-License-Identifier: Apache-2.0
"""
The literature's set-up methods over many triangles, in vector instructions.

Triangles lie in blocks of ``LANES``: a row of each coordinate, of each normal's component, of what is stored
of each edge, and of each coefficient. So a loop reads and writes vectors without a shuffle. Rows are a
constant number of entries apart, and no shorter than the loop: the compiler sees that no result can become an
input. Products are fused with sums where the processor can.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats
from quadshade.errors import QuadshadeError
from quadshade.setup.literature.general_solution import Legs, Six, general
from quadshade.setup.literature.methods import (
    Three,
    abbas,
    dot,
    edge_factor,
    formula,
    on_screen,
    six_samples,
    slopes,
    unit_triangle,
    x_shading,
)

LANES = 64
"""Triangles of a block: in float64 it has 12 KiB, and two of them stay in any innermost cache."""
VERTICES, NORMALS, FACTORS, TERMS, ROWS = 0, 6, 15, 18, 24
"""First rows of x and y of vertices, of x, y and z of normals, of Ni . Nj - 1, of T0 to T5; all rows."""
BLOCK = ROWS * LANES

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}}
"""How the loops are compiled."""
loop = njit(cache=True, **OPTIONS)


@formula
def _legs(flat: Floats, at: int) -> Legs:
    """Second and third vertex, counted from the first."""
    x, y = flat[at], flat[at + LANES]
    return (
        flat[at + 2 * LANES] - x,
        flat[at + 3 * LANES] - y,
        flat[at + 4 * LANES] - x,
        flat[at + 5 * LANES] - y,
    )


@formula
def _three(flat: Floats, at: int) -> Three:
    return flat[at], flat[at + LANES], flat[at + 2 * LANES]


@formula
def _normals(flat: Floats, at: int) -> tuple[Three, Three, Three]:
    begin = at + NORMALS * LANES
    return _three(flat, begin), _three(flat, begin + 3 * LANES), _three(flat, begin + 6 * LANES)


@formula
def _put(flat: Floats, at: int, terms: Six) -> None:
    begin = at + TERMS * LANES
    flat[begin], flat[begin + LANES], flat[begin + 2 * LANES] = terms[0], terms[1], terms[2]
    flat[begin + 3 * LANES], flat[begin + 4 * LANES] = terms[3], terms[4]
    flat[begin + 5 * LANES] = terms[5]


@loop
def _run_abbas(flat: Floats, light: Three) -> None:
    one = flat.dtype.type(1)
    for block in range(len(flat) // BLOCK):
        for lane in range(LANES):
            at = block * BLOCK + lane
            legs = _legs(flat, at)
            _put(flat, at, abbas(six_samples(_normals(flat, at), light), legs, one))


@loop
def _run_general(flat: Floats, light: Three) -> None:
    rows = np.empty((6, 7), flat.dtype)
    for block in range(len(flat) // BLOCK):
        for lane in range(LANES):
            at = block * BLOCK + lane
            legs = _legs(flat, at)
            _put(flat, at, general(six_samples(_normals(flat, at), light), legs, rows))


@loop
def _run_unit_triangle(flat: Floats, light: Three) -> None:
    one = flat.dtype.type(1)
    for block in range(len(flat) // BLOCK):
        for lane in range(LANES):
            at = block * BLOCK + lane
            halved = slopes(_legs(flat, at), one)
            unit = unit_triangle(six_samples(_normals(flat, at), light), one)
            _put(flat, at, on_screen(unit, halved))


@loop
def _run_x_shading(flat: Floats, light: Three) -> None:
    one = flat.dtype.type(1)
    for block in range(len(flat) // BLOCK):
        for lane in range(LANES):
            at = block * BLOCK + lane
            first, second, third = _normals(flat, at)
            factors = (
                edge_factor(first, second, one),
                edge_factor(first, third, one),
                edge_factor(second, third, one),
            )
            unit = x_shading((dot(light, first), dot(light, second), dot(light, third)), factors)
            halved = slopes(_legs(flat, at), one)
            _put(flat, at, on_screen(unit, halved))


@loop
def _run_x_shading_stored(flat: Floats, light: Three) -> None:
    one = flat.dtype.type(1)
    for block in range(len(flat) // BLOCK):
        for lane in range(LANES):
            at = block * BLOCK + lane
            # First, so that the division runs while the normals are multiplied.
            halved = slopes(_legs(flat, at), one)
            first, second, third = _normals(flat, at)
            factors = _three(flat, at + FACTORS * LANES)
            unit = x_shading((dot(light, first), dot(light, second), dot(light, third)), factors)
            _put(flat, at, on_screen(unit, halved))


METHODS = {
    "abbas": _run_abbas,
    "general": _run_general,
    "unit_triangle": _run_unit_triangle,
    "x_shading": _run_x_shading,
    "x_shading_stored": _run_x_shading_stored,
}
"""Loops over what :func:`kernel_arguments` gives: blocks, in which they write coefficients, and the light."""


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
    vertices: np.ndarray,
    normals: np.ndarray,
    light: np.ndarray,
    dtype: type[np.floating[Any]] = np.float64,
) -> tuple[Floats, Three]:
    """
    What the kernels of ``METHODS`` take, from the arrays that :func:`coefficients` takes.

    Parameters
    ----------
    vertices, normals, light
      As for :func:`coefficients`.
    dtype : type
      Of the arithmetic, ``numpy.float32`` or ``numpy.float64``.

    Returns
    -------
    tuple
      Blocks one after the other, the last one filled up with the last triangle, and the light.
    """
    count = len(vertices)
    given = np.concatenate(
        [np.reshape(vertices, (count, 6)), np.reshape(normals, (count, 9)), edge_factors(normals)], axis=1
    )
    given = given[np.minimum(np.arange(-(-count // LANES) * LANES), count - 1)]
    blocks: Any = np.zeros((len(given) // LANES, ROWS, LANES), dtype)
    blocks[:, :TERMS] = given.reshape(-1, LANES, TERMS).transpose(0, 2, 1)
    x, y, z = np.asarray(light, dtype)
    return blocks.reshape(-1), (x, y, z)


def coefficients(
    method: str,
    vertices: np.ndarray,
    normals: np.ndarray,
    light: np.ndarray,
    dtype: type[np.floating[Any]] = np.float64,
) -> np.ndarray:
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
    dtype : type
      Of the arithmetic, ``numpy.float32`` or ``numpy.float64``.

    Returns
    -------
    (n, 6) of this type
      T0 to T5; not finite where the method divides by zero.

    Raises
    ------
    QuadshadeError
      An unknown method.
    """
    if method not in METHODS:
        raise QuadshadeError(f"there is no set-up method {method!r}", f"the methods are {', '.join(METHODS)}")
    flat, towards = kernel_arguments(vertices, normals, light, dtype)
    METHODS[method](flat, towards)
    terms = flat.reshape(-1, ROWS, LANES)[:, TERMS:].transpose(0, 2, 1)
    return terms.reshape(-1, ROWS - TERMS)[: len(vertices)]
