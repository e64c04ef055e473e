# SPDX-License-Identifier: Apache-2.0
"""Cells in the place of a module do what the module does: Yosys proves it, and rejects a wrong cell."""

from __future__ import annotations

from pathlib import Path

import pytest

from quadshade.engine.netlist import write_netlist
from quadshade.engine.sources import repository_root
from quadshade.errors import QuadshadeError
from quadshade.synthesis.cells import with_cells
from quadshade.synthesis.mapped import cell_models
from tests.support.yosys_proof import prove_equal

UNIT = "load_adder"


def prove(cells: str, module: str, folder: Path) -> None:
    """Prove that the cells' module equals ``module``, for all inputs."""
    prove_equal(UNIT, module, cells, cell_models("ecp5"), folder)


def sources(width: int, with_carry: int) -> tuple[str, str]:
    """The cells and GHDL's module, both under the entity's name."""
    root = repository_root()
    module = write_netlist({"width": width, "with_carry": with_carry}, UNIT).read_text()
    cells = with_cells(module.replace(f"module {UNIT}", f"module {UNIT}_{width}_{with_carry}"), "ecp5", root)
    assert "CCU2C" in cells
    return cells.replace(f"module {UNIT}_{width}_{with_carry}", f"module {UNIT}"), module


@pytest.mark.parametrize(("width", "with_carry"), [(1, 0), (2, 1), (5, 0), (13, 1), (32, 0), (32, 1)])
def test_load_adder_in_carry_cells(width: int, with_carry: int, tmp_path: Path) -> None:
    prove(*sources(width, with_carry), tmp_path)


@pytest.mark.parametrize(("right", "wrong"), [("16'hBE14", "16'hBE1C"), ("16'h0004", "16'h0008")])
def test_a_wrong_cell_is_rejected(right: str, wrong: str, tmp_path: Path) -> None:
    cells, module = sources(6, 1)
    assert right in cells
    with pytest.raises(QuadshadeError, match="proof did fail"):
        prove(cells.replace(right, wrong), module, tmp_path)
