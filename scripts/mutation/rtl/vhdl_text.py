# SPDX-License-Identifier: Apache-2.0
"""
Mutants of VHDL text: every small change of a file that a bench should notice.

Not changed: entities (a bench sets their generics), signals' values at power-up (a reset comes before
anything is asked of a unit), assertions and what they report, clock edges, and the generated packages, which
a test compares with their source in Python.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from scripts.mutation.rtl.vhdl_tokens import Statement, Token, statements_of

_OTHERS = {
    "=": ("relation", ["/="]),
    "/=": ("relation", ["="]),
    "<": ("relation", ["<=", ">="]),
    "<=": ("relation", ["<", ">"]),
    ">": ("relation", [">=", "<="]),
    ">=": ("relation", [">", "<"]),
    "and": ("logic", ["or"]),
    "or": ("logic", ["and"]),
    "xor": ("logic", ["or"]),
    "not": ("logic", [""]),
    "+": ("arithmetic", ["-"]),
    "-": ("arithmetic", ["+"]),
    "*": ("arithmetic", ["+"]),
    "'0'": ("constant", ["'1'"]),
    "'1'": ("constant", ["'0'"]),
    "true": ("constant", ["false"]),
    "false": ("constant", ["true"]),
}
_BEFORE_UNARY = {"(", ",", "=>", "<=", ":=", "return", "and", "or", "when", "else", "to", "downto", "&"}
_SKIPPED = {
    "assert",
    "report",
    "architecture",
    "package",
    "use",
    "library",
    "attribute",
    "end",
    "null",
    "exit",
}
_DECLARATIONS = {"signal", "constant", "variable", "type", "subtype"}


@dataclass(frozen=True)
class Change:
    """A place of a text and what stands there instead."""

    start: int
    end: int
    new: str


@dataclass(frozen=True)
class TextMutant:
    """
    One change of an RTL file.

    Attributes
    ----------
    name : str
      Hash of the file's path, the line's text and the change: it stays if other lines change.
    file : str
      Path below the repository's root.
    line : int
    kind : str
    original : str
      The line that it changes, without the space around it.
    what : str
      The change, for people.
    changes : tuple of Change
    """

    name: str
    file: str
    line: int
    kind: str
    original: str
    what: str
    changes: tuple[Change, ...]

    def apply(self, text: str) -> str:
        """The mutated text of the file."""
        for change in sorted(self.changes, key=lambda change: -change.start):
            text = text[: change.start] + change.new + text[change.end :]
        return text


def _neighbours(statements: Sequence[Statement]) -> dict[str, str]:
    """Each name that is declared beside others of its type, and the next of them; enumerations' too."""
    following: dict[str, str] = {}
    for statement in statements:
        texts = [token.text for token in statement.tokens]
        names: list[str] = []
        if statement.kind in ("signal", "variable") and ":" in texts:
            names = [text for text in texts[1 : texts.index(":")] if text != ","]
        elif statement.kind == "type" and "(" in texts[:4] and "array" not in texts:
            names = [text for text in texts[texts.index("(") + 1 :] if text not in (",", ")")]
        if len(names) > 1:
            following.update(zip(names, names[1:] + names[:1], strict=True))
    return following


def _parts(statement: Statement) -> Sequence[Token]:
    """The tokens of a statement that may be changed."""
    tokens = statement.tokens
    texts = [token.text for token in tokens]
    if statement.kind == "signal" and ":=" in texts:
        return tokens[: texts.index(":=")]
    if statement.kind in _DECLARATIONS and ":" in texts:
        return tokens[texts.index(":") + 1 :]
    if statement.kind in ("type", "subtype"):
        return tokens[2:] if "array" in texts or statement.kind == "subtype" else []
    return tokens


def _condition(statement: Statement) -> Sequence[Token]:
    """What stands between ``if`` and ``then``."""
    return statement.tokens[1:]


def _token_changes(
    tokens: Sequence[Token], index: int, depth: int, following: dict[str, str], readable: bool
) -> Iterator[tuple[str, str]]:
    """Kind and new text for what one token can become."""
    token = tokens[index]
    before = tokens[index - 1].text if index else "("
    after = tokens[index + 1].text if index + 1 < len(tokens) else ";"
    if token.text in _OTHERS and not (token.text == "-" and before in _BEFORE_UNARY):
        kind, others = _OTHERS[token.text]
        yield from ((kind, new) for new in others)
    elif token.kind == "number" and token.text.isdigit():
        kind = "index" if depth and before in ("(", "to", "downto") else "constant"
        yield kind, str(int(token.text) + 1)
        if int(token.text):
            yield kind, str(int(token.text) - 1)
    elif token.kind == "string" and token.text[0] == "x" and len(token.text) > 3:
        yield "constant", f'{token.text[:-2]}{int(token.text[-2], 16) ^ 1:x}"'
    elif token.kind == "name" and readable and token.text in following and before not in (".", "'"):
        if after != "=>":
            yield "operand", following[token.text]
    elif token.text in ("downto", "to"):
        if tokens[index - 1].kind != "number" or tokens[index - 2].text not in ("(", "range", "in"):
            yield "range", f"- 1 {token.text}"
        if tokens[index + 1].kind != "number" or after == ";":
            yield "range", f"{token.text} 1 +"


def _changes_of(statement: Statement, following: dict[str, str]) -> Iterator[tuple[str, list[Change]]]:
    """Kind and changes of all mutants of a statement."""
    if statement.kind in _SKIPPED or any(token.text == "rising_edge" for token in statement.tokens):
        return
    tokens = _parts(statement)
    depth = 0
    for index, token in enumerate(tokens):
        depth += (token.text == "(") - (token.text == ")")
        if statement.kind == "assignment" and index == statement.target:
            continue
        readable = statement.kind != "assignment" or index > statement.target
        readable = readable and statement.kind not in _DECLARATIONS and statement.kind != "for"
        for kind, new in _token_changes(tokens, index, depth, following, readable):
            yield kind, [Change(token.start, token.end, new)]
        if token.text in ("-", "&", "<") and 0 < index < len(tokens) - 1 and statement.kind != "when":
            yield from _swap(tokens, index)
    if statement.kind == "if":
        condition = _condition(statement)
        start, end = condition[0].start, condition[-1].end
        for new in ("false", "true"):
            yield "condition", [Change(start, end, new)]
        if any(token.text in ("and", "or") for token in condition):
            yield "condition", [Change(start, start, "not ("), Change(end, end, ")")]
    if statement.kind == "assignment" and statement.sequential:
        yield "dropped", [Change(statement.tokens[0].start, statement.tokens[-1].end, "null")]


def _swap(tokens: Sequence[Token], index: int) -> Iterator[tuple[str, list[Change]]]:
    """The two plain names beside an operator in each other's place."""
    left, right = tokens[index - 1], tokens[index + 1]
    behind = tokens[index + 2].text if index + 2 < len(tokens) else ";"
    ahead = tokens[index - 2].text if index > 1 else "("
    plain = left.kind == right.kind == "name" and left.text != right.text
    if plain and behind not in ("(", "'", ".", "*") and ahead not in ("'", ".", "*", "not"):
        yield (
            "swapped",
            [Change(left.start, left.end, right.text), Change(right.start, right.end, left.text)],
        )


def mutants_of(file: str, text: str) -> list[TextMutant]:
    """
    Every mutant of an RTL file, in the order of its text.

    Parameters
    ----------
    file : str
      Path below the repository's root.
    text : str
      What it holds.

    Returns
    -------
    list of TextMutant
      With different names, and different texts.
    """
    statements = list(statements_of(text))
    following = _neighbours(statements)
    lines = text.splitlines()
    seen: Counter[str] = Counter()
    found: dict[str, TextMutant] = {}
    for statement in statements:
        for kind, changes in _changes_of(statement, following):
            start = min(change.start for change in changes)
            end = max(change.end for change in changes)
            line = text.count("\n", 0, start) + 1
            original = lines[line - 1].strip()
            column = start - text.rfind("\n", 0, start) - 1 - lines[line - 1].index(original)
            mutant = TextMutant("", file, line, kind, original, "", tuple(changes))
            changed = mutant.apply(text)
            cut = changed[start : len(changed) - (len(text) - end)]
            what = re.sub(r"\s+", " ", f"`{text[start:end]}` becomes `{cut}`")
            key = f"{file}|{original}|{column}|{what}"
            seen[key] += 1
            name = hashlib.sha256(f"{key}|{seen[key]}".encode()).hexdigest()[:10]
            if changed != text:
                found.setdefault(changed, TextMutant(name, file, line, kind, original, what, tuple(changes)))
    return list(found.values())
