# SPDX-License-Identifier: Apache-2.0
"""What is left of a scene in a frame time draws the same picture, and its packets take fewer words."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import ErrorCurve, stream_bytes
from quadshade.contract.formats import CONSTANT, Formats
from quadshade.engine import draw
from quadshade.image import paint, visible
from quadshade.rendering.shown_triangles import shown_triangles
from quadshade.scene import Projected, load_scene, parse_camera, project
from quadshade.setup import setup_triangles
from quadshade.shading.sample import sample

SIZE = (96, 72)
FORMATS = Formats()


def seen(scene: str, camera: str, formats: Formats = FORMATS) -> Projected:
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera(camera, mesh), *SIZE, formats)
    return projected if formats.with_depth else projected.back_to_front()


def picture(projected: Projected, formats: Formats = FORMATS) -> np.ndarray:
    pixels = draw(sample(projected, "quadratic", formats=formats), formats).pixels
    return paint(visible(pixels, *SIZE), pixels.value, (9, 9, 9))


@pytest.mark.parametrize("formats", [FORMATS, Formats(with_depth=0)], ids=["depth", "painter"])
@pytest.mark.parametrize("camera", ["from=1,0.2,0.3", "from=0,1,0.1", "from=0.3,0.3,0.2,near=0.4"])
def test_what_is_left_draws_the_same_picture(camera: str, formats: Formats) -> None:
    whole = seen("torus:288", camera, formats)
    kept = shown_triangles(whole, formats)
    assert (picture(kept, formats) == picture(whole, formats)).all()
    assert 0 < len(kept) <= len(whole)
    again = shown_triangles(kept, formats)
    assert len(again) == len(kept) and (again.depth == kept.depth).all()


def test_depth_stays_where_one_triangle_hides_another() -> None:
    whole = seen("torus:288", "from=1,0.2,0.3")
    kept = shown_triangles(whole, FORMATS)
    flat = (kept.depth == 0).all(axis=1)
    assert len(kept) < len(whole) and 0 < np.count_nonzero(flat) < len(kept)
    # Those without come first, and whoever else looks at the depth keeps it.
    assert (np.diff(flat.astype(int)) <= 0).all()
    with_depth = shown_triangles(whole, FORMATS, keeps_depth=True)
    assert len(with_depth) == len(kept) and (with_depth.depth > 0).any(axis=1).all()
    assert set(with_depth.source.tolist()) == set(kept.source.tolist())
    # Hidden behind each other in turn: nothing but depth says which is seen where.
    crossed = kept.ordered(~flat)
    assert not (picture(shown_triangles(crossed, FORMATS)) != picture(crossed)).any()


def test_nothing_is_left_of_nothing() -> None:
    whole = seen("sphere:168", "from=1,1,1")
    nothing = whole.ordered(np.zeros(len(whole), bool))
    assert len(shown_triangles(nothing, FORMATS)) == 0


def test_depth_that_is_the_same_at_all_corners_is_one_word() -> None:
    """As many words as the set-up stream has, also by what a plan says of itself."""
    facing = seen("cube:2", "from=0,0,1")
    assert (facing.depth == facing.depth[:, :1]).all() and len(facing)
    primitives = setup_triangles(sample(facing, "flat", formats=FORMATS), FORMATS)
    assert (primitives.orders[:, -1] == CONSTANT).all()
    for shading in ("quadratic", "quadratic-specular"):
        curve = ErrorCurve(shown_triangles(seen("torus:288", "from=1,0.2,0.3"), FORMATS), shading=shading)
        adapted = curve.for_error(4.0)
        assert curve.for_budget(adapted.bytes if hasattr(adapted, "bytes") else 10**6).error <= 4.0
        plan = curve.curves[0].picture(20).plan
        assert plan.cost("bytes") == stream_bytes(plan.triangles, plan.planner.shader.formats)


def test_a_wide_stream_has_depth_in_a_beat_of_its_group() -> None:
    """There constant depth saves nothing, and its packets stay as they were."""
    wide = Formats(stream_width=128)
    facing = seen("cube:2", "from=0,0,1", wide)
    primitives = setup_triangles(sample(facing, "flat", formats=wide), wide)
    assert (primitives.orders[:, -1] != CONSTANT).all()
