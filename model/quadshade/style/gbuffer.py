# SPDX-License-Identifier: Apache-2.0
"""
The G-buffer pass: the channels carry normals, depth is linear in the distance along the view.

Nienhaus and Döllner, *Edge-Enhancement*, 4.1: a first pass renders normals and depth, from whose
discontinuities the edge map comes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from quadshade.choices import GBUFFER_ORDERS, SPACES
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import Drawing, ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.image import visible
from quadshade.scene.project import Projected
from quadshade.shading.sample import SAMPLE_POINTS, surface

NORMAL_CHANNELS = ("nx", "ny", "nz")

FAR_SHARE = 0.75
"""The scene's farthest point, as a share of the largest depth: the background lies well behind it."""


@dataclass(frozen=True)
class GBuffer:
    """
    Normals and depth of a picture.

    Attributes
    ----------
    normal : (h, w, 3) uint8
      Component c of the unit normal as 255 (c + 1) / 2. Where nothing was drawn: towards the viewer.
    depth : (h, w) uint16
      0 (``near``) .. ``FAR_SHARE`` of full scale (``far``), linear in distance; full scale where nothing was.
    triangle : (h, w) int32
      Index of the projected triangle that is seen; -1 where nothing was drawn.
    depth_bits : int
    near, far : float
      Distances along the view, in scene units.
    space : str
      ``camera`` (x right, y up, z towards the viewer) or ``world``.
    depth_error : float
      Largest deviation of a drawn depth from the distance, in steps, of interpolating linearly on the screen;
      0 for an orthographic view. Taken at the edges' middles, where it is largest of each edge.
    """

    normal: np.ndarray
    depth: np.ndarray
    triangle: np.ndarray
    depth_bits: int
    near: float
    far: float
    space: str
    depth_error: float

    @property
    def covered(self) -> np.ndarray:
        """(h, w) bool: something was drawn."""
        return self.triangle >= 0

    @property
    def distance(self) -> np.ndarray:
        """(h, w) float64 distances along the view, in scene units; infinite where nothing was drawn."""
        share = self.depth / (FAR_SHARE * ((1 << self.depth_bits) - 1))
        return np.where(self.covered, self.near + share * (self.far - self.near), np.inf)

    def arrays(self) -> dict[str, np.ndarray]:
        """What ``--gbuffer`` writes, by name."""
        names = ("normal", "depth", "triangle", "depth_bits", "near", "far", "space", "depth_error")
        return {name: np.asarray(getattr(self, name)) for name in names}


def view_distance(projected: Projected) -> np.ndarray:
    """(n, 3) float64 distances of the corners along the view, from the eye or, without one, the origin."""
    if projected.eye is not None:
        return 1 / projected.weight
    return -projected.position @ projected.axes[2]


def distance_range(projected: Projected) -> tuple[float, float]:
    """Nearest and farthest corner along the view; (0, 1) of no triangles."""
    distance = view_distance(projected)
    return (float(distance.min()), float(distance.max())) if distance.size else (0.0, 1.0)


def with_view_depth(projected: Projected, formats: Formats) -> tuple[Projected, float]:
    """
    The same triangles with depth linear in the distance along the view.

    Parameters
    ----------
    projected : Projected
    formats : Formats

    Returns
    -------
    Projected
    float
      Largest deviation within an edge: see :class:`GBuffer`.
    """
    distance = view_distance(projected)
    near, far = distance_range(projected)
    full = FAR_SHARE * (2.0**formats.depth_bits - 1)
    scale = full / (far - near) if far > near else 0.0
    error = 0.0
    if projected.eye is not None and len(projected):
        pairs = projected.weight[:, [0, 0, 1]], projected.weight[:, [1, 2, 2]]
        straight = (1 / pairs[0] + 1 / pairs[1]) / 2
        error = float((straight - 2 / (pairs[0] + pairs[1])).max()) * scale
    return replace(projected, depth=(distance - near) * scale), error


def encoded(normal: np.ndarray) -> np.ndarray:
    """Components of unit normals, -1 .. 1, as 0 .. 255 (float64)."""
    return (np.clip(normal, -1, 1) + 1) * 127.5


def background_normal(axes: np.ndarray, space: str) -> np.ndarray:
    """(3,) uint8: the normal of what faces the viewer."""
    towards = np.array([0.0, 0.0, 1.0]) if space == "camera" else axes[2]
    return np.rint(encoded(towards)).astype(np.uint8)


def sample_normals(
    projected: Projected, order: str = "quadratic", space: str = "camera", formats: Formats | None = None
) -> ScreenTriangles:
    """
    Normals at the points that an order needs, as channels.

    Parameters
    ----------
    projected : Projected
      Its depth is taken as it is: see :func:`with_view_depth`.
    order : str
      ``linear`` (the vertices) or ``quadratic`` (vertices and middles of the edges).
    space : str
      Of ``SPACES``.
    formats : Formats, optional

    Returns
    -------
    ScreenTriangles
      Channels nx, ny, nz.

    Raises
    ------
    QuadshadeError
      An unknown order or space, or a core that cannot draw it.
    """
    formats = Formats() if formats is None else formats
    if order not in GBUFFER_ORDERS or space not in SPACES:
        raise QuadshadeError(
            f"a G-buffer of order {order!r} in {space!r} space",
            f"give {' or '.join(GBUFFER_ORDERS)}, and {' or '.join(SPACES)}",
        )
    check_gbuffer(formats, order)
    points = SAMPLE_POINTS[: 3 if order == "linear" else 6]
    _, normal, _, _ = surface(projected, np.arange(len(projected)), points)
    if space == "camera":
        normal = normal @ projected.axes.T
    samples = np.zeros((len(projected), len(NORMAL_CHANNELS), len(SAMPLE_POINTS)))
    samples[:, :, : len(points)] = encoded(normal).reshape(len(projected), len(points), 3).transpose(0, 2, 1)
    return ScreenTriangles(
        projected.width,
        projected.height,
        projected.vertices,
        samples,
        np.full((len(projected), len(NORMAL_CHANNELS)), GBUFFER_ORDERS[order], dtype=np.int64),
        projected.depth,
        NORMAL_CHANNELS,
    )


def check_gbuffer(formats: Formats, order: str) -> None:
    """Raise :class:`QuadshadeError` where a core cannot draw a G-buffer of an order."""
    wrong = (
        (
            formats.num_channels != 3 or formats.with_shade,
            "num_channels",
            "a G-buffer needs 3, without shade",
        ),
        (formats.value_bits != 8, "value_bits", "a G-buffer's normals have 8"),
        (not formats.with_depth, "with_depth", "a G-buffer needs depth"),
        (not 8 <= formats.depth_bits <= 16, "depth_bits", "a G-buffer needs 8 to 16"),
        (formats.max_order < GBUFFER_ORDERS[order], "max_order", f"{order} normals need more"),
    )
    for failed, name, what in wrong:
        if failed:
            raise QuadshadeError(f"generic {name} is {getattr(formats, name)}", what)


def draw_gbuffer(
    projected: Projected,
    formats: Formats | None = None,
    engine: str = "model",
    order: str = "quadratic",
    space: str = "camera",
    **setup: Any,
) -> tuple[GBuffer, Drawing]:
    """
    Draw a scene's normals and depth with an engine.

    Parameters
    ----------
    projected : Projected
    formats : Formats, optional
    engine : str
    order, space : str
      As for :func:`sample_normals`.
    **setup
      Further arguments of :func:`quadshade.engine.draw`.

    Returns
    -------
    GBuffer, Drawing

    Raises
    ------
    QuadshadeError
      What :func:`sample_normals` and :func:`quadshade.engine.draw` raise.
    """
    from quadshade.engine import draw

    formats = Formats() if formats is None else formats
    placed, error = with_view_depth(projected, formats)
    drawing = draw(sample_normals(placed, order, space, formats), formats, engine, **setup)
    pixels = drawing.pixels
    shown = visible(pixels, projected.width, projected.height)
    seen = shown >= 0
    normal = np.empty((*shown.shape, 3), np.uint8)
    normal[:] = background_normal(projected.axes, space)
    normal[seen] = pixels.value[shown[seen]]
    depth = np.full(shown.shape, (1 << formats.depth_bits) - 1, np.uint16)
    triangle = np.full(shown.shape, -1, np.int32)
    if pixels.depth is not None:
        depth[seen] = pixels.depth[shown[seen]]
    triangle[seen] = pixels.triangle[shown[seen]]
    near, far = distance_range(projected)
    return GBuffer(normal, depth, triangle, formats.depth_bits, near, far, space, error), drawing
