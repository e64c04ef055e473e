# SPDX-License-Identifier: Apache-2.0
"""The reference of the Python packages: a page for each that names what is public in ``__all__``."""

from __future__ import annotations

import ast
from pathlib import Path, PurePosixPath

from scripts.docs.entity import ROOT

MODEL = ROOT / "model"
INDEX = PurePosixPath("docs/reference/python.md")


def python_pages() -> dict[PurePosixPath, str]:
    """The list of packages and a page for each, which mkdocstrings fills from the docstrings."""
    packages = public_packages()
    lines = ["# Python", "", "What each package's `__all__` names, written from the docstrings.", ""]
    lines += ["| package | what it does | names |", "| --- | --- | --- |"]
    pages = {}
    for name, (purpose, public) in packages.items():
        lines.append(f"| [`{name}`](python/{name}.md) | {purpose} | {', '.join(f'`{n}`' for n in public)} |")
        members = "".join(f"        - {member}\n" for member in public)
        pages[INDEX.parent / "python" / f"{name}.md"] = (
            f"# {name}\n\n::: {name}\n    options:\n      members:\n{members}"
        )
    return {INDEX: "\n".join(lines) + "\n", **pages}


def public_packages() -> dict[str, tuple[str, list[str]]]:
    """First sentence of the docstring and public names of every package that has ``__all__``."""
    found = {}
    for path in sorted(MODEL.rglob("__init__.py")):
        tree = ast.parse(path.read_text())
        names = _public_names(tree)
        if names:
            purpose = (ast.get_docstring(tree) or "").split("\n\n")[0]
            found[_module_name(path)] = (" ".join(purpose.split()).replace("``", "`"), names)
    return found


def _public_names(tree: ast.Module) -> list[str]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__":
            return [name for name in ast.literal_eval(node.value) if not name.startswith("__")]
    return []


def _module_name(path: Path) -> str:
    return ".".join(path.parent.relative_to(MODEL).parts)
