# SPDX-License-Identifier: Apache-2.0
"""Cartoon, Gooch's tones and hatching, from the command line and from Python."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.image import read_picture
from quadshade.style import hatch


def test_a_cartoon_has_few_tones(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    arguments = ["render", "sphere:690", "-o", str(path), "--size", "160x160", "--engine", "model"]
    result = CliRunner().invoke(main, [*arguments, "--style", "cartoon", "--toon", "3"])
    assert result.exit_code == 0, result.output
    _, counts = np.unique(read_picture(path).reshape(-1, 3), axis=0, return_counts=True)
    # Three levels, a highlight over one or two of them, paper; their borders are blended over a pixel or two,
    # and of 160 x 160 pixels 1,500 lie there.
    wide = counts > 0.002 * counts.sum()
    assert wide.sum() in (4, 5, 6)
    assert counts[wide].sum() > 0.93 * counts.sum()


@pytest.mark.parametrize("style", ["cartoon", "gooch", "hatch"])
def test_every_engine_draws_the_same(style: str, tmp_path: Path) -> None:
    pictures = []
    for engine in ("model", "verilator"):
        path = tmp_path / f"{engine}.png"
        arguments = ["render", "torus:288", "-o", str(path), "--size", "96x96", "--engine", engine]
        result = CliRunner().invoke(main, [*arguments, "--style", style, "--edges", "profile"])
        assert result.exit_code == 0, result.output
        pictures.append(read_picture(path))
    assert np.array_equal(*pictures)
    assert (pictures[0][0, 0] == 255).all()


def test_gooch_turns_from_cool_to_warm(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    arguments = ["render", "sphere:690", "-o", str(path), "--size", "96x96", "--engine", "model"]
    result = CliRunner().invoke(
        main,
        [
            *arguments,
            "--style",
            "gooch",
            "--light",
            "dir=1,0,0",
            "--material",
            "colour=0.5,0.5,0.5,specular=0",
        ],
    )
    assert result.exit_code == 0, result.output
    picture = read_picture(path).astype(int)
    assert picture[48, 8, 2] > picture[48, 8, 0] + 40, "cool on the side that faces away"
    assert picture[48, 84, 0] > picture[48, 84, 2] + 40, "warm towards the light"


def test_darker_means_more_ink() -> None:
    everywhere = np.ones((64, 64), bool)
    ink = [
        (255 - hatch(np.full((64, 64, 3), tone, np.uint8), everywhere)).sum()
        for tone in (255, 180, 120, 60, 10)
    ]
    assert ink[0] == 0 and all(one < other for one, other in itertools.pairwise(ink))
    black = np.zeros((8, 8, 3), np.uint8)
    assert (hatch(black, np.zeros((8, 8), bool)) == 255).all()
