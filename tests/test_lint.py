# SPDX-License-Identifier: Apache-2.0
"""Style and layout of the repository, and that the RTL analyses and synthesises without a warning."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from quadshade.engine.tool_runner import tool_command

ROOT = Path(__file__).resolve().parents[1]
GHDL = tool_command("GHDL")
TOPS = {"raster_core": (), "render_core": ("-gwith_shade=1", "-gnum_channels=4", "-gnum_specular=2")}
MAX_LINES = 400
MAX_COLUMNS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["ruff"]["line-length"]
MAX_HEADER_LINES = 15
SPDX = "SPDX-License-Identifier: Apache-2.0"


def run(*command: str | Path, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False
    )


def tracked_files() -> list[Path]:
    """Text files in the repository, without LICENSE (its text is not ours)."""
    names = run("git", "ls-files", "-z").stdout.split("\0")
    assert "Makefile" in names, "not a git work tree"
    paths = [ROOT / name for name in names if name and name != "LICENSE"]
    return [path for path in paths if path.is_file() and b"\0" not in path.read_bytes()]


def is_code(path: Path) -> bool:
    """Whether a file is written by hand in a language that has comments."""
    return path.suffix in (".py", ".vhd", ".sh", ".cpp", ".sv", ".v", ".toml", ".f", ".mk") or path.name in (
        "Makefile",
        "requirements.txt",
        "run",
    )


def rtl_files() -> list[Path]:
    """What ``rtl/files.f`` lists, bottom-up."""
    lines = (ROOT / "rtl" / "files.f").read_text().splitlines()
    return [ROOT / line for line in lines if line and not line.startswith("#")]


def rtl_entities() -> set[str]:
    """Stems of the RTL's entities: all files but the packages."""
    return {path.stem for path in (ROOT / "rtl").rglob("*.vhd") if not path.stem.endswith("_pkg")}


def faults(path: Path) -> list[str]:
    """What is wrong with a file's text, a line each."""
    data = path.read_bytes()
    lines = data.decode().split("\n")
    name = path.relative_to(ROOT)
    found = []
    if data and not data.endswith(b"\n"):
        found.append(f"{name}: no newline at the end")
    if data.endswith(b"\n\n"):
        found.append(f"{name}: blank lines at the end")
    for number, line in enumerate(lines, start=1):
        if "\t" in line and path.name != "Makefile" and path.suffix != ".mk":
            found.append(f"{name}:{number}: tab")
        if line != line.rstrip():
            found.append(f"{name}:{number}: blanks at the end of the line")
        if is_code(path) and len(line) > MAX_COLUMNS:
            found.append(f"{name}:{number}: {len(line)} columns, {MAX_COLUMNS} allowed")
    if is_code(path):
        if len(lines) - 1 >= MAX_LINES:
            found.append(f"{name}: {len(lines) - 1} lines, fewer than {MAX_LINES} allowed")
        first = lines[1] if lines[0].startswith("#!") else lines[0]
        if not first.endswith(SPDX):
            found.append(f"{name}: the first line is not the SPDX line")
    return found


def test_ruff_check() -> None:
    result = run(sys.executable, "-m", "ruff", "check", ".")
    assert result.returncode == 0, result.stdout


def test_ruff_format() -> None:
    result = run(sys.executable, "-m", "ruff", "format", "--check", ".")
    assert result.returncode == 0, result.stdout


def test_types() -> None:
    """All of ``model`` passes mypy, as pyproject.toml sets it."""
    result = run(sys.executable, "-m", "mypy")
    assert result.returncode == 0, result.stdout


def test_spelling() -> None:
    """Over the tracked files: what is built, and pictures, hold no words."""
    names = [str(path) for path in tracked_files()]
    result = run(sys.executable, "-m", "codespell_lib", *names)
    assert result.returncode == 0, result.stdout + result.stderr


def test_file_hygiene() -> None:
    found = [fault for path in tracked_files() for fault in faults(path)]
    assert not found, "\n" + "\n".join(found)


def test_hygiene_finds_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[__name__], "ROOT", tmp_path)
    bad = tmp_path / "bad.py"
    bad.write_text("x = 1 \n\ty\n" + "z" * (MAX_COLUMNS + 1) + "\n" * 400 + "end")
    found = " ".join(faults(bad))
    for fault in (
        "no newline",
        "bad.py:2: tab",
        "bad.py:1: blanks",
        f"{MAX_COLUMNS + 1} columns",
        "fewer than",
        "SPDX",
    ):
        assert fault in found


@pytest.mark.parametrize("stem", sorted(rtl_entities()))
def test_vhdl_header(stem: str) -> None:
    (path,) = (ROOT / "rtl").rglob(f"{stem}.vhd")
    text = path.read_text()
    header = re.match(r"(--.*\n)*", text)[0]
    assert len(header.splitlines()) <= MAX_HEADER_LINES
    assert f"Model: {stem}.py." in header
    assert f"Test: test_{stem}.py." in header
    assert re.search(r"Latency: \S", header)


def folders_of(root: Path, prefix: str = "") -> dict[str, str]:
    """The folder below a root of every Python file, by the file's stem without a prefix."""
    files = (path for path in root.rglob(f"{prefix}*.py") if path.name != "__init__.py")
    return {path.stem.removeprefix(prefix): str(path.parent.relative_to(root)) for path in files}


def test_layout_stems() -> None:
    """An entity, its model, its test and its row in a README lie in folders of the same name."""
    units = {path.stem: str(path.parent.relative_to(ROOT / "rtl")) for path in rtl_files()}
    entities = {stem: folder for stem, folder in units.items() if stem in rtl_entities()}
    models = folders_of(ROOT / "model" / "quadshade" / "golden")
    tests = folders_of(ROOT / "cocotb_tests", "test_")
    # A board's test is beside those of the tops in synth/boards.
    homes = entities | {stem: "boards" for stem, folder in entities.items() if folder == "."}
    assert {stem: models.get(stem) for stem in entities} == entities, "no model in golden's same folder"
    assert {stem: tests.get(stem) for stem in homes} == homes, "no test in cocotb_tests' same folder"
    rows = [
        (row, str(page.parent.relative_to(ROOT / "rtl")))
        for page in (ROOT / "rtl").rglob("README.md")
        for row in re.findall(r"^\| `(\w+)` \|", page.read_text(), re.MULTILINE)
    ]
    assert sorted(rows) == sorted(units.items()), "rows of rtl/*/README.md against the files beside them"


@pytest.mark.parametrize(
    "root",
    [
        *("rtl", "cocotb_tests", "formal", "model/quadshade", "synth", "sim", "tests"),
        *("scripts", "scripts/experiments"),
    ],
)
def test_folders_say_what_is_in_them(root: str) -> None:
    """The README of a folder has a row for each folder in it, and rows only for what is there."""
    home = ROOT / root
    rows = re.findall(r"^\| (.+?) \|", (home / "README.md").read_text(), re.MULTILINE)
    names = {name for row in rows for name in re.findall(r"`([\w.*]+)`", row)}
    folders = {
        path.relative_to(home).parts[0] for path in tracked_files() if path.parent.is_relative_to(home)
    }
    folders = {name for name in folders if (home / name).is_dir()}
    assert folders - names == set(), "folders without a row"
    gone = [name for name in names if not any(home.glob(name)) and not (home / f"{name}.vhd").is_file()]
    assert not gone, "rows without a file"


def test_file_list_is_complete() -> None:
    listed = rtl_files()
    assert len(listed) == len(set(listed))
    assert set(listed) == set((ROOT / "rtl").rglob("*.vhd"))


def test_generated_package_is_current() -> None:
    result = run(sys.executable, "-m", "scripts.generate_vhdl", "--check")
    assert result.returncode == 0, result.stderr


def test_port_tables_are_current() -> None:
    result = run(sys.executable, "-m", "scripts.docs.ports", "--check")
    assert result.returncode == 0, result.stderr


def test_vhdl_style(tmp_path: Path) -> None:
    """The RTL keeps the rules of vsg that ``rtl/vsg.yaml`` does not leave out; a broken one is found."""
    vsg, settings = Path(sys.executable).with_name("vsg"), ROOT / "rtl" / "vsg.yaml"
    result = run(vsg, "-c", settings, "-of", "syntastic", "-f", *rtl_files())
    assert result.returncode == 0, result.stdout
    bad = tmp_path / "bad.vhd"
    good = (ROOT / "rtl" / "core" / "setup_loader.vhd").read_text()
    bad.write_text(good.replace("process (", "PROCESS ("))
    result = run(vsg, "-c", settings, "-of", "syntastic", "-f", bad)
    assert result.returncode == 1 and "process_005" in result.stdout


def test_rtl_analyses_and_synthesises(tmp_path: Path) -> None:
    options = ["--std=08", f"--workdir={tmp_path}"]
    # In the order of files.f, which is therefore bottom-up.
    analysis = run(*GHDL, "-a", "-Werror", *options, *rtl_files(), cwd=tmp_path)
    assert analysis.returncode == 0, analysis.stderr
    assert analysis.stderr == ""
    for top, generics in TOPS.items():
        command = (*GHDL, "--synth", "-Werror", *options, *generics, "--out=verilog", top)
        synthesis = run(*command, cwd=tmp_path)
        assert synthesis.returncode == 0, synthesis.stderr
        assert f"module {top}" in synthesis.stdout
