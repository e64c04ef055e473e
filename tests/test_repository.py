# SPDX-License-Identifier: Apache-2.0
"""What the repository says about itself holds: targets, commands, pins, and the set-up's refusals."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import distribution, entry_points, version
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from tests.support.pages import ROOT, documented_commands, pages

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
OLDEST = "3.11.2"
"""The Python of Debian 12."""


def make_targets() -> set[str]:
    """Targets that the Makefile declares phony: those that are meant to be typed."""
    declared = re.findall(r"^\.PHONY: (.+)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    return set(" ".join(declared).split())


def command_line() -> click.Group:
    """The click group behind the console script."""
    (script,) = entry_points(group="console_scripts", name="quadshade")
    module = sys.modules[script.load().__module__]
    (group,) = (value for value in vars(module).values() if isinstance(value, click.Group))
    return group


@pytest.mark.parametrize("goal", [(), ("help",)], ids=["default", "help"])
def test_help_lists_every_target(goal: tuple[str, ...]) -> None:
    result = subprocess.run(["make", *goal], cwd=ROOT, capture_output=True, text=True, check=True)
    assert set(re.findall(r"^  make ([\w-]+) +\S", result.stdout, re.MULTILINE)) == make_targets()


def test_documented_targets_exist() -> None:
    commands = documented_commands("make")
    assert ["demo"] in commands
    assert {word for words in commands for word in words if "=" not in word} <= make_targets()


def test_documented_commands_exist() -> None:
    group = command_line()
    commands = documented_commands("quadshade")
    assert {"render", "raster", "compare"} <= {words[0] for words in commands}
    for words in commands:
        command = group.get_command(None, words[0])
        assert command is not None, words
        parameters = command.params
        options = {name for option in parameters for name in (*option.opts, *option.secondary_opts)}
        given = {word.split("=")[0] for word in words[1:] if re.match(r"--?[a-z]", word)}
        assert given <= options | {"--help"}, words


def test_the_help_shows_every_command_in_a_whole_sentence() -> None:
    group = command_line()
    shown = CliRunner().invoke(group, ["--help"]).output.partition("Commands:")[2]
    for name in group.commands:
        assert re.search(rf"^  {name} +[A-Z].*[a-z)]\.$", shown, re.MULTILINE), name
    assert "..." not in shown


def test_pages_and_reports_have_titles_of_their_own() -> None:
    titles = [
        line
        for page in sorted((ROOT / "docs").rglob("*.md"))
        for line in page.read_text().splitlines()[:4]
        if line.startswith("# ")
    ]
    assert len(titles) > 40 and len(set(titles)) == len(titles)


def test_documented_links_lead_somewhere() -> None:
    broken = [
        f"{page.relative_to(ROOT)}: {target}"
        for page in pages()
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text())
        if "://" not in target and not (page.parent / target).exists()
    ]
    assert not broken, "\n" + "\n".join(broken)


def test_readme_shows_what_was_measured() -> None:
    command = [sys.executable, "-m", "scripts.readme", "--check"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def test_installed_version_is_the_projects() -> None:
    assert version("quadshade") == PROJECT["version"]


def pinned() -> dict[str, str]:
    """Versions of ``requirements.txt`` by name, in small letters."""
    pins = {}
    for line in (ROOT / "requirements.txt").read_text().splitlines():
        if not line.startswith("#"):
            requirement = Requirement(line)
            (specifier,) = requirement.specifier
            assert specifier.operator == "==", line
            pins[requirement.name.lower()] = specifier.version
    return pins


def test_every_dependency_is_pinned() -> None:
    pins = pinned()
    wanted = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["dev"]]
    for requirement in map(Requirement, wanted):
        assert requirement.specifier.contains(pins[requirement.name.lower()]), requirement


def test_every_pin_is_for_the_python_of_debian_12() -> None:
    asked = {name: distribution(name).metadata.get("Requires-Python", "") for name in pinned()}
    assert len(asked) > 50
    assert [name for name, python in asked.items() if OLDEST not in SpecifierSet(python)] == []


def install_tools(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """The set-up script with nothing on its path but what lies in a folder."""
    return subprocess.run(
        ["/bin/bash", ROOT / "scripts" / "install_tools.sh"],
        env={"PATH": str(folder), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_setup_refuses_an_old_python(tmp_path: Path) -> None:
    old = tmp_path / "old"
    old.write_text('#!/bin/sh\n[ "$1" = --version ] && echo "Python 3.9.2"\n[ "$1" = --version ]\n')
    old.chmod(0o755)
    result = install_tools(tmp_path, PYTHON=str(old))
    assert result.returncode == 2
    assert result.stderr.startswith("setup: error: Python 3.9.2 is too old; ")
    assert len(result.stderr.splitlines()) == 1


def test_setup_without_apt_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "python3").symlink_to(sys.executable)
    result = install_tools(tmp_path)
    assert result.returncode == 2
    wanted = "install ghdl-llvm verilator g++ iverilog chromium chromium-driver by hand"
    assert result.stderr == f"setup: error: there is no apt-get; {wanted}\n"
    assert result.stdout == ""


def test_ci_runs_the_tests() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert re.search(r"^make .*\btest\b", script.read_text(), re.MULTILINE)
