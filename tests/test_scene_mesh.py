# SPDX-License-Identifier: Apache-2.0
"""Meshes: generated ones have the counts asked for, files keep what they hold."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from quadshade.errors import QuadshadeError
from quadshade.scene import build_mesh, load_scene
from quadshade.scene.mesh import face_normals, merge_vertices

CUBE = trimesh.creation.box((2, 2, 2))


def as_trimesh(mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


@pytest.mark.parametrize(
    ("scene", "count", "euler", "volume"),
    [
        ("sphere:168", 168, 2, 3.8),
        ("sphere:374", 374, 2, 4.0),
        ("sphere:690", 690, 2, 4.05),
        ("sphere:12x17", 374, 2, 4.0),
        ("sphere:2x3", 6, 2, 0.8),
        ("sphere:1000", 1000, 2, 4.1),
        ("torus:288", 288, 0, 2.7),
        ("torus:12x12", 288, 0, 2.7),
        ("torus:3x3", 18, 0, 0.3),
        ("icosphere:0", 20, 2, 2.5),
        ("icosphere:3", 1280, 2, 4.1),
        ("cube:1", 12, 2, 7.9),
        ("cube:3", 108, 2, 7.9),
    ],
)
def test_generated_mesh_is_closed_outward_and_has_the_count(scene, count, euler, volume):
    mesh = load_scene(scene)
    shape = as_trimesh(mesh)
    assert len(mesh) == count
    assert shape.is_watertight and shape.is_winding_consistent
    assert shape.euler_number == euler
    assert shape.volume > volume
    assert np.allclose(np.linalg.norm(mesh.normals, axis=-1), 1)
    assert (np.einsum("nki,ni->nk", mesh.normals, face_normals(mesh.corners)) > 0.2).all()
    assert (face_normals(mesh.corners) != 0).any(axis=1).all()


@given(st.integers(2, 40), st.integers(3, 40))
def test_a_sphere_of_a_count_has_exactly_that_count(stacks, slices):
    count = 2 * slices * (stacks - 1)
    try:
        assert len(load_scene(f"sphere:{count}")) == count
    except QuadshadeError as error:
        assert "nearest counts" in str(error) or "least count" in str(error)
    assert len(load_scene(f"sphere:{stacks}x{slices}")) == count


def test_an_impossible_count_names_the_nearest_possible_ones():
    with pytest.raises(QuadshadeError, match="nearest counts are 162 and 168"):
        load_scene("sphere:167")
    with pytest.raises(QuadshadeError, match="the least count is 18$"):
        load_scene("torus:2")
    assert [len(load_scene(f"sphere:{count}")) for count in (162, 168)] == [162, 168]


@pytest.mark.parametrize(
    "scene",
    [
        "sphere:1x9",
        "sphere:0",
        "sphere:-4",
        "sphere:",
        "sphere:9x",
        "sphere:999999999",
        "sphere:9999x9999",
        "torus:2x9",
        "torus:7",
        "icosphere:9",
        "cube:0",
        "cube:1x1",
        "icosphere:1x1",
        "cone:12",
        "no_such_thing",
        "nothing.obj",
        "",
    ],
)
def test_a_bad_scene_name_is_one_clear_error(scene):
    with pytest.raises(QuadshadeError) as caught:
        load_scene(scene)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("crease", "distinct"), [(0, 6), (60, 6), (89, 6), (180, 8)])
def test_crease_keeps_a_cube_sharp_or_rounds_it(crease, distinct):
    mesh = build_mesh(CUBE.vertices, CUBE.faces, crease=crease)
    assert len(np.unique(np.round(mesh.normals.reshape(-1, 3), 9), axis=0)) == distinct
    flat = np.repeat(face_normals(mesh.corners)[:, None], 3, axis=1)
    rounded = mesh.corners / np.sqrt(3)
    assert np.allclose(mesh.normals, flat if distinct == 6 else rounded)


def test_smooth_normals_of_a_sphere_come_near_the_exact_ones():
    sphere = load_scene("icosphere:3")
    computed = load_scene("icosphere:3", crease=180)
    assert np.abs(computed.normals - sphere.normals).max() < 0.01


def test_a_crease_leaves_neighbours_of_a_sharp_edge_smooth():
    """A roof of two smooth slopes: normals are shared within a slope and differ across the ridge."""
    rows = np.array([[0, 0, 0], [1, 0.1, 0], [2, 0.25, 0], [3, -1, 0], [4, -2.1, 0]], dtype=float)
    vertices = np.concatenate([rows, rows + (0, 0, -1)])
    quads = np.arange(4)[:, None]
    faces = np.concatenate([quads + (0, 1, 6), quads + (0, 6, 5)])
    normals = build_mesh(vertices, faces, crease=30).normals
    for vertex, groups in ((1, 1), (2, 2), (3, 1)):
        assert len(np.unique(np.round(normals[faces == vertex], 9), axis=0)) == groups


@pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "stl"])
def test_files_keep_faces_and_normals(tmp_path, suffix):
    shape = trimesh.creation.icosphere(subdivisions=2)
    shape.vertex_normals  # noqa: B018 - computed here, so that it is exported
    path = tmp_path / f"mesh.{suffix}"
    shape.export(path)
    mesh = load_scene(path)
    assert len(mesh) == len(shape.faces)
    assert np.allclose(mesh.corners, shape.vertices[shape.faces], atol=1e-6)
    assert as_trimesh(mesh).is_watertight
    expected = shape.vertex_normals[shape.faces]
    assert np.abs(mesh.normals - expected).max() < (0.02 if suffix == "stl" else 1e-5)


@pytest.mark.parametrize("suffix", ["obj", "ply"])
def test_normals_of_a_file_are_used_unless_a_crease_is_given(tmp_path, suffix):
    tilted = np.tile([0.0, 0.6, 0.8], (3, 1))
    shape = trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], vertex_normals=tilted, process=False
    )
    path = tmp_path / f"tilted.{suffix}"
    shape.export(path)
    assert np.allclose(load_scene(path).normals, tilted, atol=1e-6)
    assert np.allclose(load_scene(path, crease=180).normals, (0, 0, 1))


def test_parts_of_a_scene_are_joined_where_they_are_placed(tmp_path):
    scene = trimesh.Scene()
    moved = trimesh.transformations.translation_matrix((5, 0, 0))
    mirrored = np.diag([-1.0, 1, 1, 1]) @ moved
    scene.add_geometry(CUBE, geom_name="cube", node_name="here")
    scene.add_geometry(CUBE, geom_name="cube", node_name="there", transform=moved)
    scene.add_geometry(trimesh.creation.icosphere(2), node_name="mirrored", transform=mirrored)
    path = tmp_path / "scene.glb"
    scene.export(path)
    mesh = load_scene(path)
    assert len(mesh) == 12 + 12 + 320
    assert np.allclose(mesh.vertices.min(axis=0), (-6, -1, -1), atol=0.02)
    assert np.allclose(mesh.vertices.max(axis=0), (6, 1, 1))
    outward = np.einsum("nki,ni->nk", mesh.normals, face_normals(mesh.corners))
    assert (outward > 0.5).all()
    assert as_trimesh(mesh).volume == pytest.approx(16 + trimesh.creation.icosphere(2).volume, rel=1e-4)


def test_colours_of_a_file_reach_the_corners(tmp_path):
    shape = CUBE.copy()
    shape.visual.vertex_colors = np.tile([255, 51, 0, 255], (8, 1)).astype(np.uint8)
    path = tmp_path / "red.ply"
    shape.export(path)
    assert np.allclose(load_scene(path).colours, (1, 0.2, 0))
    assert load_scene("sphere:168").colours is None


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("garbage.obj", b"\x00\x01\x02 no mesh"),
        ("empty.obj", b""),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n"),
        ("range.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("inf.obj", b"v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("word.obj", b"v a b c\nf 1 2 3\n"),
        ("garbage.glb", b"glTF but not really"),
        ("short.glb", b"glTF\x02\x00\x00\x00"),
        ("garbage.ply", b"ply\nformat nothing\n"),
        ("garbage.stl", b"solid\nnothing\n"),
        ("short.stl", bytes(80) + b"\xff\xff\x00\x00"),
        ("mesh.blend", b"BLENDER"),
    ],
)
def test_a_bad_file_is_one_clear_error(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(QuadshadeError) as caught:
        load_scene(path)
    assert "\n" not in str(caught.value)


OFF = "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 2 1 0\n"


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("nan.obj", "v 5 5 5\nv nan 0 0\nv 1 0 0\nf 1 2 3\n", "a vertex is [nan, 0.0, 0.0], not finite"),
        ("zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3/1 0/2 1/3\n", "line 5 names vertex 0"),
        ("last.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0", "line 4 names vertex 0"),
        ("range.ply", "3 0 1 7", "a face names a vertex that does not exist"),
        ("line.off", OFF.removesuffix("3 2 1 0\n"), "cut short"),
        ("word.off", OFF.removesuffix(" 0\n"), "cut short"),
        ("junk.gltf", "junk", "it is no JSON"),
        ("alone.gltf", '{"buffers": [{"uri": "no.bin", "byteLength": 4}]}', "version is missing"),
        ("x.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float a\nend_header\n1\n", "no 'x'"),
    ],
)
def test_a_bad_file_is_named_with_what_is_wrong(tmp_path, name, content, reason):
    header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    path = tmp_path / name
    path.write_text(header + content if name == "range.ply" else content)
    with pytest.raises(QuadshadeError) as caught:
        load_scene(path)
    assert str(path) in str(caught.value) and reason in str(caught.value)


def test_zeros_elsewhere_in_a_text_file_are_no_faults(tmp_path):
    path = tmp_path / "sound.obj"
    path.write_text("# f 0 1 2\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 03/1/1\n")
    assert len(load_scene(path)) == 1
    path = tmp_path / "sound.off"
    path.write_text("# of\nOFF 3 2 0\n\n" + OFF.partition("2 0\n")[2] + "trailing\n")
    assert len(load_scene(path)) == 2
    for path, what in (
        (tmp_path, "no file or scene|a folder"),
        (Path(os.devnull), "is no file|no such file"),
    ):
        with pytest.raises(QuadshadeError, match=what):
            load_scene(path)


def test_a_file_that_may_not_be_read_is_not_called_malformed(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied", "part.stl")

    (tmp_path / "part.stl").touch()
    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(QuadshadeError, match=r"cannot read .*part.stl: Permission denied; give a mesh file$"):
        load_scene(tmp_path / "part.stl")


@pytest.mark.parametrize("crease", [-1, 181, float("nan")])
def test_a_crease_out_of_range_is_refused(crease):
    with pytest.raises(QuadshadeError, match="crease"):
        load_scene("sphere:168", crease)


@given(st.lists(st.tuples(*[st.sampled_from([-1.0, -0.0, 0.0, 2.5])] * 3), min_size=3, max_size=30))
def test_merging_keeps_every_corner_and_no_two_vertices_at_one_place(points):
    vertices = np.array(points)
    faces = np.arange(len(points) // 3 * 3).reshape(-1, 3)
    merged, renamed = merge_vertices(vertices, faces)
    assert np.array_equal(merged[renamed], vertices[faces])
    assert len(np.unique(merged, axis=0)) == len(merged)


@pytest.mark.parametrize(
    ("what", "array"),
    [
        ("vertices", np.eye(3)[:, :2]),
        ("faces", [[0, 1]]),
        ("normals", np.ones((2, 3, 3))),
        ("colours", [1.0]),
    ],
)
def test_arrays_of_another_shape_are_refused(what, array):
    arrays = {"vertices": np.eye(3), "faces": [[0, 1, 2]]} | {what: array}
    with pytest.raises(QuadshadeError, match=f"the mesh's {what} have the shape"):
        build_mesh(**arrays)
