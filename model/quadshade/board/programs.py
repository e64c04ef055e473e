# SPDX-License-Identifier: Apache-2.0
"""The whole board (``rtl/board.vhd``) as a program that talks through its UART pins."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from quadshade.engine.ghdl import analyse
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import tool_command
from quadshade.engine.verilator import compile_netlist

TOP = "board"
TESTBENCH = "board_tb"


def verilator_board(generics: Mapping[str, int], kept: Path | None = None) -> list[str]:
    """
    The board's netlist in Verilator, compiled once for each set of generics.

    Parameters
    ----------
    generics : mapping of str to int
      Of the entity ``board``.
    kept : Path, optional
      As for :func:`quadshade.engine.verilator.compile_netlist`.

    Returns
    -------
    list of str
      The command; ``sim/verilator/board_main.cpp`` says what it reads and writes.

    Raises
    ------
    QuadshadeError
      A tool is missing or fails, or generics that the board refuses.
    """
    program = compile_netlist(TOP, generics, "the board", kept=kept)
    return [str(program), str(generics["clk_frequency_hz"]), str(generics["baud"])]


def ghdl_board(generics: Mapping[str, int]) -> list[str]:
    """
    The board's VHDL in GHDL, within ``sim/board_tb.vhd``, which says what it reads and writes.

    Parameters
    ----------
    generics : mapping of str to int
      Of the entity ``board``.

    Returns
    -------
    list of str
      The command; it leaves files in the folder in which it runs.

    Raises
    ------
    QuadshadeError
      GHDL is missing, or the sources have an error.
    """
    library = analyse(repository_root(), TESTBENCH)
    command = [*tool_command("GHDL"), "--elab-run", "--std=08", f"--workdir={library}", TESTBENCH]
    command += [f"-g{name}={value}" for name, value in generics.items()]
    return [*command, "--ieee-asserts=disable"]
