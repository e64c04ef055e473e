# SPDX-License-Identifier: Apache-2.0
"""
A griffe extension: our docstrings as griffe and Markdown want them.

They indent a parameter's description by two spaces, griffe wants four; and a name with its role, as in
``:func:`draw```, is the name in Markdown.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

ROLE = re.compile(r":(?:attr|class|data|func|meth|mod):(?=`)")


def as_markdown(text: str) -> str:
    """A docstring with four spaces for two, and names without their roles."""
    return ROLE.sub("", re.sub(r"^ {2}(?! )", "    ", text, flags=re.MULTILINE))


class Docstrings(griffe.Extension):
    """Change every docstring before it is parsed."""

    def on_object(self, *, obj: griffe.Object, **kwargs: Any) -> None:
        """An alias has no docstring of its own."""
        del kwargs
        if obj.docstring:
            obj.docstring.value = as_markdown(obj.docstring.value)
