# SPDX-License-Identifier: Apache-2.0
"""VHDL as tokens and statements: as much of the language as a mutator has to tell apart."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

_TOKEN = re.compile(
    r"""--[^\n]* | (?P<string>[xX]?"[^"\n]*") | (?P<char>'[^']') | (?P<number>\d\w*)
    | (?P<name>[A-Za-z]\w*) | (?P<symbol>\*\*|/=|<=|>=|:=|=>|<>|[-+*/&=<>()|,;:.'])""",
    re.VERBOSE,
)
_OPENERS = {"then", "begin", "loop", "generate"}
_BLOCKS = {"process", "function", "procedure"}


@dataclass(frozen=True)
class Token:
    """A word: its kind (string, char, number, name, symbol), its text in small letters, its place."""

    kind: str
    text: str
    start: int
    end: int


@dataclass(frozen=True)
class Statement:
    """
    A statement, a declaration, or the part of one that ends with ``then``, ``loop`` and the like.

    Attributes
    ----------
    tokens : sequence of Token
      Without a label and without what ends it.
    kind : str
      ``if``, ``while``, ``for``, ``when``, ``assignment``, ``instance``, or its first word.
    sequential : bool
      It is in a process or in a subprogram.
    target : int
      Of an assignment, the index of ``<=`` or ``:=``; else 0.
    """

    tokens: Sequence[Token]
    kind: str
    sequential: bool
    target: int = 0


def tokens_of(text: str) -> list[Token]:
    """Every token but comments; an attribute's tick is a symbol, not the begin of a character."""
    tokens: list[Token] = []
    place = 0
    while found := _TOKEN.search(text, place):
        place = found.end()
        kind = found.lastgroup
        if kind is None:
            continue
        last = tokens[-1] if tokens else None
        after_name = last is not None and (last.kind == "name" or last.text == ")")
        if kind == "char" and after_name and last is not None and last.end == found.start():
            # t'('0') is a qualified expression.
            kind, place = "symbol", found.start() + 1
        tokens.append(Token(kind, text[found.start() : place].lower(), found.start(), place))
    return tokens


def _first_assignment(tokens: Sequence[Token]) -> int:
    """Index of the ``<=`` or ``:=`` that ends a statement's target; 0 if it has none."""
    depth = 0
    for index, token in enumerate(tokens):
        depth += (token.text == "(") - (token.text == ")")
        if depth == 0 and token.text in ("<=", ":="):
            return index
        if depth == 0 and index and token.kind != "name" and token.text not in (".", ")", "'"):
            return 0
    return 0


def _statement(tokens: list[Token], sequential: bool) -> Statement | None:
    """What some tokens between two ends are."""
    if len(tokens) > 2 and tokens[1].text == ":" and tokens[0].kind == "name":
        tokens = tokens[2:]
    if not tokens:
        return None
    first = tokens[0].text
    if first == "elsif":
        return Statement(tokens, "if", sequential)
    if first in ("if", "while", "for", "when", "assert", "report", "case", "return", "end", "null", "exit"):
        return Statement(tokens, first, sequential)
    if first in ("entity", "component") or (len(tokens) > 1 and tokens[1].text in ("port", "generic")):
        return Statement(tokens, "instance", sequential)
    if target := _first_assignment(tokens):
        return Statement(tokens, "assignment", sequential, target)
    return Statement(tokens, first, sequential)


def statements_of(text: str) -> Iterator[Statement]:
    """
    Statements and declarations of architectures and package bodies, in their order.

    What stands before them (entities, package declarations) says how units are joined: it is left out.
    """
    tokens = tokens_of(text)
    begins = [
        index
        for index, token in enumerate(tokens)
        if (token.text == "architecture" or (token.text == "package" and tokens[index + 1].text == "body"))
        and (index == 0 or tokens[index - 1].text != "end")
    ]
    if not begins:
        return
    current: list[Token] = []
    depth = 0
    blocks: list[str] = []
    for token in tokens[begins[0] :]:
        depth += (token.text == "(") - (token.text == ")")
        first = current[0].text if current else ""
        assigned = bool(_first_assignment(current)) or first == "return"
        ends = depth == 0 and (
            token.text == ";"
            or token.text in _OPENERS
            or (token.text == "is" and first not in ("type", "subtype"))
            or (token.text == "=>" and first == "when")
            or (token.text == "else" and not assigned)
        )
        if not ends:
            current.append(token)
            continue
        if current and first == "end" and len(current) > 1 and current[1].text in _BLOCKS and blocks:
            blocks.pop()
        words = {part.text for part in current[:4]}
        opened = [name for name in _BLOCKS if name in words and first != "end"]
        # Of a function only its body opens a block; process (clk) begin and process (clk) variable ... too.
        if opened and opened[0] == "process":
            blocks.append("process")
            header = next(i for i, part in enumerate(current) if part.text == "process")
            current = _after_sensitivity(current[header + 1 :])
        elif opened and token.text == "is":
            blocks.append(opened[0])
            current = []
        if found := _statement(current, bool(blocks)):
            yield found
        current = []


def _after_sensitivity(tokens: list[Token]) -> list[Token]:
    """A process's first declaration, which no sign divides from its sensitivity list."""
    depth = 0
    for index, token in enumerate(tokens):
        depth += (token.text == "(") - (token.text == ")")
        if depth == 0 and token.text == ")":
            return tokens[index + 1 :]
    return tokens
