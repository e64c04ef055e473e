# SPDX-License-Identifier: Apache-2.0
"""All cases of mesh files, and what is drawn of one."""

from __future__ import annotations

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.image import paint, visible
from quadshade.scene import Mesh, parse_camera, project
from quadshade.shading import AmbientLight, Material, sample
from tests.support.mesh_cases import Case, Colour
from tests.support.mesh_cases_gltf import FILES, GLTF
from tests.support.mesh_cases_text import GIVEN_FILES, OBJ, OFF, PLY, STL

LISTED = (*GIVEN_FILES, *OBJ, *PLY, *OFF, *STL, *GLTF, *FILES)
CASES = {case.name: case for case in LISTED}
assert len(CASES) == len(LISTED), "two cases have one name"
SIZE = 64


def lit_pixels(mesh: Mesh, case: Case) -> dict[Colour, int]:
    """Pixels by colour that are not black, in ambient light alone."""
    projected = project(mesh, parse_camera(case.camera, mesh), SIZE, SIZE)
    ones, zeros = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
    red, green, blue = (level / 255 for level in case.given)
    material = Material((red, green, blue), diffuse=zeros, ambient=ones, specular=zeros)
    pixels = draw(sample(projected, "quadratic", (AmbientLight(ones),), material), Formats()).pixels
    picture = paint(visible(pixels, SIZE, SIZE), pixels.value, (0, 0, 0)).reshape(-1, 3)
    colours, counts = np.unique(picture[picture.any(axis=1)], axis=0, return_counts=True)
    return {(c[0], c[1], c[2]): int(n) for c, n in zip(colours.tolist(), counts, strict=True)}
