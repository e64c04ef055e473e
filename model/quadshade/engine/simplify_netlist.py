# SPDX-License-Identifier: Apache-2.0
"""
GHDL's Verilog in a form that Verilator makes faster programs of; the registers hold the same.

GHDL writes a register with an enable as a wire that chooses between the new value and the old one, every
signal with an initial value as a register of its own that follows another, and bits that depend on each other
in a row as one vector, which Verilator takes for a loop; it chooses between several values by delayed
assignments. Together they cost almost half of the speed. Text in
which none of this is found stays as it is.
"""

from __future__ import annotations

import re
from collections import Counter

_FOLLOWER = re.compile(r"always @\*\n    (\w+) = (\w+); // \(isignal\)\n  initial\n    \1 <= [^;]*;\n")
_REGISTER = re.compile(r"always @\(posedge (\w+)\)\n    (\w+) <= (\w+);\n")
_CHOICE = re.compile(r"(\w+) \? ([\w']+) : (\w+)")
_CHOOSER = re.compile(r"always @\*\n    case \(.*?\n    endcase\n", re.DOTALL)
_ROW = re.compile(r"assign (\w+) = \{([\w, \n]+)\};")


def fold_followers(module: str) -> str:
    """A signal that always has a register's value becomes a wire."""
    names = {match[1] for match in _FOLLOWER.finditer(module)}
    module = _FOLLOWER.sub(r"assign \1 = \2; // (signal)\n", module)
    return re.sub(
        r"^  reg ((?:\[\d+:\d+\] )?(\w+));",
        lambda match: f"  {'wire' if match[2] in names else 'reg'} {match[1]};",
        module,
        flags=re.MULTILINE,
    )


def _fold_enables(module: str) -> str:
    """A register's next value, used nowhere else, goes to the register; its own value becomes an enable."""
    used = Counter(re.findall(r"\w+", module))
    values = dict(re.findall(r"assign (\w+) = ([^;]*);", module))

    def fold(match: re.Match[str]) -> str:
        clock, register, following = match.groups()
        # Declared, assigned, and taken by this register.
        if used[following] != 3 or following not in values:
            return match[0]
        choice = _CHOICE.fullmatch(values[following])
        if choice and register in (choice[3], values.get(choice[3])):
            return f"always @(posedge {clock})\n    if ({choice[1]}) {register} <= {choice[2]};\n"
        return f"always @(posedge {clock})\n    {register} <= {values[following]};\n"

    return _REGISTER.sub(fold, module)


def _fold_choosers(module: str) -> str:
    """A choice between several values, which GHDL assigns as if it were a register, takes them at once."""
    return _CHOOSER.sub(lambda match: match[0].replace(" <= ", " = "), module)


def _fold_rows(module: str) -> str:
    """Bits that are put together only to be taken apart stay single."""
    single = set(re.findall(r"^ +\(?(?:wire|reg|input +|output) (\w+)[;,)]", module, flags=re.MULTILINE))
    for row, text in _ROW.findall(module):
        bits = re.findall(r"\w+", text)
        copy = re.search(rf"assign (\w+) = {row};", module)
        if not copy or not single.issuperset(bits):
            continue
        taken = re.findall(rf"\b{copy[1]}\b(\[\d+\])?", module)
        # Beside single bits there are its declaration and its assignment.
        if taken.count("") == 2:

            def single_bit(index: re.Match[str], bits: list[str] = bits) -> str:
                return bits[-1 - int(index[1])]

            module = re.sub(rf"\b{copy[1]}\[(\d+)\]", single_bit, module)
    return module


def fold(verilog: str) -> str:
    """
    The same circuit, written for a simulator.

    Parameters
    ----------
    verilog : str
      A netlist by GHDL.

    Returns
    -------
    str
    """
    modules = re.split(r"^(?=module )", verilog, flags=re.MULTILINE)
    return "".join(_fold_rows(_fold_choosers(_fold_enables(fold_followers(module)))) for module in modules)
