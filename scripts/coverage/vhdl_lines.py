# SPDX-License-Identifier: Apache-2.0
"""Which lines of VHDL decide something, and which only say what is wrong."""

from __future__ import annotations

import re

TOKEN = re.compile(r"\"[^\"]*\"|'.'|\w+|=>|<=|:=|\S")
OPENS = {"if": {"then", "generate"}, "elsif": {"then", "generate"}, "while": {"loop"}, "case": {"is"}}
"""A decision's first word, and the words that end it."""


def tokens(text: str) -> list[tuple[int, str]]:
    """Line, from 1, and text in lower case of every token; comments are none."""
    return [
        (number, token.lower())
        for number, line in enumerate(text.splitlines(), start=1)
        for token in TOKEN.findall(line.split("--")[0])
    ]


def decision_lines(text: str) -> set[int]:
    """
    Lines of conditions: of ``if``, ``elsif``, ``while``, ``case``, and of ``when`` where it is no choice.

    Parameters
    ----------
    text : str
      A file of VHDL.

    Returns
    -------
    set of int
    """
    found: set[int] = set()
    waiting: set[int] = set()
    ends: set[str] = set()
    before = ""
    for number, token in tokens(text):
        if ends:
            waiting.add(number)
            if token in ends:
                # What a choice of a case ends is no condition.
                found |= set() if token == "=>" else waiting
                waiting, ends = set(), set()
        elif token in OPENS and before != "end":
            waiting, ends = {number}, OPENS[token]
        elif token == "when":
            waiting, ends = {number}, {"else", ";", "=>"}
        before = token
    return found


def assertion_lines(text: str) -> set[int]:
    """Lines of assertions and reports, whose failing side a passing test never enters."""
    found: set[int] = set()
    inside = False
    for number, token in tokens(text):
        inside = inside or token in ("assert", "report")
        if inside:
            found.add(number)
            inside = token != ";"
    return found
