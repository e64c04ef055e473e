# SPDX-License-Identifier: Apache-2.0
"""The colours at six points of every triangle, from which the hardware interpolates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit

from quadshade.choices import SHADING_ORDERS
from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import CONSTANT, LINEAR, QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.taylor import expansion

CHANNELS = ("r", "g", "b")

SAMPLE_POINTS = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]], dtype=np.float64
)
"""Where I1, I2, I3, I12, I13, I23 are taken, in barycentric coordinates of the screen."""

CENTRE = np.full((1, 3), 1 / 3)

TAYLOR_POINTS, TAYLOR_SHARES = expansion(SAMPLE_POINTS, CENTRE)
"""Where Taylor's quadratic at the centre is taken from, and shares of these values in the six samples."""

CHUNK = 2048
"""Triangles shaded at a time: what lies between the steps stays in the cache."""


def sample(
    projected: Projected,
    shading: str = "quadratic",
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    x_shading: bool = False,
    taylor: bool = False,
) -> ScreenTriangles:
    """
    Shade each triangle at the points that its order needs (Abbas et al., section 3).

    Parameters
    ----------
    projected : Projected
    shading : str
      ``flat`` (the centre), ``gouraud`` (the vertices) or ``quadratic`` (vertices and middles of the edges).
    lights : sequence of lights, optional
      By default those that go with the viewer.
    material : Material, optional
    formats : Formats, optional
      Gives the largest value and whether there is a depth channel.
    x_shading : bool
      Middles of edges take their normals from :func:`middle_normals` (quadratic shading).
    taylor : bool
      Values of Taylor's quadratic at the centre (:mod:`quadshade.shading.taylor`; quadratic shading).

    Returns
    -------
    ScreenTriangles
      Channels r, g, b; intensities clamped to 0 .. 2**value_bits - 1.

    Raises
    ------
    QuadshadeError
      An unknown shading, or a user's reflectance that fails.
    """
    formats = Formats() if formats is None else formats
    material = Material() if material is None else material
    lights = default_lights(projected.axes) if lights is None else lights
    if shading not in SHADING_ORDERS:
        raise QuadshadeError(f"the shading is {shading!r}", f"give one of {', '.join(SHADING_ORDERS)}")
    order = SHADING_ORDERS[shading]
    points = CENTRE if order == CONSTANT else SAMPLE_POINTS[: 3 if order == LINEAR else 6]
    count, taylor = len(projected), taylor and order == QUADRATIC
    places = TAYLOR_POINTS if taylor else points
    samples = np.zeros((count, len(CHANNELS), len(SAMPLE_POINTS)))
    for start in range(0, count, CHUNK):
        rows = slice(start, start + CHUNK)
        normal = middle_normals(projected.normal[rows]) if x_shading and order == QUADRATIC else None
        light = reflected(projected, np.arange(count)[rows], places, lights, material, normal)
        if taylor:
            light = TAYLOR_SHARES @ light
        samples[rows, :, : len(points)] = full_scale(light, formats).transpose(0, 2, 1)
    return ScreenTriangles(
        projected.width,
        projected.height,
        projected.vertices,
        samples,
        np.full((count, len(CHANNELS)), order, dtype=np.int64),
        projected.depth if formats.with_depth else None,
        CHANNELS,
    )


def widened(triangles: ScreenTriangles, channels: int) -> ScreenTriangles:
    """The same triangles with channels of constant 0 behind theirs, for a core that has more of them."""
    more = channels - len(triangles.channels)
    return replace(
        triangles,
        samples=np.pad(triangles.samples, ((0, 0), (0, more), (0, 0))),
        orders=np.pad(triangles.orders, ((0, 0), (0, more)), constant_values=CONSTANT),
        channels=(*triangles.channels, *(f"unused{index}" for index in range(more))),
    )


def full_scale(light: np.ndarray, formats: Formats) -> np.ndarray:
    """Intensities of 0 .. 1 in output units, clamped to what the output holds."""
    return np.clip(light, 0, 1) * (2.0**formats.value_bits - 1)


def reflected(
    projected: Projected,
    triangle: np.ndarray,
    barycentric: np.ndarray,
    lights: Sequence[Light],
    material: Material,
    normal: np.ndarray | None = None,
) -> np.ndarray:
    """
    Light reflected at points of triangles, with interpolated and normalised normals.

    Parameters
    ----------
    projected : Projected
    triangle : (m,) int
    barycentric : (k, 3) float, the same points for every triangle, or (m, k, 3) float
      On the screen; positions and normals are interpolated with perspective.
    lights : sequence of lights
    material : Material
    normal : (m, k, 3) float, optional
      Normals to take instead of interpolated ones.

    Returns
    -------
    (m, k, 3) float64
      1 is full intensity; not clamped.
    """
    point, normal, base, to_viewer = surface(projected, triangle, barycentric, normal)
    light = material.reflect(lights, point, normal, to_viewer, base)
    return light.reshape(len(triangle), np.shape(barycentric)[-2], len(CHANNELS))


def surface(
    projected: Projected, triangle: np.ndarray, barycentric: np.ndarray, normal: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray]:
    """
    The surface at points of triangles, interpolated with perspective.

    Parameters
    ----------
    projected, triangle, barycentric, normal
      As for :func:`reflected`.

    Returns
    -------
    point, normal : (m * k, 3) float64
      In the scene; the normals are unit length.
    base : (m * k, 3) float64 or None
      The mesh's own colours.
    to_viewer : (3,) or (m * k, 3) float64
      Unit length.
    """
    places = np.broadcast_to(barycentric, (len(triangle), *barycentric.shape[-2:]))
    share = _shares(places, projected.weight, triangle)

    def at_points(corners: np.ndarray) -> np.ndarray:
        return _interpolate(corners, triangle, share)

    point = at_points(projected.position)
    normal = unit(at_points(projected.normal)) if normal is None else normal.reshape(-1, 3)
    base = None if projected.colour is None else at_points(projected.colour)
    to_viewer = projected.axes[2] if projected.eye is None else unit(projected.eye - point)
    return point, normal, base, to_viewer


def middle_normals(corners: np.ndarray) -> np.ndarray:
    """
    Normals of X-shading: no square root between the vertices (Barrera et al., equation 27).

    Parameters
    ----------
    corners : (n, 3, 3) float
      Normals at the vertices, of any length.

    Returns
    -------
    (n, 6, 3) float64
      N1, N2, N3 at unit length, then ``(Ni + Nj) (5 - Ni . Nj) / 8`` of the edges 12, 13, 23.
    """
    normals = unit(np.ascontiguousarray(corners, dtype=np.float64).reshape(-1, 3)).reshape(-1, 3, 3)
    one, two = normals[:, [0, 0, 1]], normals[:, [1, 2, 2]]
    middles = (one + two) * (5 - np.einsum("nei,nei->ne", one, two)[..., None]) / 8
    return np.concatenate([normals, middles], axis=1)


@njit(cache=True, error_model="numpy")
def unit(vectors: Floats) -> Floats:
    """(m, 3) vectors at unit length; zero stays zero."""
    out = np.empty_like(vectors)
    for index in range(len(vectors)):
        x, y, z = vectors[index, 0], vectors[index, 1], vectors[index, 2]
        # Added up in this order, colours are to the last bit what they always were.
        length = np.sqrt(x * x + z * z + y * y)
        length = length if length > 0 else 1.0
        out[index, 0], out[index, 1], out[index, 2] = x / length, y / length, z / length
    return out


@njit(cache=True, error_model="numpy")
def _shares(places: Floats, weight: Floats, triangle: Ints) -> Floats:
    """(m, k, 3) shares of the corners, in the scene, at (m, k, 3) places on the screen."""
    out = np.empty(places.shape)
    for index in range(len(triangle)):
        weights = weight[triangle[index]]
        for place in range(places.shape[1]):
            here = places[index, place]
            one, two, three = here[0] * weights[0], here[1] * weights[1], here[2] * weights[2]
            total = one + two + three
            out[index, place, 0], out[index, place, 1], out[index, place, 2] = (
                one / total,
                two / total,
                three / total,
            )
    return out


@njit(cache=True)
def _interpolate(corners: Floats, triangle: Ints, share: Floats) -> Floats:
    """(m * k, 3) float64: what corners (n, 3, 3) carry, at shares (m, k, 3) of triangles (m,)."""
    points = share.shape[1]
    out = np.empty((len(triangle) * points, 3))
    for index in range(len(triangle)):
        corner = corners[triangle[index]]
        for point in range(points):
            part = share[index, point]
            for axis in range(3):
                out[index * points + point, axis] = (
                    part[0] * corner[0, axis] + part[1] * corner[1, axis] + part[2] * corner[2, axis]
                )
    return out
