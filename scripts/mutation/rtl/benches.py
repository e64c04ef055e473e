# SPDX-License-Identifier: Apache-2.0
"""What a unit is tested by: the simulations of its own bench, and the units above it with theirs."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import inspect
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from cocotb_tests.support.simulation import identifier, module_of

ROOT = Path(__file__).resolve().parents[3]
BENCHES = ROOT / "cocotb_tests"
GENERATED = "generated"


@dataclass(frozen=True)
class Case:
    """
    One simulation of a bench.

    Attributes
    ----------
    unit : str
      The entity.
    module : str
      Of the cocotb tests.
    config : str
      The bench's configuration, as JSON.
    label : str
      What differs from the configuration's defaults.
    generics : tuple of pairs
    """

    unit: str
    module: str
    config: str
    label: str
    generics: tuple[tuple[str, int], ...]

    @property
    def name(self) -> str:
        return f"{self.module.rpartition('test_')[2]}[{self.label}]"


def rtl_paths() -> dict[str, Path]:
    """The file of every unit that is written by hand."""
    paths = sorted((ROOT / "rtl").rglob("*.vhd"))
    return {path.stem: path for path in paths if path.parent.name != GENERATED}


@cache
def used_by() -> dict[str, set[str]]:
    """The units that name a unit, package or entity, in their text."""
    users: dict[str, set[str]] = {name: set() for name in rtl_paths()}
    for name, path in rtl_paths().items():
        for used in re.findall(r"\bwork\.(\w+)", re.sub(r"--.*", "", path.read_text())):
            if used in users and used != name:
                users[used].add(name)
    return users


def above(unit: str) -> list[str]:
    """Every unit that holds a unit, the nearest first."""
    found: list[str] = []
    layer = {unit}
    while layer := {user for name in layer for user in used_by()[name]} - set(found):
        found += sorted(layer)
    return found


def _modules(unit: str) -> list[Path]:
    """Test files of which some simulation is of a unit: its own, and those that name it."""
    paths = []
    for path in sorted(BENCHES.rglob("test_*.py")):
        if path.stem == f"test_{unit}" or f'simulate("{unit}"' in path.read_text():
            paths.append(path)
    return paths


def cases_of(unit: str) -> list[Case]:
    """
    The simulations that a unit's bench makes of its VHDL, as its pytest functions ask for them.

    Returns
    -------
    list of Case
      None for a package, which has no bench.
    """
    cases: list[Case] = []
    for path in _modules(unit):
        name = f"cocotb_tests.{path.parent.name}.{path.stem}"
        module = importlib.import_module(name)

        def record(
            unit: str,
            config: Any,
            generics: dict[str, int] | None = None,
            verilog: list[Path] | None = None,
            tests: str | None = None,
        ) -> None:
            if verilog:
                return
            chosen = dataclasses.asdict(config) if generics is None else generics
            given = json.dumps(dataclasses.asdict(config))
            label = identifier(config)
            cases.append(Case(unit, module_of(tests or unit), given, label, tuple(chosen.items())))

        for function, config in _calls(module):
            kept, function.__globals__["simulate"] = function.__globals__["simulate"], record
            try:
                function(config)
            finally:
                function.__globals__["simulate"] = kept
    return [case for case in cases if case.unit == unit]


def _calls(module: Any) -> Iterator[tuple[Any, Any]]:
    """The pytest functions of a bench that take a configuration and nothing else, with each of theirs."""
    for name, function in inspect.getmembers(module, inspect.isfunction):
        marks = [mark for mark in getattr(function, "pytestmark", []) if mark.args[:1] == ("config",)]
        if name.startswith("test_") and marks and list(inspect.signature(function).parameters) == ["config"]:
            yield from ((function, config) for config in marks[0].args[1])


@cache
def _text_of(path: Path) -> tuple[Path, ...]:
    """A file and what it imports of the tests, however far."""
    found = {path: None}
    for name in re.findall(
        r"^ *from ((?:cocotb_tests|tests)\.[\w.]+) import", path.read_text(), re.MULTILINE
    ):
        found |= dict.fromkeys(_text_of(ROOT / f"{name.replace('.', '/')}.py"))
    return tuple(found)


@cache
def digest(unit: str) -> str:
    """
    Hash of what a bench is made of: its own text, and that of the tests' modules that it imports.

    The golden model is left out: a result that stands for one version of it stands for the next, whose
    clean run is checked before.
    """
    paths = {path for module in _modules(unit) for path in _text_of(module)}
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(paths))).hexdigest()[:12]
