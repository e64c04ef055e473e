# SPDX-License-Identifier: Apache-2.0
"""Faults on the line: no damaged frame is accepted, no session ends with wrong words; the reports."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from scripts.experiments import link_faults as faults


@pytest.mark.parametrize("rate", faults.RATES)
def test_no_damaged_frame_is_accepted(rate: float, seed: int) -> None:
    result = faults.codec_run(rate, at_least=300, seed=seed)
    assert result.injected >= 300
    assert result.wrong == 0
    assert 0 < result.accepted < result.sent


@pytest.mark.parametrize("rate", [1e-3, 1e-2])
def test_no_session_ends_with_wrong_words(rate: float, seed: int) -> None:
    result = faults.session_run(rate, at_least=20, seed=seed, words=3000)
    assert result.injected >= 20
    assert (result.wrong, result.given_up) == (0, 0)
    assert result.words == 3000 * result.sessions
    assert result.resent > 0


def test_reports_are_of_what_was_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faults, "SESSION_SHARES", {1e-3: 1})
    output = tmp_path / "faults.md"
    arguments = ["--frames", "510", "--sessions", "10", "--output", str(output)]
    done = CliRunner().invoke(faults.main, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    beside = tmp_path / "faults_sessions.md"
    for report, command in ((output, "--frames 510 --seed 1"), (beside, "--sessions 10 --seed 1")):
        assert f"`python -m scripts.experiments.link_faults {command}`" in report.read_text()
        assert report.read_text().endswith(" faults, 0 wrong.**\n")
        assert report.with_suffix(".json").is_file()
