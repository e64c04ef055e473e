# SPDX-License-Identifier: Apache-2.0
"""
A scanline renderer with a z-buffer that shades each triangle by Gouraud's or by Phong's rule, in float.

Both rules run in one compiled loop over the core's exact coverage, so the ratio of their times is the rules'.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from quadshade.contract.formats import Formats
from quadshade.scene.project import Projected
from quadshade.shading.light_loops import COLOURS, compiled_surface, light_point
from quadshade.shading.lights import Light
from quadshade.shading.material import Material

CARRIED = 7
"""What a triangle of Phong's rule carries: normal and position times weight, and the weight."""
KEPT = 4096
"""Colours of vertices that are kept for the next triangles."""


@dataclass(frozen=True)
class Picture:
    """
    What the renderer drew.

    Attributes
    ----------
    value : (height, width, 3) float64
      Red, green, blue in output units, not rounded; 0 where nothing was drawn.
    triangle : (height, width) int32
      The nearest triangle, -1 where there is none.
    depth : (height, width) float64
      The z-buffer, infinite where there is none.
    """

    value: np.ndarray
    triangle: np.ndarray
    depth: np.ndarray

    @classmethod
    def empty(cls, width: int, height: int) -> Picture:
        """A picture of pixels without a triangle."""
        made = cls(
            np.empty((height, width, COLOURS)),
            np.empty((height, width), np.int32),
            np.empty((height, width)),
        )
        made.clear()
        return made

    def clear(self) -> None:
        """Take everything away."""
        self.value.fill(0)
        self.triangle.fill(-1)
        self.depth.fill(np.inf)


def draw_software(
    projected: Projected,
    lights: Sequence[Light],
    material: Material | None = None,
    per_pixel: np.ndarray | None = None,
    formats: Formats | None = None,
    over: Picture | None = None,
) -> Picture:
    """
    Draw triangles with Gouraud shading, some with Phong shading.

    Parameters
    ----------
    projected : Projected
      Without colours of its own, seen in perspective.
    lights : sequence of AmbientLight or PointLight
    material : Material, optional
    per_pixel : (n,) bool, optional
      Triangles to light at every pixel; by default none.
    formats : Formats, optional
      Gives the sub-pixel bits and the largest value.
    over : Picture, optional
      Of the same size, to be cleared and drawn into; by default a new one.

    Returns
    -------
    Picture

    Raises
    ------
    QuadshadeError
      A light, a material or a view of another kind.
    """
    formats = Formats() if formats is None else formats
    material = Material() if material is None else material
    if per_pixel is None:
        per_pixel = np.zeros(len(projected), dtype=bool)
    surface = compiled_surface(projected, lights, material, 2.0**formats.value_bits - 1)
    if over is None:
        over = Picture.empty(projected.width, projected.height)
    else:
        over.clear()
    _draw(
        projected.vertices, projected.depth, projected.position, projected.normal, projected.weight,
        per_pixel, surface, formats.subpixel_bits, over.value, over.depth, over.triangle,
    )  # fmt: skip
    return over


@njit(cache=True)
def _same(one, other):
    """Whether two rows of numbers are equal."""
    for index in range(len(one)):
        if one[index] != other[index]:
            return False
    return True


@njit(cache=True, error_model="numpy")
def _light_corners(vertices, position, normal, index, surface, keepers, kept, out):
    """
    Colours (3, 3 of 7) of one triangle's corners; a vertex that triangles share is lit once.

    ``keepers`` (s,) says whose corner (3 triangle + corner) the colour in ``kept`` (s, 3) is, -1: nobody's.
    """
    for corner in range(3):
        place, point, turn = vertices[index, corner], position[index, corner], normal[index, corner]
        slot = (place[0] * 31 + place[1]) % len(keepers)
        known, at = keepers[slot] // 3, keepers[slot] % 3
        if known < 0 or not (_same(position[known, at], point) and _same(normal[known, at], turn)):
            light_point(turn, point, surface, kept[slot])
            keepers[slot] = 3 * index + corner
        for part in range(COLOURS):
            out[corner, part] = kept[slot, part]


@njit(cache=True)
def _carry(position, normal, weight, out):
    """(3, 7) what Phong's rule needs and is linear on the screen, at one triangle's corners."""
    for corner in range(3):
        for axis in range(3):
            out[corner, axis] = normal[corner, axis] * weight[corner]
            out[corner, 3 + axis] = position[corner, axis] * weight[corner]
        out[corner, 6] = weight[corner]


@njit(cache=True)
def _edges(vertices, subpixel_bits, steps, offsets):
    """
    Edge functions of one triangle: integers, positive inside, at the centre of pixel x, y.

    ``steps`` (3, 2) is the change a column and a row, ``offsets`` (3,) the value at pixel 0, 0; edge e lies
    opposite corner e, and function e over the doubled area is that corner's weight. Returns the doubled area.
    """
    one, two, three = vertices[0], vertices[1], vertices[2]
    area = (two[0] - one[0]) * (three[1] - one[1]) - (three[0] - one[0]) * (two[1] - one[1])
    sign = 1 if area > 0 else -1
    half = (1 << subpixel_bits) >> 1
    for edge in range(3):
        start, end = vertices[(edge + 1) % 3], vertices[(edge + 2) % 3]
        across, down = sign * (start[1] - end[1]), sign * (end[0] - start[0])
        offsets[edge] = across * (half - start[0]) + down * (half - start[1])
        steps[edge, 0], steps[edge, 1] = across << subpixel_bits, down << subpixel_bits
    return sign * area


@njit(cache=True)
def _span(steps, offsets, y, width):
    """First and last column of a scanline, the last smaller where there is none; top-left rule."""
    first, last = 0, width - 1
    for edge in range(3):
        across, down = steps[edge, 0], steps[edge, 1]
        # A centre on the edge itself is inside where the edge is a left or a top one.
        least = 0 if across > 0 or (across == 0 and down > 0) else 1
        missing = least - (offsets[edge] + down * y)
        if across > 0:
            first = max(first, -(-missing // across))
        elif across < 0:
            last = min(last, missing // across)
        elif missing > 0:
            last = -1
    return first, last


@njit(cache=True)
def _linear_span(row, columns, z, z_step, here, step, index, frame, nearest, triangle):
    """Pixels of a span by Gouraud's rule."""
    first, last = columns
    red, green, blue = here[0], here[1], here[2]
    red_step, green_step, blue_step = step[0], step[1], step[2]
    for x in range(first, last + 1):
        if z < nearest[row, x]:
            nearest[row, x] = z
            triangle[row, x] = index
            frame[row, x, 0], frame[row, x, 1], frame[row, x, 2] = red, green, blue
        z += z_step
        red += red_step
        green += green_step
        blue += blue_step


@njit(cache=True, error_model="numpy")
def _exact_span(row, columns, z, z_step, here, step, index, surface, point, frame, nearest, triangle):
    """Pixels of a span by Phong's rule."""
    first, last = columns
    for x in range(first, last + 1):
        if z < nearest[row, x]:
            nearest[row, x] = z
            triangle[row, x] = index
            for axis in range(3):
                point[axis] = here[3 + axis] / here[6]
            light_point(here, point, surface, frame[row, x])
        z += z_step
        for part in range(CARRIED):
            here[part] += step[part]


@njit(cache=True, error_model="numpy")
def _draw(
    vertices, depth, position, normal, weight, per_pixel, surface, subpixel_bits, frame, nearest, triangle
):
    """Every triangle into the frame, the z-buffer and the map of triangles."""
    height, width = nearest.shape
    keepers, kept = np.full(KEPT, -1), np.empty((KEPT, COLOURS))
    corners = np.empty((3, CARRIED))
    here, step = np.empty((2, CARRIED))
    point = np.empty(3)
    edge_steps, edge_offsets = np.empty((3, 2), np.int64), np.empty(3, np.int64)
    for index in range(len(vertices)):
        exact = per_pixel[index]
        count = CARRIED if exact else COLOURS
        if exact:
            _carry(position[index], normal[index], weight[index], corners)
        else:
            _light_corners(vertices, position, normal, index, surface, keepers, kept, corners)
        area = _edges(vertices[index], subpixel_bits, edge_steps, edge_offsets)
        top, bottom = vertices[index, :, 1].min(), vertices[index, :, 1].max()
        for y in range(max(top >> subpixel_bits, 0), min((bottom >> subpixel_bits) + 1, height)):
            columns = _span(edge_steps, edge_offsets, y, width)
            if columns[1] < columns[0]:
                continue
            here[:count], step[:count] = 0, 0
            z = z_step = 0.0
            for corner in range(3):
                at = edge_offsets[corner] + edge_steps[corner, 1] * y + edge_steps[corner, 0] * columns[0]
                share, change = at / area, edge_steps[corner, 0] / area
                z += share * depth[index, corner]
                z_step += change * depth[index, corner]
                for part in range(count):
                    here[part] += share * corners[corner, part]
                    step[part] += change * corners[corner, part]
            if exact:
                _exact_span(
                    y, columns, z, z_step, here, step, index, surface, point, frame, nearest, triangle
                )
            else:
                _linear_span(y, columns, z, z_step, here, step, index, frame, nearest, triangle)
