# SPDX-License-Identifier: Apache-2.0
"""Width expressions: integers, names and ``+ - * / **``, which mean the same in Python and in VHDL."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import overload

_OPERATORS: dict[type[ast.operator], Callable[[int, int], int]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    # VHDL rounds a quotient towards zero, Python down: the same, as no width is negative.
    ast.Div: operator.floordiv,
    ast.Pow: operator.pow,
}


@lru_cache(maxsize=4096)
def evaluate(expression: str, names: Hashable) -> int:
    """
    Value of a width expression; it is kept, because the same ones are asked for again and again.

    Parameters
    ----------
    expression : str
      Integers, names and ``+ - * / **``, where ``/`` drops the remainder.
    names : hashable
      Its attributes are what the names mean.

    Raises
    ------
    ValueError
      Anything else in the expression.
    AttributeError
      A name that is no attribute.
    """
    return _value(ast.parse(expression, mode="eval").body, names)


def _value(node: ast.expr, names: object) -> int:
    match node:
        case ast.Constant(value=int(number)):
            return number
        case ast.Name(id=name):
            return int(getattr(names, name))
        case ast.BinOp(left=left, op=sign, right=right) if type(sign) in _OPERATORS:
            return _OPERATORS[type(sign)](_value(left, names), _value(right, names))
    raise ValueError(f"{ast.unparse(node)!r} is no width: give integers, names and + - * / **")


class DerivedWidth:
    """
    A number that follows from others: a read-only attribute of its class, written to VHDL as a function.

    It is evaluated once for each object, which never changes.

    Parameters
    ----------
    expression : str
      Over the attributes of the class's objects.
    meaning : str
      What the number is, or why it is so; the comment in VHDL.
    """

    def __init__(self, expression: str, meaning: str) -> None:
        self.expression, self.meaning, self.__doc__ = expression, meaning, meaning

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, names: None, owner: type) -> DerivedWidth: ...

    @overload
    def __get__(self, names: Hashable, owner: type) -> int: ...

    def __get__(self, names: Hashable | None, owner: type) -> DerivedWidth | int:
        if names is None:
            return self
        # Python looks here before it asks the descriptor again.
        value = vars(names)[self._name] = evaluate(self.expression, names)
        return value
