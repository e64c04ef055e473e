# SPDX-License-Identifier: Apache-2.0
"""Netlists to simulate, GHDL's and those of mapped cells: Icarus reads each, each is what it is called."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from quadshade.errors import QuadshadeError
from quadshade.synthesis.mapped import KINDS, netlist_files


@pytest.mark.skipif(
    not (shutil.which("ghdl") and shutil.which("iverilog")), reason="needs GHDL and Icarus: run `make setup`"
)
@pytest.mark.parametrize("kind", KINDS)
def test_icarus_reads_every_kind_without_options(kind: str) -> None:
    files = netlist_files(kind, "skid_buffer", {"data_bits": 5})
    command = ["iverilog", "-g2012", "-t", "null", "-s", "skid_buffer", *files]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    cells = {"ghdl": "posedge clk", "ice40": "SB_DFF", "ecp5": "TRELLIS_FF", "gowin": " DFFRE "}
    found = [name for name, cell in cells.items() if cell in files[0].read_text()]
    assert found == ["ghdl" if kind == "unknown" else kind]


def test_unknown_kind() -> None:
    with pytest.raises(
        QuadshadeError, match="no netlist 'xc7'; the netlists are ghdl, unknown, ecp5, gowin, ice40"
    ):
        netlist_files("xc7", "skid_buffer", {})
