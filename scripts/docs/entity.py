# SPDX-License-Identifier: Apache-2.0
"""What a unit of ``rtl/`` says about itself: its header, generics, ports and the units inside it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from quadshade.contract.formats import Formats

ROOT = Path(__file__).resolve().parents[2]
RTL = ROOT / "rtl"


@dataclass(frozen=True)
class Declaration:
    """
    A generic or a port of an entity.

    Attributes
    ----------
    name : str
    direction : str
      ``in`` or ``out``; empty for a generic.
    kind : str
      The VHDL type, without its range.
    width : str
      Bits, as an expression of the generics; empty for a generic.
    default : str
      Empty if there is none.
    meaning : str
      The comment above it.
    """

    name: str
    direction: str
    kind: str
    width: str
    default: str
    meaning: str


@dataclass(frozen=True)
class Unit:
    """One VHDL file with an entity."""

    path: Path

    @property
    def name(self) -> str:
        """The entity's name, which is the file's."""
        return self.path.stem

    @property
    def stage(self) -> str:
        """The folder of ``rtl/``; empty for the board, which holds all of them."""
        return self.path.parent.name if self.path.parent != RTL else ""

    @cached_property
    def text(self) -> str:
        """The whole file."""
        return self.path.read_text()

    @cached_property
    def header(self) -> list[str]:
        """The comment at the top, without its licence line."""
        lines = []
        for line in self.text.splitlines()[1:]:
            if not line.startswith("--"):
                break
            lines.append(line[2:].removeprefix(" "))
        return lines

    @cached_property
    def purpose(self) -> str:
        """The header up to the line that names the model, as Markdown."""
        above, _, _ = "\n".join(self.header).partition("Model:")
        return _as_markdown(above.strip("\n").splitlines())

    @cached_property
    def first_sentence(self) -> str:
        """What the unit is for, in one sentence."""
        sentence = re.split(r"(?<=\.)\s|\n\n", self.purpose, maxsplit=1)[0]
        return " ".join(sentence.split()).rstrip(":.") + "."

    @cached_property
    def timing(self) -> str:
        """Latency and throughput, and what the header says after them, as Markdown."""
        _, _, below = "\n".join(self.header).replace("*", "\\*").partition("Latency:")
        text = re.sub(r"(?<=\.)\n(?=[A-Z])|\.  (?=[A-Z])", _keep_stop, "Latency: " + below.strip())
        text = re.sub(r"\s*(?<!\*)\b(Throughput|Clear): ", r"\n\n\1: ", text)
        return re.sub(r"^(\w+):", r"**\1:**", text, flags=re.MULTILINE)

    @cached_property
    def generics(self) -> list[Declaration]:
        """The entity's generics, in order."""
        return _declarations(self._clause("generic"))

    @cached_property
    def ports(self) -> list[Declaration]:
        """The entity's ports, in order."""
        return _declarations(self._clause("port"))

    @cached_property
    def parts(self) -> list[str]:
        """Names of the entities that it instantiates, each once, in the order of the file."""
        return list(dict.fromkeys(re.findall(r"entity work\.(\w+)", self.text)))

    def _clause(self, word: str) -> str:
        """The lines of the entity's ``generic (...)`` or ``port (...)``."""
        (entity,) = re.findall(
            rf"^entity {self.name} is\n(.*?)^end entity", self.text, re.MULTILINE | re.DOTALL
        )
        clause = re.search(rf"^  {word} \(\n(.*?)^  \);", entity, re.MULTILINE | re.DOTALL)
        return clause[1] if clause else ""


def units() -> dict[str, Unit]:
    """Every unit of ``rtl/files.f`` by its name, bottom-up; packages are none."""
    lines = (RTL / "files.f").read_text().splitlines()
    paths = [ROOT / line for line in lines if line and not line.startswith("#")]
    return {path.stem: Unit(path) for path in paths if not path.stem.endswith("_pkg")}


def _keep_stop(match: re.Match[str]) -> str:
    return "\n\n" if match[0] == "\n" else ".\n\n"


def _as_markdown(lines: list[str]) -> str:
    """Comment lines to Markdown: indented ones are formulas, blank ones end a paragraph; * is itself."""
    result, formula = [], False
    for line in lines:
        if line.startswith("  ") != formula:
            formula = not formula
            result.append("")
        result.append(f"  {line}" if formula else line.replace("*", "\\*"))
    return "\n".join(result).strip("\n")


def _declarations(clause: str) -> list[Declaration]:
    """The declarations of a clause; a comment belongs to the declaration below it."""
    found, comment, statement = [], [], ""
    for line in map(str.strip, clause.splitlines()):
        if line.startswith("--"):
            comment.append(line[2:].strip())
            continue
        statement = f"{statement} {line}".strip()
        if not statement or not (statement.endswith(";") or _closed(statement)):
            if not line:
                comment = [] if not statement else comment
            continue
        found += _declared(statement.rstrip(";"), " ".join(comment))
        comment, statement = [], ""
    if statement:
        raise ValueError(f"not understood: {statement}")
    return found


def _closed(statement: str) -> bool:
    """Whether a statement without a semicolon is a whole one: the last of its clause."""
    return ":" in statement and statement.count("(") == statement.count(")")


def _declared(statement: str, meaning: str) -> list[Declaration]:
    """A statement's names, one declaration each."""
    names, _, rest = statement.partition(" : ")
    direction, kind = re.match(r"(?:(in|out) )?(.*)", rest).groups()
    kind, _, default = kind.partition(" := ")
    kind, _, span = kind.partition("(")
    width = _width(span.rstrip(")") if span.count("(") < span.count(")") else span) if direction else ""
    return [
        Declaration(name.strip(), direction or "", kind.strip(), width, _default(default), meaning)
        for name in names.split(",")
    ]


def _width(span: str) -> str:
    """Bits of ``<high> downto 0``."""
    if not span:
        return "1"
    high = span.removesuffix(" downto 0")
    if high == span:
        return span
    if high.isdigit():
        return str(int(high) + 1)
    return high.removesuffix(" - 1") if high.endswith(" - 1") else f"{high} + 1"


def _default(text: str) -> str:
    """A default value; one of the formats' with its number."""
    name = text.removeprefix("default_formats.")
    return str(int(getattr(Formats(), name))) if name != text else text.replace("_", "")
