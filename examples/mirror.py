# SPDX-License-Identifier: Apache-2.0
"""
A statue on a mirror, hatched and with its edges, after Nienhaus and Döllner, *Edge-Enhancement*, figure 8.

Two renders and a mask: the scene as it is, the scene mirrored at the floor, and where the floor is seen. The
edges of each render are found from its own viewpoint, so those in the mirror are right in perspective.

    python mirror.py knot.glb mirror.png
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import quadshade
from quadshade.image import write_png
from quadshade.scene import Camera, Mesh, build_mesh

SIZE = (400, 400)
PAPER, GLASS = 255, np.array([214, 222, 230])
DIMMED = 0.45
"""How much of a mirrored pixel's ink is lost in the glass."""


def mirrored(mesh: Mesh, floor: float) -> Mesh:
    """The mesh mirrored at the plane y = floor; its faces keep their outer side."""
    vertices = mesh.vertices * (1, -1, 1) + (0, 2 * floor, 0)
    colours = None if mesh.colours is None else mesh.colours[:, ::-1]
    normals = mesh.normals[:, ::-1] * (1, -1, 1)
    return replace(mesh, vertices=vertices, faces=mesh.faces[:, ::-1], normals=normals, colours=colours)


def glass(centre: np.ndarray, half: float, floor: float) -> Mesh:
    """A square mirror that lies at y = floor."""
    corners = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]) * half
    return build_mesh(corners + (centre[0], floor, centre[2]), np.array([[0, 1, 2], [0, 2, 3]]))


def draw(scene: str) -> np.ndarray:
    """
    The picture.

    Returns
    -------
    (h, w, 3) uint8
    """
    mesh = quadshade.load_scene(scene)
    centre, radius = mesh.bounds
    floor = float(mesh.vertices[mesh.used, 1].min())
    target = np.array([centre[0], floor + 0.2 * radius, centre[2]])
    eye = target + radius * np.array([1.6, 3.2, 6.4])
    camera = Camera(eye, target, np.array([0.0, 1.0, 0.0]), fov=27.0)
    hatched = {"camera": camera, "size": SIZE, "style": "hatch", "edges": "profile,inner", "engine": "model"}
    statue = quadshade.render(mesh, **hatched)
    image = quadshade.render(mirrored(mesh, floor), **hatched)
    plate = quadshade.render(glass(centre, 2.0 * radius, floor), camera=camera, size=SIZE, engine="model")
    # Only what lies on the mirror is masked: the statue stands in front of it.
    shown = plate.covered & ~statue.covered
    ink = np.where(image.covered[..., None], image.array, PAPER).astype(float)
    reflected = GLASS * (1 - (1 - DIMMED) * (1 - ink / PAPER))
    behind = np.where(shown[..., None], reflected, PAPER)
    # An edge of the statue lies half beside it: it darkens what is there.
    picture = np.where(statue.covered[..., None], statue.array, behind * (statue.array / PAPER))
    return np.rint(picture).astype(np.uint8)


if __name__ == "__main__":
    write_png(Path(sys.argv[2]), draw(sys.argv[1]))
