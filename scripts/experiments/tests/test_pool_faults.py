# SPDX-License-Identifier: Apache-2.0
"""The report of boards that die says what its runs were."""

from __future__ import annotations

import json

from scripts.experiments import pool_faults


def test_the_report_is_that_of_its_numbers() -> None:
    committed = json.loads(pool_faults.REPORT.with_suffix(".json").read_text())
    assert len(committed["runs"]) >= 200
    assert all(run["wrong"] == 0 and run["ended"] in ("picture", "error") for run in committed["runs"])
    # Where not all boards were killed, the picture is whole.
    assert all(run["killed"] == run["boards"] for run in committed["runs"] if run["ended"] == "error")
    assert all(run["seconds"] < pool_faults.MOST_SECONDS for run in committed["runs"])
    assert pool_faults.report(committed) == pool_faults.REPORT.read_text()
