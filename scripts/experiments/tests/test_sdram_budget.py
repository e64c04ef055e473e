# SPDX-License-Identifier: Apache-2.0
"""Runs are counted as the controller's model takes them, spans are those of triangles, no gap is shown."""

from __future__ import annotations

import json

import numpy as np
import pytest

from quadshade.golden.common.sdram_controller import Run, SdramController, SdramGenerics
from quadshade.golden.screen.sdram_depth_test import span_clocks
from scripts.experiments import sdram_budget as budget


@pytest.mark.parametrize("generics", budget.MEMORIES.values(), ids=["16", "32"])
def test_runs_come_when_the_model_takes_them(generics: SdramGenerics) -> None:
    cycles, fifo, words_per_pixel = 12_000, 128, budget.PIXEL_BITS / generics.data_bits
    model = SdramController(generics)
    model.state = "waits"
    write, read = Run(0, generics.run_words - 1, True), Run(0, generics.run_words - 1)
    seen, wanted, arrived, first_words, coming = [], None, fifo, [], False
    for clock in range(cycles):
        room = arrived - fifo + generics.run_words
        if wanted is None and budget.shown_pixels(clock) * words_per_pixel >= room:
            wanted = clock
        if model.coming[0] == 0 and not coming:
            first_words.append(clock)
        coming = model.coming[0] == 0
        if model.free and wanted is not None:
            seen.append((wanted, clock, arrived))
            model.clock(read, write, 0, 0)
            wanted, arrived = None, arrived + generics.run_words
        else:
            model.clock(None if wanted is None else read, write, 0, 0)
    assert list(budget.runs(generics, fifo, cycles)) == seen
    assert len(seen) > 15
    assert [got + generics.latency() for _, got, _ in seen][: len(first_words)] == first_words


def test_the_monitor_takes_a_pixel_in_four_clocks_and_rests() -> None:
    line = 800 * 4
    assert [budget.shown_pixels(clock) for clock in (0, 3, 4, 2559, 2560, line - 1)] == [
        1,
        1,
        2,
        640,
        640,
        640,
    ]
    assert budget.shown_pixels(line) == 641
    assert budget.shown_pixels(480 * line) == budget.shown_pixels(525 * line - 1) == 480 * 640
    assert budget.shown_pixels(525 * line) == 480 * 640 + 1


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
        assert [words for words, *_ in memory["levels"]] == list(budget.FIFO_WORDS)
        assert min(least for _, least, _ in memory["levels"]) > 0, "the monitor would show a gap"
