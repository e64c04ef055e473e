# SPDX-License-Identifier: Apache-2.0
"""A griffe extension: our docstrings indent a parameter's description by two spaces, griffe wants four."""

from __future__ import annotations

import re
from typing import Any

import griffe


class Indentation(griffe.Extension):
    """Four spaces for two in every docstring that is read."""

    def on_object(self, *, obj: griffe.Object, **kwargs: Any) -> None:
        """Change a docstring before it is parsed; an alias has none of its own."""
        del kwargs
        if obj.docstring:
            obj.docstring.value = re.sub(r"^ {2}(?! )", "    ", obj.docstring.value, flags=re.MULTILINE)
