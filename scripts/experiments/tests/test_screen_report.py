# SPDX-License-Identifier: Apache-2.0
"""Memories become block RAM of both families, and the report says how many."""

from __future__ import annotations

import json
import shutil

import pytest

from scripts.experiments import screen_area as screen

SIZE = {"width": 64, "height": 32}
needs_ghdl = pytest.mark.skipif(shutil.which("ghdl") is None, reason="needs GHDL: run `make setup`")


@needs_ghdl
@pytest.mark.parametrize(
    "unit, device, generics, blocks, flip_flops",
    [
        ("framebuffer", "ecp5-25k-6", SIZE | {"value_bits": 8}, 1, 150),
        ("framebuffer", "ice40-hx8k", SIZE | {"value_bits": 8}, 4, 150),
        ("depth_test", "ecp5-25k-6", SIZE | {"value_bits": 8, "depth_bits": 8}, 1, 550),
    ],
)
def test_memory_becomes_block_ram(
    unit: str, device: str, generics: dict[str, int], blocks: int, flip_flops: int
) -> None:
    row = screen.measure(unit, device, generics, seeds=0)
    # Those of the pipeline; 2048 words in flip-flops would be thousands more.
    assert row["bram"] == blocks and row["ff"] < flip_flops and row["dsp"] == 0


def test_report_has_a_row_for_every_case() -> None:
    committed = json.loads(screen.REPORT.with_suffix(".json").read_text())
    cases = [(row["unit"], row["device"], row["generics"]) for row in committed["rows"]]
    assert cases == [tuple(case) for case in screen.CASES]
    assert screen.REPORT.read_text() == screen.report(committed)
