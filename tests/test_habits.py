# SPDX-License-Identifier: Apache-2.0
"""The files for contributors: they parse, and what they name is there."""

from __future__ import annotations

import configparser
import fnmatch
import importlib.util
import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.contract.protocol import definition_hash
from quadshade.contract.releases import RELEASES, UNRELEASED, other_release, release_of
from quadshade.engine.environment import environment

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text()
WORKFLOW = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text())
HOOKS = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())


def targets() -> set[str]:
    """What the Makefile can make."""
    return set(re.findall(r"^([a-z][a-z-]*):", (ROOT / "Makefile").read_text(), re.MULTILINE))


def commands() -> list[list[str]]:
    """Lines of CONTRIBUTING's blocks, as words."""
    return [shlex.split(line) for line in re.findall(r"^(?: {4}| {7})(\S.*)$", CONTRIBUTING, re.MULTILINE)]


def test_contributing_names_what_exists() -> None:
    assert len(commands()) > 20
    for program, *words in commands():
        if program == "make":
            assert {word for word in words if "=" not in word} <= targets(), words
        else:
            assert program == "git" or (ROOT / program).exists(), program
        for word in words:
            assert not re.match(r"(tests|model|rtl|synth|docs)/", word) or (ROOT / word).exists(), word


def test_contributing_paths_exist() -> None:
    # A unit and a board that are only an example are not there.
    named = set(re.findall(r"`((?:rtl|model|tests|formal|synth|docs|cocotb_tests)/[^`]+)`", CONTRIBUTING))
    named = {name for name in named if "my_unit" not in name and "my-board" not in name}
    assert len(named) > 8
    assert not [name for name in named if not any(ROOT.glob(name))]


def test_selections_of_contributing_select_something() -> None:
    names = {str(path.relative_to(ROOT)) for path in ROOT.glob("*tests/**/test_*.py")}
    for program, *words in commands():
        for word in words:
            if program == "make" and word.startswith("T=") and words[0] != "formal" and "my_unit" not in word:
                assert any(word.removeprefix("T=") in name for name in names), word


def test_hooks_run_what_is_installed() -> None:
    hooks = {hook["id"]: hook for repository in HOOKS["repos"] for hook in repository["hooks"]}
    assert set(hooks) == {"ruff-check", "ruff-format", "mypy", "codespell", "hygiene"}
    assert {repository["repo"] for repository in HOOKS["repos"]} == {"local"}, "a hook needs the network"
    for hook in hooks.values():
        python, option, module, *_ = shlex.split(hook["entry"])
        assert (python, option) == (".venv/bin/python", "-m")
        assert importlib.util.find_spec(module), module


def test_hooks_are_valid(tmp_path: Path) -> None:
    command = [ROOT / ".venv" / "bin" / "pre-commit", "validate-config", ROOT / ".pre-commit-config.yaml"]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr


def test_hygiene_hook_selects_tests() -> None:
    (entry,) = (hook["entry"] for hook in HOOKS["repos"][0]["hooks"] if hook["id"] == "hygiene")
    _, _, *pytest_words = shlex.split(entry)
    selection = pytest_words[pytest_words.index("-k") + 1]
    tests = re.findall(r"^def test_(\w+)", (ROOT / "tests" / "test_lint.py").read_text(), re.MULTILINE)
    for word in selection.split(" or "):
        assert any(word in name for name in tests), word


def test_workflow_runs_targets() -> None:
    jobs = WORKFLOW["jobs"]
    assert set(jobs) == {"test", "netlist"}
    matrix = jobs["test"]["strategy"]["matrix"]["include"]
    assert [entry["name"] for entry in matrix] == ["lint", "model", "cocotb", "docs"]
    runs = [entry["command"] for entry in matrix]
    runs += [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]
    made = [shlex.split(line)[1:] for line in runs if line.startswith("make")]
    assert ["test-netlist"] in made and ["setup"] in made
    for words in made:
        assert {word for word in words if "=" not in word} <= targets(), words
        for folders in (word.removeprefix("TESTS=") for word in words if word.startswith("TESTS=")):
            assert all((ROOT / folder).is_dir() for folder in folders.split())
    # A nightly run and a push each run their own jobs: yaml reads the key `on` as true.
    assert {"push", "pull_request", "schedule"} == set(WORKFLOW[True])


def test_matrix_runs_every_folder_of_tests() -> None:
    options = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["pytest"]["ini_options"]
    commands_run = " ".join(
        entry["command"] for entry in WORKFLOW["jobs"]["test"]["strategy"]["matrix"]["include"]
    )
    assert all(folder in commands_run for folder in options["testpaths"])


def test_bug_report_asks_for_info() -> None:
    text = (ROOT / ".github" / "ISSUE_TEMPLATE" / "bug_report.md").read_text()
    _, front, body = text.split("---\n", 2)
    assert set(yaml.safe_load(front)) == {"name", "about", "labels"}
    assert "`quadshade info`" in body


def test_info_without_a_port_says_what_runs_here() -> None:
    result = CliRunner().invoke(main, ["info"], env={"QUADSHADE_PORT": ""})
    assert result.exit_code == 0, result.output
    said = dict(line.split(maxsplit=1) for line in result.output.splitlines())
    assert said.keys() >= {"quadshade", "python", "platform", "ghdl", "verilator", "c++", "numba", "engine"}
    assert said["quadshade"].endswith(f"definition {definition_hash():08x}")
    assert "GHDL" in said["ghdl"]


def test_info_names_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VERILATOR", "/nowhere/verilator")
    monkeypatch.setenv("CXX", "env g++ -m64")
    said = environment()
    assert said["verilator"] == "VERILATOR is '/nowhere/verilator': /nowhere/verilator is not installed"
    assert said["c++"].startswith("g++")


def test_info_refuses_options_of_a_port() -> None:
    result = CliRunner().invoke(main, ["info", "--trace"], env={"QUADSHADE_PORT": ""})
    assert result.exit_code == 2
    assert "--trace without --port; give the port of a board" in result.output


def test_editorconfig_agrees_with_the_lint() -> None:
    reader = configparser.ConfigParser()
    reader.read_string("[top]\n" + (ROOT / ".editorconfig").read_text())
    assert reader["top"]["root"] == "true"
    everything = reader["*"]
    ruff = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["ruff"]
    assert int(everything["max_line_length"]) == ruff["line-length"]
    assert everything["insert_final_newline"] == everything["trim_trailing_whitespace"] == "true"
    assert everything["indent_style"] == "space" and reader["{Makefile,*.mk}"]["indent_style"] == "tab"
    assert fnmatch.fnmatch("model.py", "*.py") and reader["*.{py,cpp}"]["indent_size"] == "4"


def test_version_is_a_release_with_its_definition() -> None:
    """HELLO carries the definition, which says the release: one table ties it to pyproject's version."""
    assert list(RELEASES)[-1] == PROJECT["version"], "enter the version in contract/releases.py"
    assert f"{UNRELEASED or RELEASES[PROJECT['version']]:08x}" == f"{definition_hash():08x}", (
        "formats, packet layout or protocol changed: boards have to be built anew, so enter the hash"
    )
    assert UNRELEASED not in RELEASES.values(), "it is that of a release: enter None"
    assert f"\n## {PROJECT['version']} - " in (ROOT / "CHANGELOG.md").read_text()


def test_another_release_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quadshade.contract.releases.RELEASES", RELEASES | {"0.3.0": 7, "0.3.1": 7})
    assert release_of(7) == "release 0.3.0 or 0.3.1"
    assert other_release("the board", 7).startswith(
        "the board is of release 0.3.0 or 0.3.1 (00000007), this is"
    )
    assert release_of(8) == "no known release"
    monkeypatch.setattr("quadshade.contract.releases.RELEASES", {})
    assert release_of(definition_hash()) == "this checkout"


def test_changelog_has_a_line_a_change() -> None:
    entries = (ROOT / "CHANGELOG.md").read_text().split("\n## ")[1:]
    assert entries[0].startswith("Unreleased\n")
    for line in "\n".join(entries).splitlines():
        assert not line.startswith("  "), f"a change of more than one line: {line}"
