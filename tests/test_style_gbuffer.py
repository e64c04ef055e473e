# SPDX-License-Identifier: Apache-2.0
"""The G-buffer pass: normals, linear depth, the same from every engine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.engine import ENGINES
from quadshade.errors import QuadshadeError
from quadshade.scene import load_scene, parse_camera, project
from quadshade.style import draw_gbuffer, sample_normals
from quadshade.style.gbuffer import FAR_SHARE

SIZE = 64


def seen(scene: str, camera: str = "from=1,0.8,1", formats: Formats | None = None):
    mesh = load_scene(scene)
    return project(mesh, parse_camera(camera, mesh), SIZE, SIZE, formats or Formats())


def test_a_cube_has_three_normals() -> None:
    projected = seen("cube:2")
    gbuffer, _ = draw_gbuffer(projected, space="world")
    normals = np.unique(gbuffer.normal[gbuffer.covered], axis=0)
    expected = np.rint((np.eye(3) + 1) * 127.5).astype(np.uint8)
    # ½ of 255 is no integer: 127.5 goes to the word's rounding, one way for a whole channel.
    assert len(normals) == 3
    assert np.abs(np.sort(normals, axis=0) - np.sort(expected, axis=0).astype(int)).max() <= 1


def test_normals_turn_with_the_camera() -> None:
    projected = seen("sphere:168")
    world, _ = draw_gbuffer(projected, space="world")
    camera, _ = draw_gbuffer(projected)
    vectors = [g.normal[world.covered] / 127.5 - 1 for g in (world, camera)]
    assert np.abs(vectors[0] @ projected.axes.T - vectors[1]).max() < 4 / 255


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_depth_is_linear_in_distance(bits: int) -> None:
    formats = Formats(depth_bits=bits)
    projected = seen("cube:2", "from=1,0.8,1,ortho=1.8", formats)
    gbuffer, _ = draw_gbuffer(projected, formats)
    assert gbuffer.depth_error == 0
    full = (1 << bits) - 1
    assert (gbuffer.depth[~gbuffer.covered] == full).all()
    # The plane through each pixel's face, in exact geometry.
    half = 1.8 / (SIZE / 2)
    y, x = np.nonzero(gbuffer.covered)
    right, up, back = projected.axes
    offset = ((x + 0.5 - SIZE / 2) * half)[:, None] * right + ((SIZE / 2 - y - 0.5) * half)[:, None] * up
    corners = projected.position[gbuffer.triangle[y, x]]
    target = projected_target(projected)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    along = ((corners[:, 0] - target - offset) * normal).sum(axis=1) / (normal @ back)
    distance = -(target + offset + along[:, None] * back) @ back
    step = (gbuffer.far - gbuffer.near) / (FAR_SHARE * full)
    # Half a step of rounding, and vertices rounded to 1/256 pixel on faces of any slope.
    assert np.abs(gbuffer.distance[y, x] - distance).max() < 0.5 * step + half / 50


def projected_target(projected) -> np.ndarray:
    """The point of the scene in the picture's middle: the cube is around the origin."""
    return np.zeros(3)


def test_perspective_error_is_told() -> None:
    projected = seen("sphere:690")
    gbuffer, _ = draw_gbuffer(projected)
    assert 0 < gbuffer.depth_error < 300
    assert gbuffer.near < gbuffer.distance[gbuffer.covered].min() + 1e-9


def test_every_engine_writes_the_same_file(tmp_path: Path) -> None:
    written = []
    for engine in ENGINES:
        path = tmp_path / f"{engine}.npz"
        arguments = ["render", "torus:72", "-o", str(tmp_path / "a.png"), "--size", "48x32"]
        result = CliRunner().invoke(main, [*arguments, "--gbuffer", str(path), "--engine", engine])
        assert result.exit_code == 0, result.output
        with np.load(path) as arrays:
            written.append({name: arrays[name] for name in arrays.files})
    assert written[0]["normal"].shape == (32, 48, 3) and written[0]["normal"].dtype == np.uint8
    assert written[0]["depth"].dtype == np.uint16 and (written[0]["triangle"] >= 0).any()
    for other in written[1:]:
        for name, array in written[0].items():
            assert np.array_equal(array, other[name]), name


@pytest.mark.parametrize(
    ("formats", "order", "space", "message"),
    [
        (Formats(num_channels=4), "linear", "camera", "num_channels is 4"),
        (Formats(with_depth=0), "linear", "camera", "with_depth is 0"),
        (Formats(max_order=1), "quadratic", "camera", "max_order is 1"),
        (Formats(value_bits=9, frac_bits=21), "linear", "camera", "value_bits is 9"),
        (Formats(), "cubic", "camera", "order 'cubic'"),
        (Formats(), "linear", "moon", "'moon'"),
    ],
)
def test_refused(formats: Formats, order: str, space: str, message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        sample_normals(seen("sphere:168"), order, space, formats)
