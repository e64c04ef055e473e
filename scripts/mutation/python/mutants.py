# SPDX-License-Identifier: Apache-2.0
"""Mutants of the host library, made by Cosmic Ray: where each is, and a sample that a seed repeats."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator
from parso.python.tree import ExprStmt
from parso.tree import NodeOrLeaf

BINARY = (
    ("Add", "Sub"),
    ("Add", "BitXor"),
    ("Sub", "Add"),
    ("Sub", "BitXor"),
    ("Mul", "Add"),
    ("Mul", "Div"),
    ("Div", "Mul"),
    ("FloorDiv", "Mul"),
    ("Mod", "FloorDiv"),
    ("Pow", "Mul"),
    ("RShift", "LShift"),
    ("LShift", "RShift"),
    ("BitOr", "BitAnd"),
    ("BitOr", "BitXor"),
    ("BitAnd", "BitOr"),
    ("BitXor", "BitOr"),
)
COMPARISONS = (
    ("Eq", "NotEq"),
    ("NotEq", "Eq"),
    ("Lt", "LtE"),
    ("Lt", "GtE"),
    ("LtE", "Lt"),
    ("LtE", "Gt"),
    ("Gt", "GtE"),
    ("Gt", "LtE"),
    ("GtE", "Gt"),
    ("GtE", "Lt"),
    ("Is", "IsNot"),
    ("IsNot", "Is"),
)
OTHERS = (
    "ReplaceUnaryOperator_Delete_USub",
    "ReplaceUnaryOperator_Delete_Not",
    "ReplaceUnaryOperator_Delete_Invert",
    "AddNot",
    "ReplaceTrueWithFalse",
    "ReplaceFalseWithTrue",
    "ReplaceAndWithOr",
    "ReplaceOrWithAnd",
    "ReplaceBreakWithContinue",
    "ReplaceContinueWithBreak",
    "ExceptionReplacer",
    "NumberReplacer",
    "RemoveDecorator",
    "ZeroIterationForLoop",
)


def digest(*contents: bytes) -> str:
    """Twelve hexadecimal digits that tell contents apart."""
    return hashlib.sha256(b"\0".join(contents)).hexdigest()[:12]


class DropStatement(Operator):
    """A statement that only has an effect, a call or an augmented assignment, does nothing."""

    def mutation_positions(self, node: NodeOrLeaf) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
        if self._has_only_an_effect(node):
            yield (node.start_pos, node.end_pos)

    def _has_only_an_effect(self, node: NodeOrLeaf) -> bool:
        parent = node.parent
        if parent is None or parent.type != "simple_stmt" or parent.children[0] is not node:
            return False
        if isinstance(node, ExprStmt):
            return node.children[1].type == "operator" and node.children[1].value != "="
        return node.type in ("atom_expr", "power") and node.children[-1].get_code().startswith("(")

    def mutate(self, node: NodeOrLeaf, index: int) -> NodeOrLeaf:
        nothing = get_ast("pass").children[0]
        nothing.prefix = node.get_first_leaf().prefix
        return nothing

    @classmethod
    def examples(cls) -> tuple[()]:
        return ()


@functools.cache
def operators() -> dict[str, Operator]:
    """The operators that are applied, by name: Cosmic Ray's, few replacements each, and a dropped line."""
    names = [f"ReplaceBinaryOperator_{old}_{new}" for old, new in BINARY]
    names += [f"ReplaceComparisonOperator_{old}_{new}" for old, new in COMPARISONS]
    return {name: get_operator(f"core/{name}")() for name in (*names, *OTHERS)} | {
        "DropStatement": DropStatement()
    }


@dataclass(frozen=True)
class Mutant:
    """
    One change of one file.

    Attributes
    ----------
    path : str
      Of the file, below the package's folder.
    operator : str
      Name in :func:`operators`.
    occurrence : int
      The operator's how many-th place in the file.
    line, column : int
      Where it is.
    where : str
      The function that it is in, with its class; empty at module level.
    place : str
      Names the place by what stands there: another one elsewhere in the file leaves it as it is.
    nth : int
      Which of the operator's changes at this place.
    around : str
      Digest of the lines of the function; at module level, of those outside of functions.
    """

    path: str
    operator: str
    occurrence: int
    line: int
    column: int
    where: str
    place: str
    nth: int
    around: str

    @property
    def key(self) -> str:
        """What tells it apart from all others, whatever becomes of the rest of the file."""
        return f"{self.path}:{self.operator}:{self.nth}:{self.place}"

    @property
    def name(self) -> str:
        """Digest of the key and of the function as it is: another function, another mutant."""
        return digest(self.key.encode(), self.around.encode())


def _places(tree: ast.Module) -> tuple[dict[int, str], list[tuple[tuple[int, int], tuple[int, int]]]]:
    """Per line the function that it is in, and from where to where nothing is mutated."""
    functions: dict[int, str] = {}
    left_out = []

    def visit(node: ast.AST, name: str) -> None:
        for child in ast.iter_child_nodes(node):
            inner = name
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                inner = f"{name}.{child.name}".lstrip(".")
                first = min(node.lineno for node in (child, *child.decorator_list))
                for line in range(first, (child.end_lineno or child.lineno) + 1):
                    functions[line] = inner
                # Tests run without numba's compiler, so its decorators say nothing.
                left_out.extend(d for d in child.decorator_list if "njit" in ast.unparse(d))
            visit(child, inner)

    visit(tree, "")
    for node in ast.walk(tree):
        # Annotations are not evaluated; what only a type checker imports neither.
        for field in ("annotation", "returns"):
            if isinstance(getattr(node, field, None), ast.expr):
                left_out.append(getattr(node, field))
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            left_out.append(node)
    spans = [
        ((n.lineno, n.col_offset - isinstance(n, ast.expr)), (n.end_lineno, n.end_col_offset))
        for n in left_out
    ]
    return functions, spans


def _named(
    positions: set[tuple[int, int]], source: str, functions: dict[int, str]
) -> dict[tuple[int, int], str]:
    """A name of each place: function, line and column in it, and of those alike the how many-th."""
    lines, alike, names = source.splitlines(), Counter[str](), {}
    for line, column in sorted(positions):
        text = lines[line - 1]
        within = column - len(text) + len(text.lstrip())
        name = f"{functions.get(line, '')}: {text.strip()}: {within}"
        alike[name] += 1
        names[line, column] = f"{name}: {alike[name]}"
    return names


def mutants_of(path: Path, package: Path) -> list[Mutant]:
    """
    All mutants of a file.

    Parameters
    ----------
    path, package : Path
      The file, and the package's folder that it lies in.

    Returns
    -------
    list of Mutant
    """
    source = path.read_text()
    functions, left_out = _places(ast.parse(source))
    nodes = list(ast_nodes(get_ast(source)))
    found = []
    for name, operator in operators().items():
        positions = [start for node in nodes for start, _ in operator.mutation_positions(node)]
        for occurrence, start in enumerate(positions):
            if not any(first <= start <= last for first, last in left_out):
                found.append((name, occurrence, start))
    names = _named({start for _, _, start in found}, source, functions)
    around: dict[str, list[str]] = {}
    for number, line in enumerate(source.splitlines(), start=1):
        around.setdefault(functions.get(number, ""), []).append(line)
    digests = {where: digest(*(line.encode() for line in lines)) for where, lines in around.items()}
    inner, times, made = str(path.relative_to(package)), Counter[tuple[str, str]](), []
    for name, occurrence, start in found:
        where, place = functions.get(start[0], ""), names[start]
        nth = times[name, place]
        times[name, place] += 1
        made.append(Mutant(inner, name, occurrence, *start, where, place, nth, digests[where]))
    return made


def mutated(mutant: Mutant, source: str) -> str:
    """The file's text with the change in it."""
    changed = mutate_code(source, operators()[mutant.operator], mutant.occurrence)
    if changed is None:
        raise LookupError(f"{mutant.key}: the file has no such place")
    # What is no Python would count as killed.
    ast.parse(changed)
    return changed


def changed_lines(old: str, new: str) -> tuple[str, str]:
    """The lines of two texts that differ, without the blanks around them."""
    lines, others = old.splitlines(), new.splitlines()
    first = next(
        (i for i, (a, b) in enumerate(zip(lines, others, strict=False)) if a != b),
        min(len(lines), len(others)),
    )
    last = 0
    while last < min(len(lines), len(others)) - first and lines[-1 - last] == others[-1 - last]:
        last += 1
    parts = (lines[first : len(lines) - last], others[first : len(others) - last])
    return " / ".join(line.strip() for line in parts[0]), " / ".join(line.strip() for line in parts[1])


def sample(mutants: dict[str, list[Mutant]], count: int, seed: int) -> list[Mutant]:
    """
    A random sample, in which each file has the share that it has of all places.

    A place is where something is changed; of the changes that can be made there, one is drawn. So an operator
    with many replacements does not crowd out others. A file's places have an order of their own, by a hash,
    and the first are drawn: where a file's share changes by one, one place comes or goes.

    Parameters
    ----------
    mutants : dict of list of Mutant
      Per file.
    count : int
      How many to draw.
    seed : int
      The same draws the same.

    Returns
    -------
    list of Mutant
      In random order, so that its first part is a sample as well.
    """

    def rank(of_place: list[Mutant], *more: object) -> bytes:
        text = "\0".join(map(str, (seed, of_place[0].path, of_place[0].place, *more)))
        return hashlib.sha256(text.encode()).digest()

    places: dict[str, list[list[Mutant]]] = {}
    for path, of_file in sorted(mutants.items()):
        at: dict[str, list[Mutant]] = {}
        for mutant in of_file:
            at.setdefault(mutant.place, []).append(mutant)
        places[path] = sorted(at.values(), key=rank)
    total = sum(map(len, places.values()))
    count = min(count, total)
    shares = {path: count * len(of_file) / total for path, of_file in places.items()}
    numbers = {path: int(share) for path, share in shares.items()}
    by_remainder = sorted(shares, key=lambda path: numbers[path] - shares[path])
    for path in by_remainder[: count - sum(numbers.values())]:
        numbers[path] += 1
    drawn = [of_place for path, of_file in places.items() for of_place in of_file[: numbers[path]]]
    return [
        min(enumerate(of_place), key=lambda numbered: rank(of_place, numbered[1].operator, numbered[0]))[1]
        for of_place in sorted(drawn, key=rank)
    ]
