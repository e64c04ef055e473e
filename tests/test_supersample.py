# SPDX-License-Identifier: Apache-2.0
"""Supersampled pictures are the mean of exactly moved frames, with an engine and on a board."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import quadshade
from quadshade.contract.formats import Formats
from quadshade.rendering.supersample import jitter, mean, moved
from quadshade.scene import load_scene, parse_camera, project


@pytest.mark.parametrize(("count", "bits"), [(1, 0), (2, 2), (2, 8), (4, 3), (4, 8)])
def test_frames_lie_in_the_middles_of_a_pixels_parts(count: int, bits: int) -> None:
    moves = np.array(jitter(count, Formats(subpixel_bits=bits)))
    assert len(set(map(tuple, moves.tolist()))) == count**2
    places = 0.5 - moves / 2.0**bits
    expected = (np.arange(count) + 0.5) / count
    assert sorted(set(places[:, 0].tolist())) == pytest.approx(expected.tolist())
    assert moves.sum() == 0


def test_too_coarse_sub_pixels_are_refused() -> None:
    for count, bits in ((2, 1), (4, 2)):
        with pytest.raises(quadshade.QuadshadeError, match=f"--supersample {count}"):
            jitter(count, Formats(subpixel_bits=bits))


@pytest.mark.parametrize("settings", [{}, {"style": "hatch"}, {"edges": "profile"}, {"shading": "phong"}])
def test_a_picture_is_the_mean_of_its_frames(settings: dict) -> None:
    """Against frames of a mesh that is moved by the same parts of a pixel through the camera's target."""
    mesh, size = load_scene("torus:288"), 60
    scale = 2 * 1.4 / size
    frames = []
    for down in (-0.25, 0.25):
        for across in (-0.25, 0.25):
            x, y = -across * scale, down * scale
            camera = f"eye={x},{y},5,target={x},{y},0,ortho=1.4"
            frames.append(quadshade.render(mesh, size=(size, size), camera=camera, **settings).array)
    camera = "eye=0,0,5,target=0,0,0,ortho=1.4"
    picture = quadshade.render(mesh, size=(size, size), camera=camera, supersample=2, **settings)
    # Vertices of a moved mesh are rounded anew, so a sub-pixel here or there differs: by no more than two
    # of 255 in nearly all places; frames in the wrong places would differ by whole outlines.
    off = np.abs(picture.array.astype(int) - mean(frames).astype(int)).max(axis=2)
    assert (off > 2).mean() < 0.02
    whole = quadshade.render(mesh, size=(size, size), camera=camera, **settings).array
    assert (np.abs(whole.astype(int) - mean(frames).astype(int)).max(axis=2) > 2).mean() > 0.03


def test_outlines_become_smooth_and_stay_exact() -> None:
    sharp = quadshade.render("cube:1", size=(64, 64), background=0)
    smooth = quadshade.render("cube:1", size=(64, 64), background=0, supersample=4)
    inside = (smooth.array > 0).any(axis=2)
    assert inside.sum() > sharp.covered.sum()
    # The mean of coverage over sixteenths is the outline's area.
    assert smooth.array.sum() == pytest.approx(sharp.array.sum(), rel=0.02)


def test_a_board_draws_the_same_frames() -> None:
    settings = {"size": (32, 24), "supersample": 2, "pack_error": 0.0}
    model = quadshade.render("torus:288", engine="model", **{**settings, "pack_error": None})
    with quadshade.Board("sim", engine="model") as board:
        drawn = quadshade.render("torus:288", port=board, **settings)
    assert (drawn.array == model.array).all()


def test_a_vertex_on_the_guard_band_stays_within() -> None:
    formats = Formats()
    projected = project(load_scene("cube:1"), parse_camera("", load_scene("cube:1")), 16, 16)
    low, high = formats.guard_band
    at_border = replace(projected, vertices=np.where(projected.vertices > 0, high, low))
    for by in jitter(4, formats):
        vertices = moved(at_border, by, formats).vertices
        assert vertices.min() >= low and vertices.max() <= high
