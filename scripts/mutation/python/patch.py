# SPDX-License-Identifier: Apache-2.0
"""A change of one function put into a process that has imported the package: nothing is imported again."""

from __future__ import annotations

import ast
import functools
import gc
import sys
from collections.abc import Iterator
from types import CodeType, FunctionType

from scripts.mutation.python.mutants import Mutant


def function_body(source: str, mutant: Mutant) -> str:
    """Qualified name of the function whose body, not its defaults, holds a mutant; empty if none does."""
    found = ""

    def visit(node: ast.AST, name: str) -> None:
        nonlocal found
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef):
                visit(child, f"{name}{child.name}.")
            elif isinstance(child, ast.FunctionDef):
                start = (child.body[0].lineno, child.body[0].col_offset)
                if start <= (mutant.line, mutant.column) and mutant.line <= (child.end_lineno or 0):
                    found = name + child.name

    visit(ast.parse(source), "")
    return found


def _codes(code: CodeType) -> Iterator[CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _codes(constant)


def _plain_function(value: object) -> FunctionType | None:
    """The function behind a property, a cache, a context manager or a class method."""
    for _ in range(4):
        if isinstance(value, FunctionType) and not hasattr(value, "__wrapped__"):
            return value
        for name in ("__wrapped__", "__func__", "fget", "func"):
            if getattr(value, name, None) is not None:
                value = getattr(value, name)
                break
    return None


def caches_of(packages: tuple[str, ...]) -> list[functools._lru_cache_wrapper[object]]:
    """The caches that functions of packages have."""
    caches = [value for value in gc.get_objects() if isinstance(value, functools._lru_cache_wrapper)]
    return [cache for cache in caches if (cache.__module__ or "").split(".")[0] in packages]


def patch(
    mutant: Mutant, qualified: str, changed: str, caches: list[functools._lru_cache_wrapper[object]]
) -> bool:
    """
    Put a change into the function of the imported module, and forget what the package has cached.

    Parameters
    ----------
    mutant : Mutant
    qualified : str
      The function that it is in.
    changed : str
      The file's text with the change.
    caches : list
      What is forgotten.

    Returns
    -------
    bool
      False where that does not do: the package has to be imported anew.
    """
    module = sys.modules.get("quadshade." + mutant.path.removesuffix(".py").replace("/", "."))
    if module is None:
        return False
    value: object = module
    for name in qualified.split("."):
        value = vars(value).get(name) if hasattr(value, "__dict__") else None
    function = _plain_function(value)
    if function is None or function.__qualname__ != qualified:
        return False
    codes = _codes(compile(changed, module.__file__ or "", "exec", dont_inherit=True))
    new = [code for code in codes if code.co_qualname == qualified]
    if len(new) != 1 or new[0].co_freevars != function.__code__.co_freevars:
        return False
    function.__code__ = new[0]
    for cache in caches:
        cache.cache_clear()
    return True


def forget_imports(prefixes: tuple[str, ...]) -> None:
    """Take modules out of ``sys.modules``, so that they are imported anew."""
    for name in [name for name in sys.modules if name.split(".")[0] in prefixes]:
        del sys.modules[name]
