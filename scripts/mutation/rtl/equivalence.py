# SPDX-License-Identifier: Apache-2.0
"""
Whether a mutant's hardware does what the unit's does: Yosys' temporal induction over both netlists.

Registers of one name, the outputs, and what each hands to the units in it, are equal in the first cycles
after power-up, and in every cycle after such in which they were. Units in it that both sides have are cut
out. Each of the bench's configurations of generics is a proof of its own.
"""

from __future__ import annotations

import re
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from quadshade.engine.netlist import repair_constants
from quadshade.engine.tool_runner import tool_command
from quadshade.synthesis.flow import RUN_SCRIPT
from scripts.mutation.rtl.benches import Case
from scripts.mutation.rtl.simulate_case import VhdlBuild

STEPS = 2
"""Cycles in which the registers are equal: assumed in the induction, shown from power-up on."""
SECONDS, WALL_SECONDS = 30, 120
"""Of the first cycles' proof, and of all of Yosys' work in an attempt, after which it counts as vain."""
PROVED = ("Equivalence successfully proven!", "Reached maximum number of time steps -> proved base case")
"""What Yosys says after the induction and after the first cycles."""
_MODULE = re.compile(r"^module (\w+)\b.*?^endmodule\n", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Attempt:
    """Whether units in the unit are compared too, and whether only registers are, or all signals."""

    whole: bool
    registers_only: bool


ATTEMPTS = (Attempt(False, True), Attempt(False, False), Attempt(True, True))


def netlist_of(build: VhdlBuild, case: Case) -> str:
    """GHDL's netlist of a case's unit as its files are now; empty if it has none."""
    command = [*tool_command("GHDL"), "--synth", "--std=08", "--no-formal", "--out=verilog"]
    command += [*(f"-g{name}={value}" for name, value in case.generics), case.unit]
    done = subprocess.run(command, cwd=build.folder, capture_output=True, text=True, check=False)
    return repair_constants(done.stdout) if done.returncode == 0 else ""


def _modules(verilog: str) -> dict[str, str]:
    return {match[1]: match[0] for match in _MODULE.finditer(verilog)}


def _numbered(text: str, side: str, registers_only: bool) -> str:
    """A module's text in which nothing has the other side's name by chance, or though it is no register."""
    text = re.sub(r"\bn(\d+_[a-z0-9]+)\b", rf"{side}_n\1", text)
    if registers_only:
        body = text.partition(");\n")[2]
        inner = set(re.findall(r"^  (?:wire|reg) (?:\[[^\]]*\] )?(\w+);", body, re.MULTILINE))
        inner -= set(re.findall(rf"\b(\w+) <?= {side}_n\d+_q;", body))
        text = re.sub(
            r"(?<!\.)\b\w+\b", lambda word: f"{side}_{word[0]}" if word[0] in inner else word[0], text
        )
    return text


def _own(modules: dict[str, str], unit: str, side: str, attempt: Attempt) -> list[str]:
    """Texts of one side's modules, with the unit under the side's name."""
    names = {unit: side}
    if attempt.whole:
        names |= {name: f"{side}_{name}" for name in modules if name != unit}
    chosen = modules.values() if attempt.whole else [modules[unit]]
    pattern = re.compile(r"(?<=^module )\w+|(?<=^  )\w+(?= \w+ \()", re.MULTILINE)
    named = [pattern.sub(lambda word: names.get(word[0], word[0]), text) for text in chosen]
    return [_numbered(text, side, attempt.registers_only) for text in named]


def script(gold: str, gate: str, unit: str, attempt: Attempt) -> tuple[str, list[str]]:
    """
    A Verilog file with both units, and Yosys' commands that compare them.

    Parameters
    ----------
    gold, gate : str
      Netlists of the clean and of the mutated unit.
    unit : str
    attempt : Attempt
    """
    first, second = _modules(gold), _modules(gate)
    texts = [*_own(first, unit, "gold", attempt), *_own(second, unit, "gate", attempt)]
    parts = {} if attempt.whole else {name: text for name, text in (second | first).items() if name != unit}
    commands = ["read_verilog both.v", *(f"blackbox {name}" for name in parts), "hierarchy"]
    commands += ["proc", "flatten", "opt_clean", "memory -nomap", "memory_map", "opt_expr", "opt_clean"]
    commands += [f"setundef -zero {'' if parts else '-undriven '}-init gold gate"]
    skip = "-ignore-unknown-cells"
    commands += ["design -save sides", "equiv_make gold gate equiv", "hierarchy -top equiv", "opt_merge"]
    commands += [f"equiv_simple {skip}", f"equiv_induct -seq {STEPS} {skip}", "equiv_status -assert"]
    commands += ["design -load sides", "equiv_make -make_assert gold gate equiv", "hierarchy -top equiv"]
    commands += [f"delete equiv/t:{name}" for name in parts]
    commands += [
        "opt_clean", "opt_merge",
        f"sat -tempinduct -tempinduct-baseonly -prove-asserts -maxsteps {STEPS} -timeout {SECONDS} equiv",
    ]  # fmt: skip
    return "\n".join([*texts, *parts.values()]), commands


def proved(gold: str, gate: str, unit: str, folder: Path) -> bool:
    """Whether two netlists of a unit are shown to be equivalent; False does not say that they differ."""
    if gold == gate:
        return True
    folder.mkdir(parents=True, exist_ok=True)
    for number, attempt in enumerate(ATTEMPTS):
        text, commands = script(gold, gate, unit, attempt)
        (folder / "both.v").write_text(text)
        (folder / "script.ys").write_text("\n".join(commands) + "\n")
        log = folder / f"log{number}.txt"
        with log.open("w") as out, suppress(subprocess.TimeoutExpired):
            command = [sys.executable, "-c", RUN_SCRIPT, "script.ys"]
            subprocess.run(command, cwd=folder, stdout=out, stderr=out, check=False, timeout=WALL_SECONDS)
        if all(words in log.read_text() for words in PROVED):
            return True
    return False
