# SPDX-License-Identifier: Apache-2.0
"""What the set-up is tested against: the hardware's walk, half-plane coverage, and exact rational colour."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numba import njit

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.setup.packet import Primitives


@njit(cache=True)
def _signed(value, bits):
    return ((value + (1 << (bits - 1))) & ((1 << bits) - 1)) - (1 << (bits - 1))


@njit(cache=True)
def _walk(heads, edges, column_bits, error_bits, edge_bits, coord_bits, out):
    """
    Walk every primitive as the hardware does, in its widths; the number of pixels (written if they fit).
    """
    count = 0
    for p in range(len(heads)):
        y, rows_first, rows_second, mirror = heads[p]
        major, minor = edges[p, 0].copy(), edges[p, 1].copy()
        carries = 0
        for row in range(rows_first + rows_second):
            if row == rows_first:
                minor[:] = edges[p, 2]
            n = 0
            u = major[0]
            while _signed(u - minor[0], column_bits) < 0:
                if count < len(out):
                    x = (-1 - u if mirror else u) & ((1 << coord_bits) - 1)
                    out[count] = (p, x, y + row, row, carries + n, n)
                count += 1
                u += 1
                n += 1
            if row == rows_first + rows_second - 1 or row == 0:
                assert n > 0, "a primitive's first or last scanline is empty"
            for edge, which in ((major, 0), (minor, 1)):
                carry = edge[1] >= 0
                edge[0] = _signed(edge[0] + edge[2] + carry, column_bits)
                edge[1] = _signed(edge[1] + (edge[4] if carry else edge[3]), error_bits)
                if which == 0:
                    carries += carry
    return count


def walk(primitives: Primitives, formats: Formats) -> dict[str, np.ndarray]:
    """
    Pixels of all primitives: primitive, x, y, m (scanline), n_lattice (carries + n), n (pixel in its span).
    """
    heads = np.stack([primitives.header[f] for f in ("y", "rows_first", "rows_second", "mirror")], axis=1)
    fields = ("column", "error", "step", "increment", "decrement")
    edges = np.stack(
        [np.stack([primitives.edges[e][f] for f in fields], axis=1) for e in ("major", "minor", "second")],
        axis=1,
    )
    for field, bits in (("increment", formats.edge_bits), ("error", formats.error_bits - 1)):
        part = edges[:, :, fields.index(field)]
        assert ((part >= -(1 << bits)) & (part < (1 << bits))).all(), f"{field} does not fit"
    widths = (formats.column_bits, formats.error_bits, formats.edge_bits, formats.coord_bits)
    out = np.zeros((0, 6), np.int64)
    count = _walk(heads, edges, *widths, out)
    out = np.zeros((count, 6), np.int64)
    _walk(heads, edges, *widths, out)
    return dict(zip(("primitive", "x", "y", "m", "n_lattice", "n"), out.T, strict=True))


@njit(cache=True)
def _values(primitive, row, n, carries, fractional, words, word_width, out):
    """One channel stepped as the hardware steps it, to every pixel of a walk; words of up to 60 bits."""
    half, mask = 1 << (word_width - 1), (1 << word_width) - 1
    last = -1
    for at in range(len(primitive)):
        value, d_row, d_col, dd_row, dd_mixed, dd_col = words[primitive[at]]
        if primitive[at] != last:
            last = primitive[at]
            start, start_row, column_step = value, d_row, d_col
            done, done_carries = 0, 0
        # Scanlines without a pixel (slivers) are stepped over; where their carries fall does not matter.
        while done < row[at]:
            carry = carries[at] - done_carries >= row[at] - done or (
                done_carries < carries[at] and (done + carries[at]) % 2 == 0
            )
            done += 1
            done_carries += carry
            if fractional[primitive[at]]:
                carry = False
            column_step = (column_step + dd_mixed + (dd_col if carry else 0)) & mask
            start = (start + start_row + (column_step if carry else 0)) & mask
            start_row = (start_row + dd_row + (dd_mixed if carry else 0)) & mask
        pixel, step = start, (column_step + dd_col) & mask
        for _ in range(n[at]):
            pixel, step = (pixel + step) & mask, (step + dd_col) & mask
        out[at] = ((pixel + half) & mask) - half


def stepped_values(primitives: Primitives, pixels: dict[str, np.ndarray], formats: Formats) -> np.ndarray:
    """(n, channels) raw words at the pixels of a walk, by the hardware's additions alone."""
    out = np.zeros((len(pixels["x"]), formats.carried_channels), np.int64)
    for channel in range(formats.carried_channels):
        _values(
            pixels["primitive"],
            pixels["m"],
            pixels["n"],
            pixels["n_lattice"] - pixels["n"],
            primitives.header["fractional"],
            np.ascontiguousarray(primitives.words[:, channel]),
            formats.word_width,
            out[:, channel],
        )
    return out


@njit(cache=True)
def _half_planes(vertices, pixel, width, height, out):
    count = 0
    for t in range(len(vertices)):
        ax, ay, bx, by, cx, cy = vertices[t].ravel()
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        if area < 0:
            bx, by, cx, cy = cx, cy, bx, by
        x_low, x_high = min(ax, bx, cx) // pixel - 1, max(ax, bx, cx) // pixel + 1
        y_low, y_high = min(ay, by, cy) // pixel - 1, max(ay, by, cy) // pixel + 1
        for y in range(max(y_low, 0), min(y_high + 1, height)):
            for x in range(max(x_low, 0), min(x_high + 1, width)):
                px, py = pixel * (2 * x + 1), pixel * (2 * y + 1)
                inside = True
                for sx, sy, ex, ey in ((ax, ay, bx, by), (bx, by, cx, cy), (cx, cy, ax, ay)):
                    dx, dy = ex - sx, ey - sy
                    side = dx * (py - 2 * sy) - dy * (px - 2 * sx)
                    if side < 0 or (side == 0 and not (dy < 0 or (dy == 0 and dx > 0))):
                        inside = False
                        break
                if inside:
                    if count < len(out):
                        out[count] = (t, x, y)
                    count += 1
    return count


def half_plane_pixels(vertices: np.ndarray, width: int, height: int, subpixel_bits: int) -> np.ndarray:
    """(n, 3) triangle, x, y covered under the top-left rule, by integer half-plane tests of every pixel."""
    vertices = np.ascontiguousarray(vertices, np.int64)
    out = np.zeros((0, 3), np.int64)
    count = _half_planes(vertices, 1 << subpixel_bits, width, height, out)
    out = np.zeros((count, 3), np.int64)
    _half_planes(vertices, 1 << subpixel_bits, width, height, out)
    return out


def exact_quadratic(vertices: np.ndarray, samples: np.ndarray, order: int):
    """
    Quadratic (linear, constant) of one channel as a function of x, y in sub-pixels, in exact rationals.

    Lagrange's form over the barycentric coordinates, on purpose not the unit triangle's form of the set-up.
    """
    (x1, y1), (x2, y2), (x3, y3) = ([Fraction(int(c)) for c in v] for v in vertices)
    area = (x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1)
    value = [Fraction(float(s)) for s in samples[: (1, 3, 6)[order]]]

    def evaluate(x: Fraction, y: Fraction) -> Fraction:
        if order == 0:
            return value[0]
        b = ((x - x1) * (y3 - y1) - (y - y1) * (x3 - x1)) / area
        c = ((x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)) / area
        a = 1 - b - c
        if order == 1:
            return a * value[0] + b * value[1] + c * value[2]
        return (
            a * (2 * a - 1) * value[0]
            + b * (2 * b - 1) * value[1]
            + c * (2 * c - 1) * value[2]
            + 4 * (a * b * value[3] + a * c * value[4] + b * c * value[5])
        )

    return evaluate


def screen_triangles(
    vertices: np.ndarray,
    formats: Formats,
    width: int | None = None,
    height: int | None = None,
    samples: np.ndarray | None = None,
    order: int = 2,
) -> ScreenTriangles:
    """Triangles in mid-grey, or with the given samples, on a screen of the full size if none is given."""
    count, channels = len(vertices), formats.num_channels
    if samples is None:
        samples = np.full((count, channels, 6), (1 << formats.value_bits) / 2)
    return ScreenTriangles(
        width or 1 << formats.coord_bits,
        height or 1 << formats.coord_bits,
        np.asarray(vertices, np.int64),
        samples,
        np.full((count, channels), order),
        None,
        tuple("rgbabcde"[:channels]),
    )
