# SPDX-License-Identifier: Apache-2.0
"""What all experiments do alike: the report, its numbers, and the command that wrote them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from textwrap import fill
from typing import Any

import click

from quadshade.files.atomic import write_json, write_text

ROOT = Path(__file__).resolve().parents[2]
REPORTS = ROOT / "docs" / "reports"
LICENCE = "<!-- SPDX-License-Identifier: Apache-2.0 -->"
COLUMNS = 110


def command_line(module: str, **options: object) -> str:
    """
    The command that repeats a run.

    Parameters
    ----------
    module : str
      Below ``scripts.experiments``.
    options : object
      By name, an underscore for a hyphen; a float without needless digits, a list as one option an entry.

    Returns
    -------
    str
    """
    words = [f"python -m scripts.experiments.{module}"]
    for name, value in options.items():
        for entry in value if isinstance(value, list | tuple) else [value]:
            shown = f"{entry:g}" if isinstance(entry, float) else str(entry)
            words += [f"--{name.replace('_', '-')}", shown]
    return " ".join(words)


def paragraph(text: str) -> str:
    """Text in lines of 110 columns."""
    return fill(" ".join(text.split()), COLUMNS)


def met(value: float, target: float, most: bool = False) -> str:
    """A target's cell."""
    good = value <= target if most else value >= target
    return f"{'≤' if most else '≥'} {target:,.10g} {'met' if good else 'MISSED'}"


def rows_as_json(content: Any, indent: str = "") -> str:
    """JSON in which a list or an object that holds only plain values stands on one line."""
    entries = content.values() if isinstance(content, dict) else content if isinstance(content, list) else ()
    if not any(isinstance(entry, dict | list) for entry in entries):
        return json.dumps(content)
    further = indent + " "
    inner = [rows_as_json(entry, further) for entry in entries]
    if isinstance(content, dict):
        inner = [f"{json.dumps(key)}: {text}" for key, text in zip(content, inner, strict=True)]
    opening, closing = "{}" if isinstance(content, dict) else "[]"
    return f"{opening}\n{further}" + f",\n{further}".join(inner) + f"\n{indent}{closing}"


def output_option(report: Path) -> Callable[[Any], Any]:
    """The option ``--output``: another place for a report, its numbers and its plots."""
    path = click.Path(path_type=Path, dir_okay=False)
    return click.option("--output", default=report, type=path, help="Report to write.")


def write_report(report: Path, text: str, numbers: Any = None) -> None:
    """
    Write a report, and its numbers as JSON beside it, each whole or not at all.

    Parameters
    ----------
    report : Path
      The Markdown file.
    text : str
    numbers : optional
      What JSON can hold; for an experiment whose report holds all of them, none.

    Raises
    ------
    QuadshadeError
      A file cannot be written.
    """
    report.parent.mkdir(parents=True, exist_ok=True)
    if numbers is not None:
        write_text(report.with_suffix(".json"), rows_as_json(numbers) + "\n")
    write_text(report, text)


keep_option = click.option(
    "--keep",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of finished meshes: an interrupted run goes on with the next. Empty it for other options.",
)


def kept(folder: Path | None, name: str, make: Callable[[], Any]) -> Any:
    """What is made of a mesh, or what a run before made of it and kept in a folder."""
    if folder is None:
        return make()
    path = folder / f"{name.replace(':', '_')}.json"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        write_json(path, make())
    return json.loads(path.read_text())
