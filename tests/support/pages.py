# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation, and the fenced blocks of code in them."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

LANGUAGES = ("sh", "python", "json", "vhdl", "text")
"""What a block may be: ``sh`` and ``python`` are run, ``json`` is a triangles file, the others are read."""

FENCE = re.compile(r"^( *)```(\w*)[^\n]*\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
NOTE = re.compile(r"<!-- (not run|in the background): (.+?) -->")


@dataclass(frozen=True)
class Block:
    """
    A fenced block.

    Attributes
    ----------
    page : Path
    line : int
      Of its first line of code, from 1.
    language, code : str
    not_run : str or None
      Why the test does not run it: the comment ``<!-- not run: reason -->`` before the block.
    background : str or None
      The file that shows that the command is ready, from ``<!-- in the background: file -->``: the command
      runs until the page ends.
    """

    page: Path
    line: int
    language: str
    code: str
    not_run: str | None = None
    background: str | None = None

    @property
    def place(self) -> str:
        """Page and line, as an editor takes them."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"

    @property
    def commands(self) -> list[str]:
        """The commands of a block of shell, continued lines joined, comments and empty lines removed."""
        lines = [re.sub(r"(^| +)#.*", "", line) for line in self.code.replace("\\\n", " ").splitlines()]
        return [line.strip() for line in lines if line.strip()]


def pages() -> list[Path]:
    """README and its like, those of the folders, and every page of the documentation."""
    folders = ("rtl", "cocotb_tests", "formal", "model", "scripts", "synth", "sim", "tests", "examples")
    readmes = [path for name in folders for path in (ROOT / name).rglob("README.md")]
    return [*ROOT.glob("*.md"), *readmes, *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path) -> list[Block]:
    """Every fenced block of a page, in their order."""
    text = page.read_text()
    found = []
    for match in FENCE.finditer(text):
        indent, language, code = match.groups()
        before = text[: match.start()].rstrip().rpartition("\n")[2]
        note = NOTE.fullmatch(before)
        kind, reason = note.groups() if note else (None, None)
        found.append(
            Block(
                page,
                text.count("\n", 0, match.start()) + 2,
                language,
                re.sub(f"^{indent}", "", code, flags=re.MULTILINE),
                reason if kind == "not run" else None,
                reason if kind == "in the background" else None,
            )
        )
    return found


def documented_commands(program: str) -> list[list[str]]:
    """Arguments of every call of a program, in the blocks of all pages and between single back-ticks."""
    calls = []
    for page in pages():
        lines = [command for block in blocks(page) if block.language == "sh" for command in block.commands]
        lines += re.findall(r"`([^`\n]+)`", page.read_text())
        calls += [part.strip() for line in lines for part in line.split("&&")]
    return [shlex.split(call)[1:] for call in calls if call.startswith(f"{program} ")]
