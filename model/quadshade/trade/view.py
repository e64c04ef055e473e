# SPDX-License-Identifier: Apache-2.0
"""What is looked at in a sweep, and the reference that every point is compared with."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.image import paint, visible
from quadshade.scene import Mesh, Projected, level_of_detail, load_scene, parse_camera, project
from quadshade.shading import AmbientLight, Light, Material, parse_light, parse_material, sample
from quadshade.shading.reference import phong
from quadshade.trade.grid import ALL
from quadshade.trade.subdivision import subdivide

BACKGROUND = (0, 0, 0)


@dataclass(frozen=True)
class View:
    """
    A scene, who looks at it and how it is lit; texts as for ``quadshade render``.

    Attributes
    ----------
    scene : str
    width, height : int
    camera, material : str
    lights : tuple of str
    exponent : float or None
    crease : float or None
    cull : bool
    """

    scene: str
    width: int = 512
    height: int = 512
    camera: str = ""
    lights: tuple[str, ...] = ()
    material: str = ""
    exponent: float | None = None
    crease: float | None = None
    cull: bool = True

    @cached_property
    def surface(self) -> Material:
        """The material."""
        return parse_material(self.material, self.exponent)

    @cached_property
    def lamps(self) -> tuple[Light, ...] | None:
        """The lights; None for those that go with the viewer."""
        return tuple(map(parse_light, self.lights)) or None

    @cached_property
    def mesh(self) -> Mesh:
        """The scene's mesh, all of it."""
        return load_scene(self.scene, self.crease)

    def projected(self, formats: Formats, lod: str = ALL) -> Projected:
        """
        The mesh on the screen, or a level of detail of it, from the same camera.

        Raises
        ------
        QuadshadeError
          A scene, camera or size that there is not.
        """
        mesh, camera = self.mesh, parse_camera(self.camera, self.mesh)
        if lod != ALL:
            mesh = level_of_detail(mesh, int(lod), self.scene, self.crease)
        return project(mesh, camera, self.width, self.height, formats, self.cull)

    @property
    def num_lights(self) -> int:
        """How many lights have a place or a direction, at least one."""
        # Of those that go with the viewer one has a direction.
        return max(sum(not isinstance(lamp, AmbientLight) for lamp in self.lamps or ()), 1)

    def settings(self) -> dict[str, Any]:
        """All of it, for a file."""
        return asdict(self)


@dataclass(frozen=True)
class Stage:
    """
    A subdivided mesh and its reference picture; what a worker needs beside the point.

    Attributes
    ----------
    projected : Projected
    mesh_triangles : int
      Triangles before division.
    lights : tuple of lights or None
    material : Material
    reference : (height, width, 3) uint8
      Phong shading of the same triangles, of a level of detail that of all, with coverage and depth of the
      core with all its bits.
    num_lights : int
      As of the view.
    is_level : bool
      The triangles are a level of detail.
    """

    projected: Projected
    mesh_triangles: int
    lights: tuple[Light, ...] | None
    material: Material
    reference: np.ndarray
    num_lights: int = 1
    is_level: bool = False


def stage(
    view: View, projected: Projected, subdivision: str, formats: Formats, whole: Projected | None = None
) -> Stage:
    """
    Divide a view's mesh and shade its reference.

    Parameters
    ----------
    view : View
    projected : Projected
      From ``view.projected``.
    subdivision : str
    formats : Formats
      Of the reference's coverage and depth: a core with all its bits.
    whole : Projected, optional
      All triangles, where ``projected`` is a level of detail of them.

    Returns
    -------
    Stage
    """
    parts = subdivide(projected, subdivision, view.lamps, view.surface, formats)
    seen = parts if whole is None else whole
    reference = phong_picture(seen, view.lamps, view.surface, formats)
    return Stage(
        parts, len(projected), view.lamps, view.surface, reference, view.num_lights, whole is not None
    )


def phong_picture(
    parts: Projected, lights: tuple[Light, ...] | None, material: Material, formats: Formats
) -> np.ndarray:
    """(height, width, 3) uint8 Phong shading of triangles, with the coverage and depth of the core."""
    pixels = draw(sample(parts, "flat", lights, material, formats), formats).pixels
    shown = visible(pixels, parts.width, parts.height)
    seen = shown[shown >= 0]
    value = np.zeros((len(pixels), 3))
    value[seen] = phong(
        parts, pixels.triangle[seen], pixels.x[seen], pixels.y[seen], lights, material, formats
    )
    return paint(shown, value, BACKGROUND, (1 << formats.value_bits) - 1)
