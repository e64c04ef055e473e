# SPDX-License-Identifier: Apache-2.0
"""A mesh that was turned, whose levels of detail are those of the mesh as it stood."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from quadshade.contract.arrays import Floats
from quadshade.scene.detail import level_of_detail
from quadshade.scene.mesh import Mesh


def turned(mesh: Mesh, by: Floats, centre: Floats) -> Mesh:
    """A mesh turned by a (3, 3) rotation about a point; the same object where it is not turned."""
    if (by == np.eye(3)).all():
        return mesh
    vertices = (mesh.vertices - centre) @ by.T + centre
    return replace(mesh, vertices=vertices, normals=mesh.normals @ by.T)


@dataclass
class Detail:
    """
    A scene in fewer triangles, the same ones however it is turned.

    Attributes
    ----------
    mesh : Mesh
      With all triangles, as it stands.
    scene : str or Path, optional
      Its name.
    crease : float, optional
    """

    mesh: Mesh
    scene: str | Path | None = None
    crease: float | None = None
    _levels: dict[int, Mesh] = field(default_factory=dict, repr=False)

    def level(self, count: int) -> Mesh:
        """The scene as it stands in at most so many triangles; as :func:`level_of_detail`."""
        if count not in self._levels:
            self._levels[count] = level_of_detail(self.mesh, count, self.scene, self.crease)
        return self._levels[count]


@dataclass(frozen=True)
class Turn:
    """How a scene stands: a (3, 3) rotation about a point, and the scene before it."""

    by: Floats
    centre: Floats
    detail: Detail

    @property
    def mesh(self) -> Mesh:
        """The scene with all triangles."""
        return turned(self.detail.mesh, self.by, self.centre)

    def level(self, count: int) -> Mesh:
        """The scene in at most so many triangles."""
        return turned(self.detail.level(count), self.by, self.centre)
