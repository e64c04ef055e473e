# SPDX-License-Identifier: Apache-2.0
"""Who may know whom: Python packages by imports, VHDL folders by what their units use and instantiate."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PRODUCT = ROOT / "model" / "quadshade"

LAYERS = (
    {"errors", "stale_loops"},
    {"contract"},
    {"choices", "files"},
    {"cluster", "golden", "image", "link", "scene", "setup"},
    {"engine", "packing", "shading"},
    {"fit"},
    {"adapt", "style", "synthesis"},
    {"board"},
    {"rendering", "trade"},
    {"animation", "view"},
    {"cli"},
)
"""The parts of the product, bottom-up; a part knows only those of the layers below it, and itself."""

NARROW = {"contract": {"errors", "stale_loops"}, "golden": {"contract", "errors"}}
"""Parts that know fewer than their layer allows: the golden model is the specification."""

RTL_KNOWS = {
    "generated": set(),
    "common": {"generated"},
    "core": {"generated", "common"},
    "shade": {"generated", "common", "core"},
    "link": {"generated", "common"},
    "screen": {"generated", "common"},
    ".": {"generated", "common", "core", "shade", "link", "screen"},
}
"""Folders of rtl/, and those whose packages and entities their units use; ``.`` is board.vhd."""


@cache
def imported(path: Path) -> tuple[str, ...]:
    """Every absolute module that a file imports, wherever in it; ``from a import b`` gives ``a.b`` too."""
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} has a relative import"
            names += [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(names)


def product_imports() -> Iterator[tuple[str, str, str]]:
    """File, its part of the product, and a part that it imports; the face and ``__main__`` know all."""
    parts = set().union(*LAYERS)
    for path in sorted(PRODUCT.rglob("*.py")):
        own = path.relative_to(PRODUCT).with_suffix("").parts[0]
        for name in imported(path):
            part = re.match(r"quadshade\.(\w+)", name)
            if own not in ("__init__", "__main__") and part and part[1] in parts - {own}:
                yield str(path.relative_to(PRODUCT)), own, part[1]


def test_every_part_has_a_layer() -> None:
    found = {path.name for path in PRODUCT.iterdir() if (path / "__init__.py").is_file()}
    found |= {path.stem for path in PRODUCT.glob("*.py")} - {"__init__", "__main__"}
    assert found == set().union(*LAYERS)


def test_the_product_imports_downwards() -> None:
    place = {part: index for index, layer in enumerate(LAYERS) for part in layer}
    upward = {f"{path} imports {part}" for path, own, part in product_imports() if place[part] >= place[own]}
    assert upward == set()


@pytest.mark.parametrize("own", NARROW)
def test_the_specification_knows_no_host(own: str) -> None:
    seen = [(path, part) for path, importer, part in product_imports() if importer == own]
    assert seen
    assert [f"{path} imports {part}" for path, part in seen if part not in NARROW[own]] == []


def test_the_product_knows_no_script_and_no_test() -> None:
    outside = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in PRODUCT.rglob("*.py")
        for name in imported(path)
        if name.split(".")[0] in ("scripts", "tests", "cocotb_tests", "conftest")
    ]
    assert outside == []


def test_experiments_import_the_product_as_a_user_would() -> None:
    """Neither a private name nor the command line's insides; and no product script needs an experiment."""
    wrong = []
    for path in sorted((ROOT / "scripts").rglob("*.py")):
        place = path.relative_to(ROOT / "scripts").parts
        for name in imported(path):
            private = re.match(r"quadshade\b.*\._(?!_version__)", name)
            command_line = place[0] == "experiments" and "tests" not in place and "quadshade.cli" in name
            experiment = place[0] != "experiments" and name.startswith("scripts.experiments")
            if private or command_line or experiment:
                wrong.append(f"{path.relative_to(ROOT)} imports {name}")
    assert wrong == []


def rtl_uses(path: Path) -> Iterator[str]:
    """The names after ``work.`` in a VHDL file, comments left out."""
    text = re.sub(r"--.*", "", path.read_text()).lower()
    yield from re.findall(r"\bwork\.(\w+)", text)


def rtl_units() -> dict[str, Path]:
    """The file of every package and entity of rtl/."""
    return {path.stem: path for path in (ROOT / "rtl").rglob("*.vhd")}


def test_rtl_folders_know_only_those_below() -> None:
    units, wrong = rtl_units(), []
    folders = {unit: str(path.parent.relative_to(ROOT / "rtl")) for unit, path in units.items()}
    assert set(folders.values()) == set(RTL_KNOWS)
    for unit, path in units.items():
        used = [folders[name] for name in rtl_uses(path) if name in folders]
        wrong += [
            f"{unit} in {folders[unit]} uses {folder}"
            for folder in used
            if folder != folders[unit] and folder not in RTL_KNOWS[folders[unit]]
        ]
    assert wrong == []
    # The reader sees what is there: the board has units of these folders.
    assert {folders[name] for name in rtl_uses(units["board"])} >= {"link", "screen", "shade"}


def test_the_list_of_rtl_files_is_bottom_up() -> None:
    """What a file uses stands before it in rtl/files.f, and nothing is used that is not there."""
    lines = (ROOT / "rtl" / "files.f").read_text().splitlines()
    listed = [ROOT / line for line in lines if line and not line.startswith("#")]
    assert set(listed) == set(rtl_units().values())
    before: set[str] = set()
    for path in listed:
        assert set(rtl_uses(path)) - {path.stem} <= before, path
        before.add(path.stem)
