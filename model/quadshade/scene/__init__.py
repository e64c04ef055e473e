# SPDX-License-Identifier: Apache-2.0
"""Meshes, camera and clipping: from a file or a generator to triangles on the screen."""

from quadshade.scene.camera import Camera, fit_camera, parse_camera
from quadshade.scene.detail import level_of_detail
from quadshade.scene.files import load_scene
from quadshade.scene.mesh import Mesh, build_mesh
from quadshade.scene.project import Projected, project

__all__ = [
    "Camera",
    "Mesh",
    "Projected",
    "build_mesh",
    "fit_camera",
    "level_of_detail",
    "load_scene",
    "parse_camera",
    "project",
]
