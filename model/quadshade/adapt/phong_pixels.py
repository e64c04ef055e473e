# SPDX-License-Identifier: Apache-2.0
"""Phong shading at every pixel of an undivided mesh, once; drawn parts are compared with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from quadshade.choices import MAX_ERROR
from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import colour_state
from quadshade.contract.triangles import ScreenTriangles
from quadshade.golden.compiled import draw_packets
from quadshade.golden.compiled_packets import DecodedPackets, decode_packets
from quadshade.golden.shade.render_core import ShadeGiven, shade_given, shade_values
from quadshade.scene.project import Projected
from quadshade.setup.coverage import MeshRows, mesh_rows, pixels_of
from quadshade.setup.edges import Cut, cut_triangles
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.phong_loops import lit_mesh, shade_pixels, shade_rows
from quadshade.shading.reference import phong

BLOCK = 1024
"""Pixels that are drawn before they are compared, about: they stay in the cache."""

COLOURS = 3

NO_SHADE = ShadeGiven(
    np.zeros(3, np.int64), np.zeros((0, 3), np.int64), np.zeros((0, 0), np.int64), 0, 0, 1, 1
)
"""What is given where there is no shade unit."""


@njit(cache=True, error_model="numpy")
def _compare(
    decoded: DecodedPackets,
    owner: Ints,
    root: Ints,
    shaded: bool,
    given: ShadeGiven,
    rows: MeshRows,
    light: Floats,
    errors: Floats,
    outside: Ints,
) -> int:
    """
    Draw packets and compare their pixels: (parts, 4) largest, sum of squares, count, and the highest value of
    a lane with a power table.

    ``outside`` (k, 6) gets part, x, y and the value of pixels that the undivided triangle does not have: a
    part's corners are rounded. Returned is how many.
    """
    top, first_row, left, places = rows
    found, first, packets = 0, 0, len(owner)
    first_rows, widths = decoded.scanlines.first_rows, decoded.scanlines.pixels
    while first < packets:
        last, total = first, 0
        while last < packets and total < BLOCK:
            for row in range(first_rows[last], first_rows[last + 1]):
                total += widths[row]
            last += 1
        packet, x, y, value = draw_packets(decoded, first, last)
        colour = value
        if shaded:
            colour = shade_values(value[:, : len(given.coefficients)], given)
        index = 0
        for row_of_packet in range(first_rows[first], first_rows[last]):
            pixels = widths[row_of_packet]
            if not pixels:
                continue
            part = owner[first + packet[index]]
            triangle = root[part]
            row = first_row[triangle] + y[index] - top[triangle]
            low, high = np.int64(0), np.int64(0)
            if first_row[triangle] <= row < first_row[triangle + 1]:
                low, high = left[row], left[row] + places[row + 1] - places[row]
            begin = places[row] - low if high > low else 0
            for number in range(len(given.tables)):
                if not given.linear >> number & 1:
                    lane = len(given.coefficients) - len(given.tables) + number
                    for pixel in range(index, index + pixels):
                        errors[part, 3] = max(errors[part, 3], float(value[pixel, lane]))
            red = green = blue = square = 0.0
            for pixel in range(index, index + pixels):
                if not low <= x[pixel] < high:
                    if found < len(outside):
                        outside[found, 0], outside[found, 1], outside[found, 2] = part, x[pixel], y[pixel]
                        for channel in range(3):
                            outside[found, 3 + channel] = colour[pixel, channel]
                    found += 1
                    continue
                place = begin + x[pixel]
                one = abs(colour[pixel, 0] - light[0, place])
                two = abs(colour[pixel, 1] - light[1, place])
                three = abs(colour[pixel, 2] - light[2, place])
                # Of each colour by itself: none waits for another.
                red, green, blue = max(red, one), max(green, two), max(blue, three)
                square += one * one + two * two + three * three
            worst = max(red, green, blue)
            errors[part, 0] = max(errors[part, 0], worst)
            errors[part, 1] += square
            errors[part, 2] += pixels
            index += pixels
        first = last
    return found


@njit(cache=True, error_model="numpy")
def _ranges(rows: MeshRows, light: Floats) -> Floats:
    """See :attr:`PhongPixels.ranges`."""
    out = np.zeros((len(rows.top), 3))
    for index in range(len(out)):
        first, last = rows.places[rows.rows[index]], rows.places[rows.rows[index + 1]]
        if last == first:
            continue
        red, green, blue = light[0, first], light[1, first], light[2, first]
        most_red, most_green, most_blue = red, green, blue
        for place in range(first + 1, last):
            red, most_red = min(red, light[0, place]), max(most_red, light[0, place])
            green, most_green = min(green, light[1, place]), max(most_green, light[1, place])
            blue, most_blue = min(blue, light[2, place]), max(most_blue, light[2, place])
        out[index, 0], out[index, 1], out[index, 2] = most_red - red, most_green - green, most_blue - blue
    return out


@dataclass(frozen=True)
class PartErrors:
    """
    Drawn pixels of parts against Phong shading.

    Attributes
    ----------
    largest : (n,) float64
      Output units.
    square : (n,) float64
      Sum of the squared differences over pixels and colours.
    pixels : (n,) float64
      How many were drawn.
    highest : (n,) float64
      The highest value of a lane with a power table, -1 without one.
    """

    largest: np.ndarray
    square: np.ndarray
    pixels: np.ndarray
    highest: np.ndarray

    def by(self, measure: str) -> float:
        """The error of the picture: the largest or the root mean square."""
        if measure == "max":
            return float(self.largest.max(initial=0))
        return float(np.sqrt(self.square.sum() / max(COLOURS * self.pixels.sum(), 1)))


class PhongPixels:
    """
    Phong shading of a mesh at its pixels, shaded when it is first asked for.

    Parameters
    ----------
    whole : Projected
      The undivided mesh.
    lights : sequence of lights
    material : Material
    formats : Formats
    """

    def __init__(
        self, whole: Projected, lights: Sequence[Light], material: Material, formats: Formats
    ) -> None:
        self.whole, self.lights, self.material, self.formats = whole, lights, material, formats
        self.lit = lit_mesh(whole, lights, material, 2.0**formats.value_bits - 1)
        self._rows: MeshRows | None = None
        self._light = np.empty((3, 0))

    @cached_property
    def cut(self) -> Cut:
        """What covers pixels."""
        screen = self.whole.width, self.whole.height
        return cut_triangles(self.whole.vertices, *screen, self.formats.subpixel_bits)

    @cached_property
    def ranges(self) -> Floats:
        """(n, 3) float64 largest less smallest light of each triangle's pixels; 0 without one."""
        return _ranges(*self.pixels)

    @property
    def pixels(self) -> tuple[MeshRows, Floats]:
        """All pixels, and (3, pixels) the light at each, in output units, not rounded."""
        if self._rows is None:
            rows = mesh_rows(self.cut, len(self.whole))
            if self.lit is None:
                self._light = np.ascontiguousarray(self._phong(*pixels_of(rows)).T)
            else:
                self._light = np.empty((3, int(rows.places[-1])))
                shade_rows(self.lit, rows, self.formats.subpixel_bits, self._light)
            self._rows = rows
        return self._rows, self._light

    def _phong(self, triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        if self.lit is not None:
            return shade_pixels(self.lit, triangle, x, y, self.formats.subpixel_bits)
        return phong(self.whole, triangle, x, y, self.lights, self.material, self.formats)

    def errors(self, triangles: ScreenTriangles, root: np.ndarray, formats: Formats) -> np.ndarray:
        """
        Draw with the golden model and compare every pixel.

        Parameters
        ----------
        triangles : ScreenTriangles
        root : (n,) int64
          The triangle of the undivided mesh that each is a part of.
        formats : Formats
          Of the core that draws them.

        Returns
        -------
        (n, 4) float64
          Largest difference of any channel, sum of squared differences over pixels and channels, pixels, and
          the highest value of a lane with a power table, -1 without one.
        """
        primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
        decoded = decode_packets(pack(primitives, formats), formats.core)
        # Depth is not compared, so it is not drawn.
        colours = np.ascontiguousarray(decoded.differences[:, : formats.num_channels])
        decoded = decoded._replace(differences=colours)
        errors, shaded = np.zeros((len(triangles), 4)), bool(formats.with_shade)
        errors[:, 3] = -1
        given = NO_SHADE
        if shaded:
            state = colour_state(formats) if triangles.shade is None else triangles.shade
            given = shade_given(state, formats)
        outside = np.empty((256, 6), np.int64)
        arguments = decoded, primitives.triangle, root, shaded, given, *self.pixels
        found = _compare(*arguments, errors, outside)
        if found > len(outside):
            errors[:, :3], outside = 0, np.empty((found, 6), np.int64)
            _compare(*arguments, errors, outside)
        if found:
            part, x, y = np.ascontiguousarray(outside[:found, :3].T)
            off = abs(outside[:found, 3:] - self._phong(root[part], x, y))
            np.maximum.at(errors[:, 0], part, off.max(axis=1))
            np.add.at(errors[:, 1], part, (off**2).sum(axis=1))
        return errors
