# SPDX-License-Identifier: Apache-2.0
"""The host's measurements: what they count, and what the report says. No test asserts a time."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.errors import QuadshadeError
from quadshade.setup.literature.kernels import METHODS
from scripts.experiments import host_speed as hostspeed
from scripts.experiments import setup_speed
from scripts.experiments.report_writer import met

SCENES = ["--scene", "sphere:168", "--plain-scene", "cube:1"]
SMALL = [*SCENES, "--golden", "50", "--slices", "3", "--repeats", "1"]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, str]:
    """The numbers and the text of a run over small meshes."""
    report = tmp_path_factory.mktemp("hostspeed") / "report.md"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hostspeed, "SETUP_ROUNDS", 50)
        result = CliRunner().invoke(hostspeed.main, [*SMALL, "--output", str(report)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return json.loads(report.with_suffix(".json").read_text()), report.read_text()


def test_counts_are_those_of_the_scene(measured):
    results, _ = measured
    both = results["host_path"]
    assert both["all"]["faces"] == both["culled"]["faces"] == 168
    assert both["culled"]["triangles"] < both["all"]["triangles"] <= 168
    assert both["all"]["packets"] <= both["all"]["triangles"]
    assert [run["triangles"] for run in results["memory"]] == [1500, 3000, 6000]
    assert 0 < results["golden"]["pixels"] <= results["golden"]["clocks"]


def test_every_rate_has_its_plain_loop(measured):
    results, _ = measured
    assert results["setups"].keys() == results["plain"]["setups"].keys() == METHODS.keys()
    stages = [
        path["seconds"].keys() for path in (*results["host_path"].values(), results["plain"]["host_path"])
    ]
    assert all(list(names) == list(hostspeed.STAGES) for names in stages)
    assert results["setups_float32"].keys() == METHODS.keys()
    assert all(rate > 0 for rate in [*results["setups"].values(), *results["plain"]["setups"].values()])


def test_instructions_are_those_of_the_longest_stretch():
    lines = ["start:", "\tvmulsd\t%xmm0, %xmm1, %xmm0", "loop:"]
    lines += [
        "\tvdivps\t%ymm1, %ymm2, %ymm3",
        "\tvsqrtps\t(%rax), %ymm3",
        "\tvfnmadd231ps\t%ymm1, %ymm2, %ymm3",
    ]
    lines += ["\tvmulps\t%ymm1, %ymm2, %ymm3", "\tvsubps\t%ymm1, %ymm2, %ymm3", "\tvmovups\t%ymm3, (%rax)"]

    text = "\n".join([*lines, "end:", "\tvaddps\t%ymm1, %ymm2, %ymm3"])
    expected = {"divisions": 1, "roots": 1, "products": 2, "sums": 1, "bytes": 32}
    assert setup_speed.instructions(text, 4) == expected


def test_published_counts_are_those_of_the_formulas():
    """Five divisions of Abbas et al., nine and three roots of the normals between; one of X-shading."""
    bounds = json.loads(hostspeed.REPORT.with_suffix(".json").read_text())["bounds"]
    for name in setup_speed.TYPES:
        counts = bounds[name]["instructions"]
        assert (counts["abbas"]["divisions"], counts["abbas"]["roots"]) == (5 + 9, 3)
        assert counts["x_shading"]["divisions"] == 1 and "roots" not in counts["x_shading"]


def test_report_is_written_from_the_numbers(measured):
    results, text = measured
    assert text == hostspeed.report(results)
    for title in ("Set-ups", "What binds the set-ups", "Host path", "Golden model", "Memory"):
        assert f"## {title}\n" in text
    rate = results["setups"]["x_shading"] / results["setups"]["abbas"]
    assert re.search(rf"^\| `x_shading` \|.*\| {rate:.2f} \| 3\.31 \|", text, re.MULTILINE)


def test_published_report_is_that_of_its_numbers():
    numbers = json.loads(hostspeed.REPORT.with_suffix(".json").read_text())
    assert hostspeed.REPORT.read_text() == hostspeed.report(numbers)
    assert max(run["triangles"] for run in numbers["memory"]) == 1_000_000
    assert numbers["golden"]["triangles"] == 10_000


@pytest.mark.parametrize(
    ("value", "most", "word"),
    [(2.0, False, "met"), (0.5, False, "MISSED"), (0.5, True, "met"), (2.0, True, "MISSED")],
)
def test_a_missed_target_is_called_so(value, most, word):
    assert met(value, 1.0, most).endswith(f" {word}")


def test_set_up_otherwise_than_in_the_plain_loop_is_an_error(monkeypatch):
    wrong = {"host_path": {"words": "other"}}
    monkeypatch.setattr(hostspeed, "plain_loops", lambda scene: wrong)
    with pytest.raises(QuadshadeError, match="differ"):
        hostspeed.measure("sphere:168", "sphere:24", 10, 3, 1)


def test_golden_frame_is_of_the_size_it_says():
    words, formats = hostspeed.golden_frame(40)
    drawn = hostspeed.draw_fast(words, formats)
    assert 35 <= len(np.unique(drawn.packet)) <= 40
    assert drawn.x.max() < 640 and drawn.y.max() < 480


def test_a_failing_render_is_reported(monkeypatch):
    monkeypatch.setattr(hostspeed, "SCREEN", 0)
    with pytest.raises(QuadshadeError, match="render sphere:4x3 failed"):
        hostspeed.peak_memory(4, 3)
