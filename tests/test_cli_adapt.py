# SPDX-License-Identifier: Apache-2.0
"""``quadshade render`` with an allowed error or a budget."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from quadshade.cli.main import main


def run(*arguments: str) -> tuple[int, str]:
    """Exit code and everything printed."""
    result = CliRunner().invoke(main, ["render", "sphere:168", "--size", "128x128", *map(str, arguments)])
    return result.exit_code, result.output


def test_error_is_kept_and_the_mix_reported(tmp_path: Path) -> None:
    picture, stats = tmp_path / "a.png", tmp_path / "a.json"
    code, output = run(
        "-o", picture, "--engine", "model", "--max-error", "1.5", "--exponent", "80", "--stats", stats
    )
    assert code == 0, output
    content = json.loads(stats.read_text())
    found = content["adaptive"]
    assert content["shading"] == "adaptive"
    assert found["bytes"] == 4 * content["words"] + found["state_bytes"]
    assert found["measured_max"] <= 1.5
    assert found["share_over_max_error"] == 0
    assert content["triangles"] == found["triangles"] == sum(found["triangles_by_order"].values())
    # Nobody has chosen between colours and cosines: what was, and what the other takes, is said.
    assert found["adaptive_shading"] == "quadratic-specular" and content["generics"]["with_shade"] == 1
    other = found["rival"]
    assert (
        other["shading"] in ("quadratic", "quadratic-lights")
        and other["bytes"] > found["bytes"] > found["state_bytes"] > 0
    )
    # Under load a line of progress may come before them.
    labels = ["channels", "bytes", "triangles", "divided", "error"]
    lines = [line.split(maxsplit=1) for line in output.splitlines() if line.startswith("  ")]
    assert [label for label, _ in lines if label in labels] == labels
    said = dict(lines)
    assert said["channels"] == "quadratic-specular"
    least = "about " if other["error"] is None else ""
    assert said["bytes"] == f"{found['bytes']} (as {other['shading']} {least}{other['bytes']})"
    assert said["triangles"].startswith(f"{found['triangles']} sent: ")
    assert said["error"].startswith(f"largest {found['measured_max']:.2f}, rms ")


@pytest.mark.parametrize(
    ("budget", "key"), [("8000", "bytes"), ("8000bytes", "bytes"), ("14000clocks", "clocks")]
)
def test_budget_is_kept(tmp_path: Path, budget: str, key: str) -> None:
    stats = tmp_path / "a.json"
    code, output = run(
        "-o", tmp_path / "a.png", "--engine", "model", "--budget", budget, "--error-measure", "rms",
        "--stats", stats
    )  # fmt: skip
    assert code == 0, output
    content = json.loads(stats.read_text())
    assert content["adaptive"]["budget_unit"] == key
    spent = content["adaptive"]["bytes"] if key == "bytes" else content["clocks"]
    assert spent <= content["adaptive"]["budget"]
    # What is said was measured at every pixel; an estimate is named as one.
    assert content["adaptive"]["error"] == pytest.approx(content["adaptive"]["measured_rms"], rel=1e-12)
    assert content["adaptive"]["error_verified"] and "estimated" not in output
    code, output = run("-o", tmp_path / "b.png", "--engine", "model", "--budget", budget, "--no-verify")
    assert code == 0 and re.search(r"\(estimated max \d+\.\d+, no bound\)", output)


def test_fixed_pictures_say_nothing_of_it(tmp_path: Path) -> None:
    stats = tmp_path / "a.json"
    code, output = run("-o", tmp_path / "a.png", "--engine", "model", "--stats", stats)
    assert code == 0
    assert "adaptive" not in json.loads(stats.read_text())
    assert "channels" not in output


def test_a_linear_core_draws_adaptive_pictures(tmp_path: Path) -> None:
    code, output = run(
        "-o", tmp_path / "a.png", "--engine", "model", "--max-error", "5", "--generic", "max_order=1"
    )
    assert code == 0, output
    assert "0 quadratic" in output


@pytest.mark.parametrize("shading", ["quadratic", "quadratic-specular"])
def test_a_shading_that_is_given_is_taken(tmp_path: Path, shading: str) -> None:
    stats = tmp_path / "a.json"
    code, output = run(
        "-o", tmp_path / "a.png", "--engine", "model", "--max-error", "20", "--stats", stats,
        "--shading", shading,
    )  # fmt: skip
    assert code == 0, output
    found = json.loads(stats.read_text())["adaptive"]
    assert found["adaptive_shading"] == shading and found["rival"] is None
    assert (found["state_bytes"] > 0) == (shading != "quadratic")
    assert f"channels   {shading}\n" in output
    assert ("with a power" in output) == (shading != "quadratic")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--generic", "with_shade=0"], "with_shade is 0"),
        (["--exponent", "5000"], "exponent 5000"),
        (["--light", "ambient=0.5"], "all light is ambient"),
    ],
)
def test_scenes_without_cosines_are_drawn_in_colours_and_why_is_said(
    tmp_path: Path, arguments: list[str], reason: str
) -> None:
    code, output = run("-o", tmp_path / "a.png", "--engine", "model", "--max-error", "9", *arguments)
    assert code == 0, output
    assert "notice: drawn as quadratic: " in output and reason in output
    assert "channels   quadratic\n" in output


def test_a_pack_is_adaptive_too(tmp_path: Path) -> None:
    arguments = ["pack", "sphere:168", "--size", "128x128", "-o", str(tmp_path / "a.qs"), "--max-error", "9"]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    # Without the power in the table there is little state.
    assert "channels   quadratic-lights\n" in result.output and "(as quadratic" in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--max-error", "4", "--budget", "9000"], "not both"),
        (["--max-error", "0.5"], "rounding the output"),
        (["--max-error", "nan"], "rounding the output"),
        (["--max-error", "inf"], "the allowed error is infinite"),
        (["--budget", "12parsecs"], "is not a budget"),
        (["--budget", "5bytes"], "the cheapest picture takes"),
        (["--error-measure", "rms"], "give --max-error or --budget"),
        (["--max-error", "4", "--shading", "phong"], "leave --shading out"),
        (["--max-error", "4", "--setup", "xshading"], "another --setup"),
        (["--max-error", "4", "--shading", "quadratic-specular", "--toon", "3"], "--toon with --max-error"),
    ],
)
def test_refusals(tmp_path: Path, arguments: list[str], message: str) -> None:
    code, output = run("-o", tmp_path / "a.png", *arguments)
    assert code == 2
    assert message in output
    assert len(output.strip().splitlines()) == 1
    assert not (tmp_path / "a.png").exists()
