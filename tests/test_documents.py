# SPDX-License-Identifier: Apache-2.0
"""
Every block of every page runs, in the page's order, from a copy of ``examples/``.

``quadshade`` runs in this process and any other command in a shell. ``make`` would install what is missing,
so make is only asked what it would run; the scripts behind its targets have tests of their own. A block that
needs hardware, a network or hours says why it is left out in a comment, ``<!-- not run: reason -->``.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.files.triangle_file import open_triangles
from quadshade.image import read_picture
from tests.support.pages import LANGUAGES, ROOT, Block, blocks, pages

REPORTS = ROOT / "docs" / "reports"
OWN_TEST = ROOT / "CONTRIBUTING.md"
"""Its blocks are typed at the top of a clone, and tests/test_habits.py checks them."""

CONSOLE = "import sys; from quadshade.cli.main import main; sys.argv[0] = 'quadshade'; main()"


def pages_with_blocks() -> list[Path]:
    """Pages that hold a block; reports are written by commands and hold none."""
    return [page for page in pages() if page not in (OWN_TEST, *REPORTS.iterdir()) and blocks(page)]


def environment() -> dict[str, str]:
    """This process' environment without an outer make, with the checkout's package and this Python first."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("MAKE", "MFLAGS"))}
    kept["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), kept["PATH"]])
    kept["PYTHONPATH"] = os.pathsep.join([str(ROOT / "model"), str(ROOT)])
    return kept


def run_quadshade(words: list[str]) -> tuple[int, str]:
    """Exit code and output of the command line, in this process."""
    result = CliRunner().invoke(main, words)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


def run_shell(command: str) -> tuple[int, str]:
    """Exit code and output of a command in a shell; make says what it would run."""
    if command.startswith("make "):
        command = f"make --dry-run --no-print-directory -C {shlex.quote(str(ROOT))} {command[5:]}"
    done = subprocess.run(
        ["/bin/bash", "-e", "-o", "pipefail", "-c", command],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    return done.returncode, done.stdout + done.stderr


def start(block: Block, started: list[subprocess.Popen]) -> None:
    """Start a block's only command in the background, and wait until its file is there."""
    (command,) = block.commands
    program, *words = shlex.split(command)
    assert program == "quadshade", f"{block.place}: only quadshade runs in the background"
    process = subprocess.Popen([sys.executable, "-c", CONSOLE, *words], env=environment())
    started.append(process)
    deadline = time.monotonic() + 60
    while not Path(block.background).exists():
        assert process.poll() is None, f"{block.place}: {command}: ended with {process.returncode}"
        assert time.monotonic() < deadline, f"{block.place}: {command}: no {block.background}"
        time.sleep(0.05)


def run_block(block: Block) -> None:
    """Run a block; a command that fails is named with its page, line and output."""
    if block.language == "python":
        code = compile("\n" * (block.line - 1) + block.code, block.place, "exec")
        exec(code, {"__name__": "__main__"})  # noqa: S102 - the page's own code
    elif block.language == "json":
        Path("block.json").write_text(block.code)
        if "triangles" in json.loads(block.code):
            open_triangles(Path("block.json"), {})
    elif block.language == "sh":
        for command in block.commands:
            words = shlex.split(command)
            plain = words[0] == "quadshade" and not {"|", ">", "&&", ";", "&"} & set(words)
            code, output = run_quadshade(words[1:]) if plain else run_shell(command)
            assert code == 0, f"{block.place}: {command}\nexit code {code}\n{output}"


def embedded_pictures(page: Path) -> list[Path]:
    """The PNG files that a page shows."""
    return [page.parent / name for name in re.findall(r"!\[[^\]]*\]\(([^)]+\.png)\)", page.read_text())]


def check_picture(picture: Path, drawn: Path) -> None:
    """
    A page shows what its own command draws; with QUADSHADE_WRITE_PICTURES=1 the page's picture is replaced.

    One grey level is allowed: the host shades in floating point, and the mathematical functions of another
    processor may round a sample to the other side.
    """
    if os.environ.get("QUADSHADE_WRITE_PICTURES") == "1":
        shutil.copyfile(drawn, picture)
    shown, expected = read_picture(picture).astype(int), read_picture(drawn).astype(int)
    same = shown.shape == expected.shape and abs(shown - expected).max() <= 1
    assert same, f"{picture.relative_to(ROOT)} is not what the page's command draws; run `make pictures`"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clean copy of the examples, which is the working directory."""
    copy = tmp_path / "examples"
    shutil.copytree(ROOT / "examples", copy)
    monkeypatch.chdir(copy)
    return copy


@pytest.fixture
def started() -> Iterator[list[subprocess.Popen]]:
    """Commands in the background; ended by Ctrl-C when the test ends."""
    processes: list[subprocess.Popen] = []
    yield processes
    for process in processes:
        process.send_signal(signal.SIGINT)
    assert all(process.wait(timeout=30) in (0, 130) for process in processes)


@pytest.mark.parametrize("page", pages_with_blocks(), ids=lambda page: str(page.relative_to(ROOT)))
def test_every_block_runs(page: Path, folder: Path, started: list[subprocess.Popen]) -> None:
    for block in blocks(page):
        if block.background:
            start(block, started)
        elif not block.not_run:
            run_block(block)
    for picture in embedded_pictures(page):
        drawn = folder / picture.name
        if drawn.exists():
            check_picture(picture, drawn)


def test_named_sources_exist() -> None:
    """A source that a page names by its folder is there, below the repository, the package or the RTL."""
    bases = (ROOT, ROOT / "model" / "quadshade", ROOT / "rtl")
    named = re.compile(r"`((?:\w+/)+\w+\.(?:py|vhd|v|sv|cpp|toml|json|rules))`")
    missing = [
        f"{page.relative_to(ROOT)}: {name}"
        for page in {ROOT / "README.md", *(ROOT / "docs").rglob("*.md")}
        for name in named.findall(page.read_text())
        if not name.startswith("build/") and not any((base / name).exists() for base in bases)
    ]
    assert not missing, "\n" + "\n".join(sorted(missing))


def test_readme_is_short() -> None:
    """A newcomer reads all of it; what takes longer is a page."""
    assert len((ROOT / "README.md").read_text().splitlines()) < 120


def test_every_block_has_a_known_language() -> None:
    """What has no language is neither run nor coloured; commands below an indentation would not be found."""
    wrong = [
        block.place
        for page in pages_with_blocks()
        for block in blocks(page)
        if block.language not in LANGUAGES
    ]
    for page in set(pages()) - {OWN_TEST}:
        for number, line in enumerate(page.read_text().splitlines(), start=1):
            if re.match(r" {4,}(quadshade|make|python|pip|apt) ", line):
                wrong.append(f"{page.relative_to(ROOT)}:{number}: a command in no fenced block")
    assert not wrong, "\n" + "\n".join(wrong)


def test_a_block_that_fails_is_named(folder: Path) -> None:
    page = ROOT / "docs" / "page.md"
    cases = {
        "sh": ("quadshade render absent.stl -o a.png", "absent.stl"),
        "python": ("nothing_of_this_name", "nothing_of_this_name"),
    }
    for language, (code, said) in cases.items():
        with pytest.raises((AssertionError, NameError), match=said):
            run_block(Block(page, 7, language, code))
    with pytest.raises(AssertionError, match=r"docs/page.md:7: false\n *exit code 1"):
        run_block(Block(page, 7, "sh", "false  # a comment\n"))


def test_blocks_are_found_with_their_notes(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- not run: far above -->\ntext\n\n```sh\nfirst  # comment\nsecond \\\n  third\n```\n"
        "<!-- not run: needs a board -->\n```sh\nmake program\n```\n\n"
        "<!-- in the background: board.tty -->\n\n```sh\nquadshade board\n```\n"
    )
    first, second, third = blocks(page)
    assert (first.line, first.commands, first.not_run) == (5, ["first", "second    third"], None)
    assert (second.not_run, third.not_run, third.background) == ("needs a board", None, "board.tty")
