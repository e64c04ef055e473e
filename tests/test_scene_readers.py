# SPDX-License-Identifier: Apache-2.0
"""Every case of a mesh file shows what it says, or is refused with one line; so do damaged files."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.image import paint, visible
from quadshade.scene import Mesh, load_scene, parse_camera, project
from quadshade.shading import AmbientLight, Material, sample
from tests.support.mesh_cases import Case, Colour
from tests.support.mesh_cases_gltf import FILES, GLTF
from tests.support.mesh_cases_text import GIVEN_FILES, OBJ, OFF, PLY, STL

CASES = (*GIVEN_FILES, *OBJ, *PLY, *OFF, *STL, *GLTF, *FILES)
SIZE = 64


def lit_pixels(mesh: Mesh, case: Case, cull: bool = True) -> dict[Colour, int]:
    """Pixels by colour that are not black, in ambient light alone."""
    projected = project(mesh, parse_camera(case.camera, mesh), SIZE, SIZE, cull=cull)
    ones, zeros = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
    given = tuple(level / 255 for level in case.given)
    material = Material(given, diffuse=zeros, ambient=ones, specular=zeros)
    pixels = draw(sample(projected, "quadratic", (AmbientLight(ones),), material), Formats()).pixels
    picture = paint(visible(pixels, SIZE, SIZE), pixels.value, (0, 0, 0)).reshape(-1, 3)
    colours, counts = np.unique(picture[picture.any(axis=1)], axis=0, return_counts=True)
    return {tuple(c): int(n) for c, n in zip(colours.tolist(), counts, strict=True)}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_is_drawn_is_what_the_file_says(tmp_path, case):
    path = case.write(tmp_path)
    if case.lit is None:
        with pytest.raises(QuadshadeError) as caught:
            load_scene(path)
        assert case.refused in str(caught.value) and str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
        return
    mesh = load_scene(path)
    assert lit_pixels(mesh, case) == case.lit
    if case.note:
        assert any(case.note in note for note in mesh.notes)
    else:
        assert mesh.notes == ()


HOSTILE = (
    "two_materials.obj", "texture_moved.obj", "05-concave.ply", "12-mixed.ply", "colours16.ply",
    "textured_corners.ply", "strips.ply", "normals_and_colours.off", "magics.stl", "two_solids.stl",
    "07-sparse.glb", "10-colours16.glb", "texture_linear.glb", "skinned.glb", "external.gltf",
)  # fmt: skip
"""One case for every way through the readers."""


def damaged(content: bytes) -> list[bytes]:
    """A file cut at up to 200 places, and with one to four bytes changed, 200 times, the same every time."""
    rng = np.random.default_rng(len(content))
    out = [content[:end] for end in range(0, len(content), max(len(content) // 200, 1))]
    for _ in range(200):
        changed = bytearray(content)
        for place in rng.integers(len(content), size=rng.integers(1, 5)).tolist():
            changed[place] = int(rng.integers(256))
        out.append(bytes(changed))
    return out


@pytest.mark.parametrize("name", HOSTILE)
def test_a_damaged_file_is_a_mesh_or_one_clear_error(tmp_path, name):
    (case,) = (case for case in CASES if case.name == name)
    path = case.write(tmp_path)
    meshes = errors = 0
    for content in damaged(path.read_bytes()):
        path.write_bytes(content)
        try:
            mesh = load_scene(path)
        except QuadshadeError as error:
            errors += 1
            assert "\n" not in str(error)
            # A reason of its own, not what Python happened to stumble over.
            assert "the file is malformed" not in str(error), str(error)
        else:
            meshes += 1
            assert len(mesh) and np.isfinite(mesh.corners).all() and np.isfinite(mesh.normals).all()
    assert meshes and errors


def test_the_cases_have_names_of_their_own():
    assert len({case.name for case in CASES}) == len(CASES)
