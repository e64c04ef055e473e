# SPDX-License-Identifier: Apache-2.0
"""From the scene to the screen: viewport, clipping, rounding to sub-pixels, culling and depth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.scene.camera import Camera
from quadshade.scene.clip import clip_triangles
from quadshade.scene.depth_range import NEAREST, depth_notes, fitted_near
from quadshade.scene.mesh import Mesh
from quadshade.scene.projection_loops import (
    COORDINATES,
    DISTANCE,
    DIVISOR,
    Corners,
    ViewDepth,
    fill_corners,
    place_vertices,
    rounded_vertices,
    seen_faces,
    vertex_sides,
)

FARTHEST = 1e14
"""Of a triangle that is cut, to the target's distance: float64 has 16 digits, and a pixel takes three."""


@dataclass(frozen=True)
class Projected:
    """
    Visible triangles on the screen, with what shading needs of the scene.

    Attributes
    ----------
    width, height : int
      Pixels.
    vertices : (n, 3, 2) int64
      Sub-pixels, y down, rounded to nearest, ties to even.
    depth : (n, 3) float64
      0 (near) .. 2**depth_bits - 1 (far), linear on the screen.
    position, normal : (n, 3, 3) float64
      In the scene; normals are not unit length where a triangle was clipped, and face the viewer's side of
      triangles that are seen from behind.
    colour : (n, 3, 3) float64 or None
      The mesh's own corner colours.
    weight : (n, 3) float64
      Attribute * weight is linear on the screen: 1 / distance in perspective, else 1.
    source : (n,) int64
      The mesh's face.
    eye : (3,) float64 or None
      Viewer's position; None for an orthographic view.
    axes : (3, 3) float64
      The viewer's right, up and backward.
    notes : tuple of str
      What the picture may lack, a sentence each.
    """

    width: int
    height: int
    vertices: np.ndarray
    depth: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    colour: np.ndarray | None
    weight: np.ndarray
    source: np.ndarray
    eye: np.ndarray | None
    axes: np.ndarray
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.vertices)

    def ordered(self, order: np.ndarray) -> Projected:
        """The same triangles in another order, or a part of them: (m,) int indices or (n,) bool."""
        return replace(
            self,
            vertices=self.vertices[order],
            depth=self.depth[order],
            position=self.position[order],
            normal=self.normal[order],
            colour=None if self.colour is None else self.colour[order],
            weight=self.weight[order],
            source=self.source[order],
        )

    def back_to_front(self) -> Projected:
        """The same triangles, farthest centre first: painter's order for a core without depth."""
        return self.ordered(np.argsort(-self.depth.sum(axis=1), kind="stable"))


def check_size(width: int, height: int, formats: Formats) -> None:
    """Raise :class:`QuadshadeError` for a screen that the core cannot address."""
    limit = 1 << formats.coord_bits
    if not (1 <= width <= limit and 1 <= height <= limit):
        raise QuadshadeError(
            f"the size is {width}x{height}", f"give 1x1 to {limit}x{limit} (generic coord_bits)"
        )


def project(
    mesh: Mesh, camera: Camera, width: int, height: int, formats: Formats | None = None, cull: bool = True
) -> Projected:
    """
    The mesh as the camera sees it.

    Parameters
    ----------
    mesh : Mesh
    camera : Camera
    width, height : int
      Pixels, 1 .. 2**coord_bits.
    formats : Formats, optional
      Sub-pixel bits, depth bits and the guard band; by default the core's defaults.
    cull : bool
      Drop triangles seen from behind (clockwise on the screen), but for those that the mesh calls
      double-sided. Kept, they are lit from the viewer's side.

    Returns
    -------
    Projected
      In the order of the mesh's faces. What is wholly off the screen or has no area is left out.

    Raises
    ------
    QuadshadeError
      A size out of range, or a triangle to be cut that reaches ``FARTHEST`` times as far as the target.
    """
    formats = Formats() if formats is None else formats
    check_size(width, height, formats)
    view = _View(camera, width, height)
    coordinates = place_vertices(mesh.vertices, view.eye, view.rows, view.perspective)
    culled = _culled(mesh, cull)
    near, far = _depth_range(camera, view, mesh, coordinates, culled, (width, height))
    scale = 2.0**formats.subpixel_bits
    # One sub-pixel inside the guard band, so that rounding cannot leave it.
    band = (np.array(formats.guard_band) + (1, -1)) / scale
    cutters = view.planes(np.stack([band, band], axis=1), near)
    sides = vertex_sides(coordinates, view.planes(np.array([[0, 0], [width, height]]), near), cutters)
    vertices = rounded_vertices(coordinates, sides, view.middle, scale, *formats.guard_band)
    # Most triangles need no clipping and many are culled: nothing is gathered for those.
    source, crossing = seen_faces(mesh.faces, sides, vertices, culled)
    full = 2.0**formats.depth_bits - 1
    view_depth = ViewDepth(near, far, view.perspective, full)
    corners, colours = _gather(
        source, mesh.faces, vertices, coordinates, view_depth, mesh.vertices, mesh.normals, mesh.colours
    )
    if len(crossing):
        _check_reach(mesh.vertices[mesh.faces[crossing]], camera)
        pieces, cut_from = clip_triangles(_attributes(mesh, coordinates, crossing), cutters)
        if view.perspective:
            pieces[..., DISTANCE] = pieces[..., DIVISOR]
        # The pieces are a mesh of their own, in which every corner is a vertex.
        flat = pieces.reshape(-1, pieces.shape[2])
        faces = np.arange(len(flat)).reshape(-1, 3)
        sides = np.zeros(len(flat), np.uint16)
        vertices = rounded_vertices(flat, sides, view.middle, scale, *formats.guard_band)
        kept, _ = seen_faces(faces, sides, vertices, culled[crossing[cut_from]])
        flat_colours = None if mesh.colours is None else pieces[..., 10:13]
        more, more_colours = _gather(
            kept, faces, vertices, flat, view_depth, flat[:, 4:7], pieces[..., 7:10], flat_colours
        )
        source = np.concatenate([source, crossing[cut_from[kept]]])
        order = np.argsort(source, kind="stable")
        source = source[order]
        corners = Corners(*(np.concatenate(arrays)[order] for arrays in zip(corners, more, strict=True)))
        if colours is not None and more_colours is not None:
            colours = np.concatenate([colours, more_colours])[order]
    eye = view.eye if view.perspective else None
    notes = depth_notes(near, far, formats) if view.perspective else ()
    vertices, depth, position, normal, weight = corners
    return Projected(
        width, height, vertices, depth, position, normal, colours, weight, source, eye, camera.axes, notes
    )


def doubled_area(vertices: np.ndarray) -> np.ndarray:
    """(n,) int64 doubled areas of (n, 3, 2) integer triangles; positive where they turn clockwise, y down."""
    first, second = vertices[:, 1] - vertices[:, 0], vertices[:, 2] - vertices[:, 0]
    return first[:, 0] * second[:, 1] - second[:, 0] * first[:, 1]


class _View:
    """Camera and viewport: the affine map from the scene to (x w, y w, w, distance) in pixels."""

    def __init__(self, camera: Camera, width: int, height: int) -> None:
        right, up, back = camera.axes
        self.perspective = camera.ortho is None
        half = min(width, height) / 2
        if camera.ortho is not None:
            scale = half / camera.ortho
        elif camera.fov is not None:
            scale = half / np.tan(np.radians(camera.fov / 2))
        else:
            raise QuadshadeError("the camera has neither fov nor ortho", "give one of them")
        self.scale = float(scale)
        self.middle = np.array([width, height]) / 2
        self.rows = np.stack([scale * right, -scale * up, np.zeros(3), -back])
        self.eye = np.asarray(camera.eye, dtype=np.float64)

    def planes(self, bounds: np.ndarray, near: float) -> np.ndarray:
        """(5, 5) planes over the coordinates: near, then the sides of bounds (2, 2), low and high x, y."""
        planes = np.zeros((5, 5))
        # In perspective, w is the distance, and the other planes ask for w.
        planes[0, [DIVISOR if self.perspective else DISTANCE, COORDINATES]] = 1, -near
        for axis in range(2):
            low, high = bounds[:, axis] - self.middle[axis]
            planes[1 + 2 * axis, [axis, 2]] = 1, -low
            planes[2 + 2 * axis, [axis, 2]] = -1, high
        return planes


def _culled(mesh: Mesh, cull: bool) -> np.ndarray:
    """(n,) bool: faces that are dropped where they are seen from behind."""
    if mesh.double_sided is None or not cull:
        return np.full(len(mesh), cull)
    return ~mesh.double_sided


def _depth_range(
    camera: Camera,
    view: _View,
    mesh: Mesh,
    coordinates: np.ndarray,
    culled: np.ndarray,
    size: tuple[int, int],
) -> tuple[float, float]:
    """Near and far distance: the camera's near, or what the part of the scene that it shows needs."""
    distance = coordinates[mesh.used, DISTANCE]
    far = float(distance.max())
    if camera.near is not None:
        return camera.near, far
    nearest = float(distance.min())
    if not view.perspective:
        return nearest, far
    if nearest >= NEAREST * far:
        return max(nearest, 1e-30), far
    pyramid = view.planes(np.array([(0, 0), size]), 0.0)
    return fitted_near(coordinates[mesh.faces], culled, pyramid, view.scale, far), far


def _check_reach(corners: np.ndarray, camera: Camera) -> None:
    """Refuse triangles that reach so far that rounding hides where they pass the viewer."""
    reach = float(np.abs(corners - camera.eye).max())
    distance = float(np.linalg.norm(np.subtract(camera.target, camera.eye)))
    if reach > FARTHEST * distance:
        raise QuadshadeError(
            f"a triangle reaches {reach:.3g} units away, the camera's target is {distance:.3g} away:"
            " it cannot be cut at the screen's border",
            "divide the triangle, or scale the mesh down",
        )


def _attributes(mesh: Mesh, coordinates: np.ndarray, source: np.ndarray) -> np.ndarray:
    """(n, 3, 10 or 13) float64: coordinates, position, normal and, where the mesh has any, colour."""
    faces = mesh.faces[source]
    parts = [coordinates[faces], mesh.vertices[faces], mesh.normals[source]]
    return np.concatenate(parts if mesh.colours is None else [*parts, mesh.colours[source]], axis=-1)


def _gather(
    chosen: np.ndarray,
    faces: np.ndarray,
    vertices: np.ndarray,
    coordinates: np.ndarray,
    view_depth: ViewDepth,
    position: np.ndarray,
    normal: np.ndarray,
    colour: np.ndarray | None,
) -> tuple[Corners, np.ndarray | None]:
    """What (k,) chosen faces have at their corners, and their colours."""
    count = len(chosen)
    out = Corners(
        np.empty((count, 3, 2), np.int64),
        np.empty((count, 3)),
        np.empty((count, 3, 3)),
        np.empty((count, 3, 3)),
        np.empty((count, 3)),
    )
    fill_corners(chosen, faces, vertices, coordinates, view_depth, position, normal, out)
    return out, None if colour is None else colour[chosen]
