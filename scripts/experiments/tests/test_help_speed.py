# SPDX-License-Identifier: Apache-2.0
"""The processor time of help: each tree runs its own package, and a ratio is that of the medians."""

from __future__ import annotations

import os
import sysconfig
from pathlib import Path

import pytest
from click.testing import CliRunner

from quadshade.errors import QuadshadeError
from scripts.experiments import help_speed
from scripts.experiments.help_speed import CALLS, MAIN, measure, ratios, report, run
from scripts.experiments.report_writer import ROOT


def test_every_call_prints_what_it_is_for() -> None:
    words = dict.fromkeys(CALLS, "--shading") | {
        "help of the program": "completion",
        "completion of a command": "plain,render",
    }
    for call, word in words.items():
        assert word in run(ROOT, MAIN, *CALLS[call])[0], call


def test_trees_take_turns_and_each_call_takes_time() -> None:
    medians = measure({"before": ROOT, "now": ROOT}, 1)
    assert list(medians) == list(CALLS)
    assert all(value > 0 for times in medians.values() for value in times.values())


def test_the_package_of_another_tree_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packages = f"{ROOT / 'model'}{os.pathsep}{sysconfig.get_path('purelib')}"
    monkeypatch.setattr(sysconfig, "get_path", lambda _: packages)
    with pytest.raises(QuadshadeError, match="is imported instead of"):
        measure({"before": tmp_path, "now": ROOT}, 1)


def test_a_commit_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    options = ["--commit", "no-such-commit", "--output", str(tmp_path / "help.md")]
    outcome = CliRunner().invoke(help_speed.main, options)
    assert outcome.exit_code == 2
    assert "git cannot export commit no-such-commit" in outcome.output
    assert not list(tmp_path.iterdir())


def test_a_ratio_above_the_target_is_missed() -> None:
    medians = {"a": {"before": 2.0, "now": 0.5}, "b": {"before": 1.0, "now": 0.36}}
    assert ratios(medians) == {"a": 0.25, "b": 0.36}
    text = report("command", "0123abc", 3, medians)
    assert "| a | 2.000 | 0.500 | 0.250 met |" in text
    assert "| b | 1.000 | 0.360 | 0.360 MISSED |" in text
