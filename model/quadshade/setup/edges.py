# SPDX-License-Identifier: Apache-2.0
"""
Exact edges: triangles cut at the screen's border into primitives of whole scanlines, a DDA for each side.

An edge from its own top vertex (xa, ya) to (xb, yb), in sub-pixels, S to a pixel, dx = xb - xa, dy = yb - ya,
meets scanline y at the column ``ceil(x(y + 1/2) - 1/2) = floor(m / dy)`` with

    m = floor((2 xa dy + (S (2y + 1) - 2 ya) dx + S dy - 1) / 2S),    one scanline down: m += dx.

The low bits dropped by the division by 2S never change, so the DDA is exact for every edge. Pixels
left <= x < right are covered: the top-left rule, and an edge shared by two triangles has the same columns in
both.

Widths: a vertex lies in [-2**25, 2**26) at most (13 + 12 bits, three screens), so dx, dy < 2**26.6, every
product above is below 2**54.3 and their sum below 2**55.5: int64 holds all of it, with seven bits to spare.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

# Columns of Cut.heads.
TRIANGLE, FIRST_Y, ROWS_FIRST, ROWS_SECOND, MIRROR, MAJOR_TOP, MAJOR_BOTTOM, HEAD_FIELDS = range(8)
# Columns of an edge in Cut.edges: floor(m / dy), m mod dy, dx div dy, dx mod dy, dy.
COLUMN, REMAINDER, STEP, INCREMENT, HEIGHT, STATE_FIELDS = range(6)
# Columns of a side's runs: the scanlines [START, END), m at START, dx, dy, the edge's two vertices (-1: the
# border).
_START, _END, _M, _DX, _DY, _TOP, _BOTTOM, RUN_FIELDS = range(8)

MAX_RUNS = 6
"""A side is at most two edges, each at most border, edge, border."""
MAX_PRIMITIVES = 2 * MAX_RUNS
"""Each primitive but the last uses up at least one run of a side."""


@dataclass
class Cut:
    """
    Primitives before colour: what covers which pixels.

    Attributes
    ----------
    heads : (n, 7) int64
      Triangle, first scanline, scanlines along the first and the second minor edge, mirror, and the two
      vertices of the triangle's edge that is the major edge (-1: it is the border of the screen).
    edges : (n, 3, 5) int64
      Major, minor, second: column, remainder, step, increment, height, in u (mirrored: u = -1 - x).
    """

    heads: np.ndarray
    edges: np.ndarray


@njit(cache=True)
def _first_scanline(y, bits):
    """First scanline whose centre is at or below y: ceil(y / S - 1/2), S = 2**bits."""
    return -(((1 << bits) - 2 * y) >> (bits + 1))


@njit(cache=True)
def _line(corners, top, bottom, y, bits):
    """The edge between two vertices from scanline y on: m there, dx, dy, y."""
    xa, ya = corners[top, 0], corners[top, 1]
    dx, dy = corners[bottom, 0] - xa, corners[bottom, 1] - ya
    # Relative to the edge's own top vertex, everything fits; the shift floors.
    down = ((2 * y + 1) << bits) - 2 * ya
    return (2 * xa * dy + down * dx + (dy << bits) - 1) >> (bits + 1), dx, dy, y


@njit(cache=True)
def _line_column(line, y):
    """Column of a line from :func:`_line` at scanline y."""
    m, dx, dy, since = line
    return (m + (y - since) * dx) // dy


@njit(cache=True)
def _between(long, broken, area, y):
    """Whether scanline y has a pixel between a triangle's long edge and one of the other two."""
    if area > 0:
        return _line_column(long, y) < _line_column(broken, y)
    return _line_column(broken, y) < _line_column(long, y)


@njit(cache=True)
def _clamp(value, low, high):
    return min(max(value, low), high)


@njit(cache=True)
def _push(runs, count, start, end, m, dx, dy, top, bottom):
    """Append a run to a side; an empty one is dropped, a border that goes on is extended."""
    if start >= end:
        return count
    if count and top < 0 and runs[count - 1, _TOP] < 0 and runs[count - 1, _M] == m:
        runs[count - 1, _END] = end
        return count
    run = runs[count]
    run[_START], run[_END], run[_M], run[_DX], run[_DY] = start, end, m, dx, dy
    run[_TOP], run[_BOTTOM] = top, bottom
    return count + 1


@njit(cache=True)
def _push_edge(runs, count, start, end, corners, top, bottom, bits, width):
    """
    Append an edge over scanlines [start, end), replaced by the border where its column leaves 0 .. width.
    """
    if start >= end:
        return count
    m, dx, dy, _ = _line(corners, top, bottom, start, bits)
    limit = (width + 1) * dy
    rows = end - start
    before, after = 0, width
    if dx > 0:
        enter = _clamp(-(m // dx), 0, rows)
        leave = _clamp(-((m - limit) // dx), 0, rows)
    elif dx < 0:
        before, after = width, 0
        enter = _clamp((m - limit) // -dx + 1, 0, rows)
        leave = _clamp(m // -dx + 1, 0, rows)
    else:
        enter = rows if m < 0 else 0
        leave = 0 if m >= limit else rows
    count = _push(runs, count, start, start + enter, before, 0, 1, -1, -1)
    count = _push(runs, count, start + enter, start + leave, m + enter * dx, dx, dy, top, bottom)
    return _push(runs, count, max(start + leave, start + enter), end, after, 0, 1, -1, -1)


@njit(cache=True)
def _run_line(run):
    return run[_M], run[_DX], run[_DY], run[_START]


@njit(cache=True)
def _column(run, y):
    return _line_column(_run_line(run), y)


@njit(cache=True)
def _run_at(runs, y):
    index = 0
    while runs[index, _END] <= y:
        index += 1
    return index


@njit(cache=True)
def _next_covered(left, right, y, end, width):
    """First scanline from y on that has a pixel, or end."""
    while y < end:
        a, b = left[_run_at(left, y)], right[_run_at(right, y)]
        if _column(a, y) < _column(b, y):
            return y
        # Whole runs beyond the border are skipped, so that a tall triangle beside the screen costs nothing.
        if a[_TOP] < 0 and a[_M] == width:
            y = a[_END]
        elif b[_TOP] < 0 and b[_M] == 0:
            y = b[_END]
        else:
            y += 1
    return end


@njit(cache=True)
def _last_covered(left, right, first, y, width):
    """Last scanline from y upwards that has a pixel, or first - 1."""
    while y >= first:
        a, b = left[_run_at(left, y)], right[_run_at(right, y)]
        if _column(a, y) < _column(b, y):
            return y
        if a[_TOP] < 0 and a[_M] == width:
            y = a[_START] - 1
        elif b[_TOP] < 0 and b[_M] == 0:
            y = b[_START] - 1
        else:
            y -= 1
    return first - 1


@njit(cache=True)
def _set_state(state, line, y, rows, mirror):
    """The DDA of a line from scanline y on, in u. Mirrored: -floor(m / dy) = floor((dy - 1 - m) / dy)."""
    m, dx, dy, since = line
    m += (y - since) * dx
    if mirror:
        m, dx = dy - 1 - m, -dx
    column = m // dy
    if dx == 0 or rows == 1:
        state[COLUMN], state[REMAINDER], state[STEP], state[INCREMENT], state[HEIGHT] = column, 0, 0, 0, 1
        return
    step = dx // dy
    state[COLUMN], state[REMAINDER] = column, m - column * dy
    state[STEP], state[INCREMENT], state[HEIGHT] = step, dx - step * dy, dy


@njit(cache=True)
def _sorted(corners):
    """Indices of the top, middle and bottom vertex; where the middle one is: > 0 right of the long edge."""
    top, middle, bottom = 0, 1, 2
    if corners[top, 1] > corners[middle, 1]:
        top, middle = middle, top
    if corners[middle, 1] > corners[bottom, 1]:
        middle, bottom = bottom, middle
    if corners[top, 1] > corners[middle, 1]:
        top, middle = middle, top
    area = (corners[middle, 0] - corners[top, 0]) * (corners[bottom, 1] - corners[top, 1]) - (
        corners[bottom, 0] - corners[top, 0]
    ) * (corners[middle, 1] - corners[top, 1])
    return top, middle, bottom, area


@njit(cache=True)
def _sides(corners, bits, width, height, left, right):
    """Runs of both sides and the scanlines [first, end) of a triangle on the screen (empty: first >= end)."""
    top, middle, bottom, area = _sorted(corners)
    first = max(_first_scanline(corners[top, 1], bits), 0)
    end = min(_first_scanline(corners[bottom, 1], bits), height)
    if first >= end or area == 0:
        return 0, 0, 0, 0
    knee = _clamp(_first_scanline(corners[middle, 1], bits), first, end)
    long, broken = (left, right) if area > 0 else (right, left)
    long_count = _push_edge(long, 0, first, end, corners, top, bottom, bits, width)
    broken_count = _push_edge(broken, 0, first, knee, corners, top, middle, bits, width)
    broken_count = _push_edge(broken, broken_count, knee, end, corners, middle, bottom, bits, width)
    if area > 0:
        return first, end, long_count, broken_count
    return first, end, broken_count, long_count


@njit(cache=True)
def _inside(corners, right, bottom):
    """Whether a triangle lies on the screen, its border included."""
    for corner in range(3):
        if not (0 <= corners[corner, 0] <= right and 0 <= corners[corner, 1] <= bottom):
            return False
    return True


@njit(cache=True)
def _cut_inside(index, corners, bits, heads, edges, count):
    """
    Append the one primitive of a triangle that lies on the screen, if it has a pixel.

    The same as :func:`cut_one`, where no side meets the border: the long edge is the major one if the other
    side's knee lies between its scanlines, else the left one.
    """
    top, middle, bottom, area = _sorted(corners)
    y, end = _first_scanline(corners[top, 1], bits), _first_scanline(corners[bottom, 1], bits)
    if y >= end or area == 0:
        return count
    knee = _first_scanline(corners[middle, 1], bits)
    long = _line(corners, top, bottom, y, bits)
    upper = _line(corners, top, middle, y, bits) if y < knee else long
    lower = _line(corners, middle, bottom, knee, bits) if knee < end else long
    while y < end and not _between(long, upper if y < knee else lower, area, y):
        y += 1
    if y >= end:
        return count
    while not _between(long, upper if end <= knee else lower, area, end - 1):
        end -= 1
    split = y < knee < end
    mirror = split and area < 0
    minor = upper if y < knee else lower
    major_top, major_bottom = top, bottom
    if split or area > 0:
        major = long
    else:
        major, minor = minor, long
        major_top, major_bottom = (top, middle) if y < knee else (middle, bottom)
    rows_first = knee - y if split else end - y
    head = heads[count]
    head[TRIANGLE], head[FIRST_Y], head[MIRROR] = index, y, mirror
    head[ROWS_FIRST], head[ROWS_SECOND] = rows_first, end - y - rows_first
    head[MAJOR_TOP], head[MAJOR_BOTTOM] = major_top, major_bottom
    _set_state(edges[count, 0], major, y, end - y, mirror)
    _set_state(edges[count, 1], minor, y, rows_first, mirror)
    if split:
        _set_state(edges[count, 2], lower, knee, end - knee, mirror)
    else:
        edges[count, 2] = 0
    return count + 1


@njit(cache=True)
def cut_one(index, corners, bits, width, height, left, right, heads, edges, count):
    """Append the primitives of one triangle; the longest possible one first, which gives the least number."""
    first, end, left_count, right_count = _sides(corners, bits, width, height, left, right)
    y = _next_covered(left, right, first, end, width)
    if y >= end:
        return count
    end = _last_covered(left, right, y, end - 1, width) + 1
    while y < end:
        i, j = _run_at(left, y), _run_at(right, y)
        left_end, right_end = left[i, _END], right[j, _END]
        left_next = left[i + 1, _END] if i + 1 < left_count else left_end
        right_next = right[j + 1, _END] if j + 1 < right_count else right_end
        left_reach = min(left_end, right_next, end)
        right_reach = min(right_end, left_next, end)
        mirror = right_reach > left_reach
        reach = max(left_reach, right_reach)
        stop = _last_covered(left, right, y, reach - 1, width) + 1
        major, minor, k = (right[j], left, i) if mirror else (left[i], right, j)
        rows_first = min(minor[k, _END], stop) - y
        head = heads[count]
        head[TRIANGLE], head[FIRST_Y], head[MIRROR] = index, y, mirror
        head[ROWS_FIRST], head[ROWS_SECOND] = rows_first, stop - y - rows_first
        head[MAJOR_TOP], head[MAJOR_BOTTOM] = major[_TOP], major[_BOTTOM]
        _set_state(edges[count, 0], _run_line(major), y, stop - y, mirror)
        _set_state(edges[count, 1], _run_line(minor[k]), y, rows_first, mirror)
        if stop - y > rows_first:
            _set_state(
                edges[count, 2], _run_line(minor[k + 1]), y + rows_first, stop - y - rows_first, mirror
            )
        else:
            edges[count, 2] = 0
        count += 1
        y = _next_covered(left, right, reach, end, width)
    return count


@njit(cache=True)
def _cut(vertices, start, bits, width, height, heads, edges):
    """Cut triangles from start on until the tables are full; returns the next triangle, the rows written."""
    left = np.zeros((MAX_RUNS, RUN_FIELDS), np.int64)
    right = np.zeros((MAX_RUNS, RUN_FIELDS), np.int64)
    count = 0
    for index in range(start, len(vertices)):
        if count + MAX_PRIMITIVES > len(heads):
            return index, count
        corners = vertices[index]
        if _inside(corners, width << bits, height << bits):
            count = _cut_inside(index, corners, bits, heads, edges, count)
        else:
            count = cut_one(index, corners, bits, width, height, left, right, heads, edges, count)
    return len(vertices), count


def cut_triangles(vertices: np.ndarray, width: int, height: int, subpixel_bits: int) -> Cut:
    """
    Cut triangles into primitives that lie on the screen, and set up their edges.

    Rows above and below the screen are left out; where a side lies beyond the left or right border, the
    border takes its place. A primitive is one run of its major side and at most two of its minor side, and
    the major side is chosen for the fewest primitives. Its first and last scanlines hold pixels; there are no
    primitives without pixels.

    Parameters
    ----------
    vertices : (n, 3, 2) int64
      x and y in sub-pixels, inside ``Formats.guard_band``.
    width, height : int
      Screen size in pixels.
    subpixel_bits : int

    Returns
    -------
    Cut
      In triangle order, top to bottom within a triangle.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.int64)
    parts, start = [], 0
    while start < len(vertices) or not parts:
        size = (len(vertices) - start) * 5 // 4 + MAX_PRIMITIVES
        heads = np.empty((size, HEAD_FIELDS), np.int64)
        edges = np.empty((size, 3, STATE_FIELDS), np.int64)
        start, count = _cut(vertices, start, subpixel_bits, width, height, heads, edges)
        parts.append((heads[:count], edges[:count]))
    heads, edges = (
        np.concatenate(column) if len(parts) > 1 else column[0] for column in zip(*parts, strict=True)
    )
    return Cut(heads, edges)
