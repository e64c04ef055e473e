# SPDX-License-Identifier: Apache-2.0
"""Yosys' proof that two Verilog modules are equal, for tests of cells and of mapping."""

from __future__ import annotations

from pathlib import Path

from quadshade.synthesis.flow import run_yosys


def prove_equal(
    unit: str, expected: str, cells: str, models: str, folder: Path, registers: bool = False
) -> None:
    """
    Prove that two modules give the same outputs, for all inputs.

    Parameters
    ----------
    unit : str
      The name of both modules.
    expected, cells : str
      Verilog of either.
    models : str
      Verilog of the cells that the second one is made of.
    folder : Path
      To work in.
    registers : bool
      The modules have registers, all of them outputs: proved by induction over the clocks.

    Raises
    ------
    QuadshadeError
      They differ, or Yosys fails.
    """
    for name, text in (("expected.v", expected), ("cells.v", cells), ("models.v", models)):
        (folder / name).write_text(text)
    commands = [
        "read_verilog expected.v",
        f"rename {unit} expected",
        "read_verilog models.v cells.v",
        "hierarchy",
        "proc",
        f"select {unit} expected",
        "flatten",
        "select -clear",
        f"miter -equiv -make_outputs {unit} expected both",
        "hierarchy -top both",
        "flatten",
        "opt",
        f"sat -verify {'-tempinduct ' if registers else ''}-prove trigger 0 both",
    ]
    run_yosys(commands, folder)
