# SPDX-License-Identifier: Apache-2.0
"""The highlight test and the search for a highlight's centre, compiled: a triangle at a time."""

from __future__ import annotations

import numpy as np
from numba import njit

from quadshade.contract.arrays import Bools, Floats, Ints

POINT = 2
"""In a row of :func:`quadshade.adapt.highlight.light_rows`: the light has a place, not a direction."""


@njit(cache=True)
def _dot(one: Floats, other: Floats) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@njit(cache=True)
def _cross(one: Floats, other: Floats, out: Floats) -> None:
    out[0] = one[1] * other[2] - one[2] * other[1]
    out[1] = one[2] * other[0] - one[0] * other[2]
    out[2] = one[0] * other[1] - one[1] * other[0]


@njit(cache=True)
def _toward(point: Floats, to: Floats, placed: bool, out: Floats) -> None:
    """The vector from a point to a place, or a direction."""
    for axis in range(3):
        out[axis] = to[axis] - point[axis] if placed else to[axis]


@njit(cache=True)
def named(position: Floats, normal: Floats, viewer: Floats, near: bool, lights: Floats) -> Bools:
    """
    (lights, n) whether triangles are potentially highlighted (tests H1 and H2).

    The signs of both conditions differ between vertices, or one is zero, and neither the light nor the viewer
    is behind all three: as :func:`quadshade.adapt.highlight.highlight_possible`.
    """
    out = np.zeros((len(lights), len(position)), np.bool_)
    light, view, cross = np.empty(3), np.empty(3), np.empty(3)
    for index in range(len(lights)):
        kind, place = lights[index, 0], lights[index, 1:]
        if kind == 0:
            continue
        for row in range(len(position)):
            low1 = low2 = np.inf
            high1 = high2 = -np.inf
            lit = seen = False
            for corner in range(3):
                point, turn = position[row, corner], normal[row, corner]
                _toward(point, place, kind == POINT, light)
                _toward(point, viewer, near, view)
                to_light, to_view = _dot(light, turn), _dot(view, turn)
                _cross(light, view, cross)
                h1 = _dot(cross, turn)
                h2 = to_view * abs(to_view) * _dot(light, light) - to_light * abs(to_light) * _dot(view, view)
                low1, high1 = min(low1, h1), max(high1, h1)
                low2, high2 = min(low2, h2), max(high2, h2)
                lit, seen = lit or to_light > 0, seen or to_view > 0
            out[index, row] = low1 <= 0 <= high1 and low2 <= 0 <= high2 and lit and seen
    return out


@njit(cache=True)
def _mix(corners: Floats, barycentric: Floats, out: Floats) -> None:
    """What three corners carry at barycentric coordinates."""
    for axis in range(3):
        out[axis] = (
            barycentric[0] * corners[0, axis]
            + barycentric[1] * corners[1, axis]
            + barycentric[2] * corners[2, axis]
        )


@njit(cache=True, error_model="numpy")
def _root(a: float, b: float, c: float) -> float:
    """A root in 0 .. 1 of a t^2 + b t + c, NaN where there is none; the nearer to the middle of two."""
    # The form of the solution that does not cancel; the other root is c / (a root).
    q = -0.5 * (b + (-1 if b < 0 else 1) * np.sqrt(b * b - 4 * a * c))
    best = np.nan
    for root in (q / a, c / q):
        if 0 <= root <= 1 and not abs(best - 0.5) <= abs(root - 0.5):
            best = root
    return best


@njit(cache=True, error_model="numpy")
def _between(
    one: Floats,
    other: Floats,
    position: Floats,
    normal: Floats,
    viewer: Floats,
    near: bool,
    light: Floats,
    work: Floats,
) -> float:
    """
    Where condition H1 holds between two points of a triangle: the appendix's quadratic, solved directly.

    0 at the first, 1 at the second; NaN where H1 does not hold in between. ``work`` (10, 3) is written to.
    """
    start, end, first, last, light_start, light_step, view_start, view_step, change, cross = work
    _mix(position, one, start)
    _mix(position, other, end)
    _mix(normal, one, first)
    _mix(normal, other, last)
    _toward(start, light[1:], light[0] == POINT, light_start)
    _toward(start, viewer, near, view_start)
    for axis in range(3):
        step = start[axis] - end[axis]
        light_step[axis] = step if light[0] == POINT else 0
        view_step[axis] = step if near else 0
        last[axis] -= first[axis]
    # L x V is quadratic in t, but both vectors change by the same step (or not at all): t^2 vanishes.
    _cross(light_step, view_start, change)
    _cross(light_start, view_step, cross)
    for axis in range(3):
        change[axis] += cross[axis]
    _cross(light_start, view_start, cross)
    return _root(_dot(change, last), _dot(change, first) + _dot(cross, last), _dot(cross, first))


@njit(cache=True, error_model="numpy")
def _nearer(
    barycentric: Floats,
    position: Floats,
    normal: Floats,
    viewer: Floats,
    near: bool,
    light: Floats,
    work: Floats,
) -> float:
    """V . N - L . N of unit vectors: positive where N is nearer to V."""
    point, turn, to_light, to_view = work[0], work[1], work[2], work[3]
    _mix(position, barycentric, point)
    _mix(normal, barycentric, turn)
    _toward(point, light[1:], light[0] == POINT, to_light)
    _toward(point, viewer, near, to_view)
    length = np.sqrt(_dot(turn, turn))
    seen = _dot(to_view, turn) / np.sqrt(_dot(to_view, to_view))
    return (seen - _dot(to_light, turn) / np.sqrt(_dot(to_light, to_light))) / length


@njit(cache=True, error_model="numpy")
def _share(start: float, end: float) -> float:
    """Where H2 holds between two points if its cosines vary linearly (end of the appendix)."""
    share = start / (start - end)
    return min(max(share, 0.0), 1.0) if np.isfinite(share) else 0.5


@njit(cache=True, error_model="numpy")
def centres(
    position: Floats,
    normal: Floats,
    triangle: Ints,
    viewer: Floats,
    near: bool,
    light: Floats,
    repeats: int,
) -> tuple[Floats, Bools]:
    """
    (k, 3) centres of highlights and (k,) whether H2 changes its sign between the two points of H1.

    As :func:`quadshade.adapt.highlight.highlight_centres`.
    """
    out, sure = np.empty((len(triangle), 3)), np.empty(len(triangle), np.bool_)
    work, corner, crossing = np.empty((10, 3)), np.eye(3), np.empty(3)
    for index in range(len(triangle)):
        place, turn = position[triangle[index]], normal[triangle[index]]
        found = 0
        # The edge without a crossing is left out; where all three have one (at a vertex), the last.
        missing = 2
        for edge in range(2, -1, -1):
            crossing[edge] = _between(
                corner[edge], corner[(edge + 1) % 3], place, turn, viewer, near, light, work
            )
            if np.isnan(crossing[edge]):
                missing = edge
            else:
                found += 1
        one, two = (missing + 1) % 3, (missing + 2) % 3
        q = corner[one] * (1 - crossing[one]) + corner[(one + 1) % 3] * crossing[one]
        r = corner[two] * (1 - crossing[two]) + corner[(two + 1) % 3] * crossing[two]
        apex = corner[(one + 1) % 3]
        at_q = _nearer(q, place, turn, viewer, near, light, work)
        at_r = _nearer(r, place, turn, viewer, near, light, work)
        inside = at_q * at_r <= 0
        centre = q + _share(at_q, at_r) * (r - q)
        for _ in range(repeats if inside else 0):
            # From the vertex through P to the opposite edge, where H1 has to hold again.
            weight = _dot(apex, centre)
            far = (centre - weight * apex) / (1 - weight)
            share = _between(apex, far, place, turn, viewer, near, light, work)
            better = centre if np.isnan(share) else apex + share * (far - apex)
            at_better = _nearer(better, place, turn, viewer, near, light, work)
            if at_q * at_better > 0:
                q, at_q = better, at_better
            else:
                r, at_r = better, at_better
            centre = q + _share(at_q, at_r) * (r - q)
        out[index], sure[index] = centre, inside and found >= 2
    return out, sure
