# SPDX-License-Identifier: Apache-2.0
"""Every case of a mesh file shows what it says, or is refused with one line; so do damaged files."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial, SimpleMaterial

import quadshade
from quadshade.errors import QuadshadeError
from quadshade.scene import load_scene
from quadshade.scene.from_trimesh import mesh_from_trimesh
from tests.support.mesh_pictures import CASES, lit_pixels


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
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


def test_what_a_picture_does_not_show_is_a_notice(tmp_path):
    path = CASES["points_and_lines.obj"].write(tmp_path)
    asked = {"size": (16, 16), "engine": "model"}
    lines, points = (f"points_and_lines.obj: 1 {kind} element not drawn" for kind in ("line", "point"))
    with pytest.warns(UserWarning, match=lines), pytest.warns(UserWarning, match=points):
        picture = quadshade.render(path, **asked)
    assert picture.notes == tuple(f"{path}: 1 {kind} element not drawn" for kind in ("point", "line"))
    # A crease changes the normals and nothing else.
    mesh = load_scene(path)
    with pytest.warns(UserWarning, match="line"), pytest.warns(UserWarning, match="point"):
        assert quadshade.render(mesh, crease=30.0, **asked).notes[0].endswith("1 point element not drawn")


def test_a_near_plane_too_close_for_depth_is_a_notice():
    with pytest.warns(UserWarning, match="16 bits of depth resolve only"):
        quadshade.render("cube:1", size=(16, 16), engine="model", camera="eye=0,0,3,target=0,0,0,near=0.0001")


@pytest.mark.parametrize(
    ("material", "colour"),
    [
        (PBRMaterial(), (1, 1, 1)),
        (PBRMaterial(baseColorFactor=[255, 51, 0, 255]), (1, 0.2, 0)),
        (PBRMaterial(metallicFactor=0.0, doubleSided=True), (1, 1, 1)),
        (SimpleMaterial(diffuse=[0, 255, 0, 255]), (0, 1, 0)),
        (PBRMaterial(baseColorTexture=Image.new("RGB", (4, 4), (0, 0, 255))), (0, 0, 1)),
        (SimpleMaterial(image=Image.new("L", (4, 4), 51), diffuse=[255, 0, 0, 255]), (0.2, 0, 0)),
    ],
)
def test_materials_of_trimesh_are_those_of_files(material, colour):
    shape = trimesh.creation.box()
    shape.visual = TextureVisuals(uv=np.full((8, 2), 0.4), material=material)
    mesh = mesh_from_trimesh(shape)
    assert np.allclose(mesh.colours, colour)
    assert (mesh.double_sided is not None) == bool(getattr(material, "doubleSided", False))


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
    path = CASES[name].write(tmp_path)
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
