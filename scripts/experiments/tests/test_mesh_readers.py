# SPDX-License-Identifier: Apache-2.0
"""The report on readers judges a case by its pixels, and is that of its numbers."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scripts.experiments import mesh_readers
from scripts.experiments.mesh_readers import CASES, compare_samples, in_processes, judge, report, same_picture


@pytest.mark.parametrize(
    ("name", "reader", "outcome"),
    [
        ("04-negative.obj", "quadshade", "right"),
        ("04-negative.obj", "trimesh", "wrong"),
        ("08-draco.glb", "quadshade", "right"),
        ("08-draco.glb", "trimesh", "unseen"),
        ("12-mixed.ply", "trimesh", "refused"),
        ("12-mixed.ply", "tinyobjloader", "none"),
    ],
)
def test_a_case_is_judged_by_its_pixels(tmp_path, name, reader, outcome):
    assert judge(CASES[name], reader, tmp_path) == outcome


def test_colours_may_be_two_levels_off_and_pixels_may_not():
    assert same_picture({(254, 1, 0): 9, (255, 0, 0): 1}, {(255, 0, 0): 10})
    assert not same_picture({(250, 0, 0): 10}, {(255, 0, 0): 10})
    assert not same_picture({(255, 0, 0): 9}, {(255, 0, 0): 10})
    assert same_picture({}, {})


def test_a_process_that_dies_costs_one_case(tmp_path, monkeypatch):
    """A reader whose process ends itself at the second case."""
    names = list(CASES)[:3]

    def run(command, folder):
        listed, log = (Path(command[command.index(option) + 1]) for option in ("--cases", "--log"))
        left = json.loads(listed.read_text())
        done = left[: left.index(names[1])] if names[1] in left else left
        log.write_text("".join(f"{name}\tright\n" for name in done))

    monkeypatch.setattr(mesh_readers, "run_to_end", run)
    outcomes = in_processes("assimp", tmp_path, "--cases", names)
    assert outcomes == {names[0]: "right", names[1]: "crash", names[2]: "right"}


def test_the_report_is_that_of_its_numbers():
    right = dict.fromkeys(CASES, "right")
    cases = {"quadshade": right, "trimesh": right | {"plain.off": "wrong"}}
    samples = {
        "quadshade": {"a.obj": "1.000e+00", "b.obj": "refused b.obj: it is cut short", "c.obj": "refused"},
        "trimesh": {"a.obj": "1.001e+00", "b.obj": "5.000e+00", "c.obj": "refused"},
    }
    assert list(compare_samples(samples)) == [["trimesh", "1", "0", "0", "1", "1", "0"]]
    text = report({"packages": ["trimesh"], "cases": cases, "samples": samples})
    assert "| plain.off | ✓ | wrong |" in text and "plain.stl" not in text
    assert "| b.obj | trimesh | it is cut short |" in text
    count = sum(name.endswith(".off") for name in CASES)
    assert f"| off | {count} of {count} | {count - 1} of {count} |" in text
