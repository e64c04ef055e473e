# SPDX-License-Identifier: Apache-2.0
"""Float references over the engine's exact coverage: what a picture would be without rounding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import LINEAR, QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.phong_loops import lit_mesh, shade_pixels, shade_places
from quadshade.shading.sample import full_scale, reflected

CHUNK = 1 << 16


def barycentric(
    vertices: np.ndarray, triangle: np.ndarray, x: np.ndarray, y: np.ndarray, subpixel_bits: int
) -> np.ndarray:
    """
    Where the centres of pixels lie in their triangles.

    Parameters
    ----------
    vertices : (n, 3, 2) int64
      Sub-pixels.
    triangle, x, y : (m,) int
      Pixels and the triangle that each belongs to.
    subpixel_bits : int

    Returns
    -------
    (m, 3) float64
      Weights of the three vertices, correctly rounded quotients of exact integers; their sum is 1.
    """
    return _barycentric(vertices, triangle, x, y, subpixel_bits)


@njit(cache=True, error_model="numpy")
def _barycentric(vertices: Ints, triangle: Ints, x: Ints, y: Ints, subpixel_bits: int) -> Floats:
    """Quotients of doubled areas, in half sub-pixels, so that a pixel's centre is an integer too."""
    weights = np.empty((len(triangle), 3))
    for index in range(len(triangle)):
        a, b, c = 2 * vertices[triangle[index]]
        across, down = (2 * x[index] + 1) << subpixel_bits, (2 * y[index] + 1) << subpixel_bits
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        second = (across - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (down - a[1])
        third = (b[0] - a[0]) * (down - a[1]) - (across - a[0]) * (b[1] - a[1])
        weights[index, 1], weights[index, 2] = second / area, third / area
        weights[index, 0] = 1 - weights[index, 1] - weights[index, 2]
    return weights


def polynomial(samples: np.ndarray, orders: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """
    The polynomial through triangles' samples, at any place.

    Written with the six shape functions of a quadratic triangle, not with the set-up's coefficients.

    Parameters
    ----------
    samples : (m, c, 6) float64
    orders : (m, c) int64
    weights : (m, 3) float64
      Barycentric coordinates; outside of the triangle the polynomial goes on.

    Returns
    -------
    (m, c) float64
    """
    flat = np.zeros((len(weights), 6))
    flat[:, 0] = 1
    linear = np.zeros((len(weights), 6))
    linear[:, :3] = weights
    quadratic = quadratic_shape(weights)
    count, channels = samples.shape[:2]
    values = np.empty((count, channels))
    for channel in range(channels):
        order = orders[:, channel][:, None]
        shape = np.where(order == QUADRATIC, quadratic, np.where(order == LINEAR, linear, flat))
        values[:, channel] = (shape * samples[:, channel]).sum(axis=-1)
    return values


def quadratic_shape(weights: np.ndarray) -> np.ndarray:
    """(m, 6) shares of the six samples in a quadratic's value at (m, 3) barycentric coordinates."""
    first, second, third = weights.T
    middles = np.stack([4 * first * second, 4 * first * third, 4 * second * third], axis=-1)
    return np.concatenate([weights * (2 * weights - 1), middles], axis=-1)


def interpolated(
    triangles: ScreenTriangles,
    triangle: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    formats: Formats | None = None,
) -> np.ndarray:
    """
    Flat, Gouraud and quadratic shading in float: the polynomial through the samples, at pixel centres.

    Parameters
    ----------
    triangles : ScreenTriangles
    triangle, x, y : (m,) int
      Pixels, for example of an engine's drawing.
    formats : Formats, optional
      Gives the sub-pixel bits and the largest value.

    Returns
    -------
    (m, channels) float64
      In output units, clamped to what the output holds, not rounded.
    """
    formats = Formats() if formats is None else formats
    values = np.empty((len(triangle), len(triangles.channels)))
    for rows in _chunks(len(triangle)):
        owner = triangle[rows]
        weights = barycentric(triangles.vertices, owner, x[rows], y[rows], formats.subpixel_bits)
        values[rows] = polynomial(triangles.samples[owner], triangles.orders[owner], weights)
    return np.clip(values, 0, 2.0**formats.value_bits - 1)


def phong(
    projected: Projected,
    triangle: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
) -> np.ndarray:
    """
    Phong shading: normals interpolated with perspective and normalised at every pixel.

    Parameters
    ----------
    projected : Projected
    triangle, x, y : (m,) int
      Pixels; ``triangle`` is an index into ``projected``.
    lights : sequence of lights, optional
      By default those that go with the viewer.
    material : Material, optional
    formats : Formats, optional

    Returns
    -------
    (m, 3) float64
      In output units, clamped to what the output holds, not rounded.
    """
    formats = Formats() if formats is None else formats
    material = Material() if material is None else material
    lights = default_lights(projected.axes) if lights is None else lights
    lit = lit_mesh(projected, lights, material, 2.0**formats.value_bits - 1)
    if lit is not None:
        owner, column, line = (np.ascontiguousarray(array, dtype=np.int64) for array in (triangle, x, y))
        return shade_pixels(lit, owner, column, line, formats.subpixel_bits)
    values = np.empty((len(triangle), 3))
    for rows in _chunks(len(triangle)):
        weights = barycentric(projected.vertices, triangle[rows], x[rows], y[rows], formats.subpixel_bits)
        values[rows] = phong_at(projected, triangle[rows], weights, lights, material, formats)
    return values


def phong_at(
    projected: Projected,
    triangle: np.ndarray,
    weights: np.ndarray,
    lights: Sequence[Light],
    material: Material,
    formats: Formats,
) -> np.ndarray:
    """
    Phong shading at any places of triangles.

    Parameters
    ----------
    projected : Projected
    triangle : (m,) int
    weights : (m, 3) float64
      Barycentric coordinates on the screen.
    lights, material, formats
      As for :func:`phong`.

    Returns
    -------
    (m, 3) float64
      As for :func:`phong`.
    """
    lit = lit_mesh(projected, lights, material, 2.0**formats.value_bits - 1)
    if lit is not None:
        owner = np.ascontiguousarray(triangle, dtype=np.int64)
        return shade_places(lit, owner, np.ascontiguousarray(weights, dtype=np.float64))
    values = np.empty((len(triangle), 3))
    for rows in _chunks(len(triangle)):
        light = reflected(projected, triangle[rows], weights[rows, None, :], lights, material)
        values[rows] = full_scale(light[:, 0], formats)
    return values


def _chunks(count: int) -> list[slice]:
    """Slices that keep the memory of intermediate arrays bounded."""
    return [slice(start, start + CHUNK) for start in range(0, count, CHUNK)]
