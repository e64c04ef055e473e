# SPDX-License-Identifier: Apache-2.0
"""Runs are counted as the controller's model takes them, spans are those of triangles, no gap is shown."""

from __future__ import annotations

import json

import numpy as np

from quadshade.golden.common.sdram_controller import Run, SdramController, SdramGenerics
from quadshade.golden.screen.sdram_depth_test import span_clocks
from quadshade.golden.screen.sdram_line_fetch import most_line_clocks
from scripts.experiments import sdram_budget as budget


def test_runs_come_when_the_model_takes_them() -> None:
    generics, cycles = SdramGenerics(), 9_000
    model = SdramController(generics)
    model.state = "waits"
    write, read = Run(0, generics.run_words - 1, True), Run(0, generics.run_words - 1)
    seen, left, asked, last_words = [], 0, 0, []
    for clock in range(cycles):
        if clock % budget.LINE == 1:
            left, asked = budget.SIZE[0] // generics.run_words, clock
        if model.coming[0] == 0:
            last_words.append(clock)
        accepted = model.free and left > 0
        if accepted:
            seen.append((clock // budget.LINE, asked, clock))
            left, asked = left - 1, clock + 1
            model.clock(read, write, 0, 0)
        else:
            model.clock(read if left else None, write, 0, 0)
    assert list(budget.runs(generics, 3)) == seen
    found = budget.fetch(generics, 3)
    times = [clock % budget.LINE for clock in last_words[budget.SIZE[0] - 1 :: budget.SIZE[0]]]
    assert (len(seen), found.line) == (30, max(times))
    assert found.line <= most_line_clocks(budget.SIZE[0], generics) < budget.LINE


def test_spans_are_those_of_triangles() -> None:
    x, y = np.array([3, 4, 5, 9, 8, 7, 7, 1]), np.array([1, 1, 1, 1, 1, 1, 2, 2])
    assert budget.spans_of(x, y, 16).tolist() == [3, 3, 1, 1]
    assert budget.spans_of(x, y, 4).tolist() == [1, 2, 2, 1, 1, 1]
    generics = SdramGenerics()
    one, full = span_clocks(1, generics), span_clocks(64, generics)
    assert (one, full) == (27, 216)
    assert budget.depth_clocks(np.array([1, 64, 1, 64]), generics) == 2 * one + 2 * full


def test_the_report_is_that_of_its_numbers() -> None:
    committed = json.loads(budget.REPORT.with_suffix(".json").read_text())
    assert budget.report(committed) == budget.REPORT.read_text()
    assert [row["scene"] for row in committed["scenes"]] == list(budget.SCENES)
    for memory, generics in zip(committed["memories"], budget.MEMORIES.values(), strict=True):
        assert {name: memory[name] for name in budget.share(generics)} == budget.share(generics)
        assert memory["line"] <= most_line_clocks(budget.SIZE[0], generics) < budget.LINE
