# SPDX-License-Identifier: Apache-2.0
"""Phong shading at every pixel of an undivided mesh, once; drawn parts are compared with it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from quadshade.choices import MAX_ERROR
from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import CONSTANT, Formats
from quadshade.contract.shade_state import colour_state
from quadshade.contract.triangles import ScreenTriangles
from quadshade.golden.compiled import draw_packets
from quadshade.golden.compiled_packets import DecodedPackets, decode_packets
from quadshade.golden.shade.render_core import ShadeGiven, shade_given, shade_values
from quadshade.scene.project import Projected
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.phong_loops import LitMesh, lit_mesh, pixel_light
from quadshade.shading.reference import phong

BLOCK = 1024
"""Pixels that are drawn before they are compared, about: they stay in the cache."""


NO_SHADE = ShadeGiven(
    np.zeros(3, np.int64), np.zeros((0, 3), np.int64), np.zeros((0, 0), np.int64), 0, 0, 1, 1
)
"""What is given where there is no shade unit."""


class MeshPixels(NamedTuple):
    """
    The pixels of every triangle, row by row, and the light at each.

    Attributes
    ----------
    top : (n,) int64
      First scanline of each triangle.
    rows : (n + 1,) int64
      Where its scanlines begin among all.
    left : (scanlines,) int64
      First column of each.
    places : (scanlines + 1,) int64
      Where its pixels begin among all.
    light : (pixels, 3) float64
      Output units, not rounded.
    """

    top: Ints
    rows: Ints
    left: Ints
    places: Ints
    light: Floats


def covered_packets(projected: Projected, formats: Formats) -> tuple[np.ndarray, DecodedPackets]:
    """
    What covers pixels, without colour.

    Parameters
    ----------
    projected : Projected
    formats : Formats

    Returns
    -------
    owner : (k,) int64
      The triangle that each packet draws a part of.
    packets : DecodedPackets
    """
    plain = {"num_channels": 1, "max_order": CONSTANT, "with_depth": 0, "with_shade": 0, "stream_width": 32}
    plain_formats = formats.with_generics(plain)
    shape = (len(projected), 1)
    triangles = ScreenTriangles(
        projected.width, projected.height, projected.vertices, np.zeros((*shape, 6)), np.zeros(shape, int),
        None, ("none",),
    )  # fmt: skip
    primitives = setup_triangles(triangles, plain_formats)
    return primitives.triangle, decode_packets(pack(primitives, plain_formats), plain_formats)


@njit(cache=True)
def _mesh_rows(owner: Ints, decoded: DecodedPackets, count: int) -> tuple[Ints, Ints, Ints, Ints]:
    """``top``, ``rows``, ``left`` and ``places`` of :class:`MeshPixels`."""
    packets, scanlines, mask = decoded.packets, decoded.scanlines, decoded.layout.coord_mask
    top, bottom = np.full(count, mask), np.full(count, -1)
    for packet in range(len(packets)):
        triangle, first = owner[packet], packets[packet]["y"]
        height = scanlines.first_rows[packet + 1] - scanlines.first_rows[packet]
        top[triangle] = min(top[triangle], first)
        bottom[triangle] = max(bottom[triangle], first + height - 1)
    rows = np.zeros(count + 1, np.int64)
    for triangle in range(count):
        rows[triangle + 1] = rows[triangle] + max(bottom[triangle] - top[triangle] + 1, 0)
    left, width = np.zeros((2, rows[count]), np.int64)
    for packet in range(len(packets)):
        triangle, scanline = owner[packet], packets[packet]["y"]
        mirror = packets[packet]["mirror"]
        for row in range(scanlines.first_rows[packet], scanlines.first_rows[packet + 1]):
            pixels, start = scanlines.pixels[row], scanlines.start[row]
            at = rows[triangle] + scanline - top[triangle]
            left[at] = ((start + pixels - 1) & mask) ^ mask if mirror else start & mask
            width[at] = pixels
            scanline += 1
    places = np.zeros(len(width) + 1, np.int64)
    for row in range(len(width)):
        places[row + 1] = places[row] + width[row]
    return top, rows, left, places


@njit(cache=True, error_model="numpy")
def _pixels_of(pixels: MeshPixels) -> tuple[Ints, Ints, Ints]:
    """Triangle, x and y of every pixel."""
    triangle, x, y = np.empty((3, pixels.places[-1]), np.int64)
    for index in range(len(pixels.top)):
        for row in range(pixels.rows[index], pixels.rows[index + 1]):
            for place in range(pixels.places[row], pixels.places[row + 1]):
                triangle[place], x[place] = index, pixels.left[row] + place - pixels.places[row]
                y[place] = pixels.top[index] + row - pixels.rows[index]
    return triangle, x, y


def covered_pixels(projected: Projected, formats: Formats) -> tuple[Ints, Ints, Ints]:
    """(m,) int64 triangle, x and y of the pixels that the core covers, triangle by triangle, row by row."""
    rows = _mesh_rows(*covered_packets(projected, formats), len(projected))
    return _pixels_of(MeshPixels(*rows, np.empty((0, 3))))


@njit(cache=True, error_model="numpy")
def _shade_all(pixels: MeshPixels, lit: LitMesh, subpixel_bits: int) -> None:
    """Write the light at every pixel."""
    top, rows, left, places, light = pixels
    for index in range(len(top)):
        for row in range(rows[index], rows[index + 1]):
            y, x = top[index] + row - rows[index], left[row] - places[row]
            for place in range(places[row], places[row + 1]):
                light[place, 0], light[place, 1], light[place, 2] = pixel_light(
                    lit, index, x + place, y, subpixel_bits
                )


@njit(cache=True, error_model="numpy")
def _compare(
    decoded: DecodedPackets,
    owner: Ints,
    root: Ints,
    shaded: bool,
    given: ShadeGiven,
    pixels: MeshPixels,
    errors: Floats,
    outside: Ints,
) -> int:
    """
    Draw packets and compare their pixels: (parts, 3) largest, sum of squares and count.

    ``outside`` (k, 6) gets part, x, y and the value of pixels that the undivided triangle does not have: a
    part's corners are rounded. Returned is how many.
    """
    top, rows, left, places, light = pixels
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
        for index in range(len(x)):
            part = owner[first + packet[index]]
            triangle = root[part]
            row = rows[triangle] + y[index] - top[triangle]
            inside = rows[triangle] <= row < rows[triangle + 1]
            place = 0
            if inside:
                place = places[row] + x[index] - left[row]
                inside = places[row] <= place < places[row + 1]
            errors[part, 2] += 1
            if not inside:
                if found < len(outside):
                    outside[found, 0], outside[found, 1], outside[found, 2] = part, x[index], y[index]
                    for channel in range(3):
                        outside[found, 3 + channel] = colour[index, channel]
                found += 1
                continue
            for channel in range(3):
                off = abs(colour[index, channel] - light[place, channel])
                errors[part, 0] = max(errors[part, 0], off)
                errors[part, 1] += off * off
        first = last
    return found


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
        self._pixels: MeshPixels | None = None

    @property
    def pixels(self) -> MeshPixels:
        """All pixels."""
        if self._pixels is None:
            rows = _mesh_rows(*covered_packets(self.whole, self.formats), len(self.whole))
            pixels = MeshPixels(*rows, np.empty((int(rows[3][-1]), 3)))
            if self.lit is not None:
                _shade_all(pixels, self.lit, self.formats.subpixel_bits)
            else:
                pixels = pixels._replace(light=self._phong(*_pixels_of(pixels)))
            self._pixels = pixels
        return self._pixels

    def _phong(self, triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
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
        (n, 3) float64
          Largest difference of any channel, sum of squared differences over pixels and channels, pixels.
        """
        primitives = setup_triangles(triangles, formats, limit=MAX_ERROR)
        decoded = decode_packets(pack(primitives, formats), formats.core)
        errors, shaded = np.zeros((len(triangles), 3)), bool(formats.with_shade)
        given = NO_SHADE
        if shaded:
            state = colour_state(formats) if triangles.shade is None else triangles.shade
            given = shade_given(state, formats)
        outside = np.empty((256, 6), np.int64)
        arguments = decoded, primitives.triangle, root, shaded, given, self.pixels
        found = _compare(*arguments, errors, outside)
        if found > len(outside):
            errors, outside = np.zeros_like(errors), np.empty((found, 6), np.int64)
            _compare(*arguments, errors, outside)
        if found:
            part, x, y = outside[:found, :3].T
            off = abs(outside[:found, 3:] - self._phong(root[part], x, y))
            np.maximum.at(errors[:, 0], part, off.max(axis=1))
            np.add.at(errors[:, 1], part, (off**2).sum(axis=1))
        return errors
