# SPDX-License-Identifier: Apache-2.0
"""The site: pages of the repository and generated ones put together, and MkDocs run over them."""

from __future__ import annotations

import logging
import re
import shutil
from collections.abc import Callable
from pathlib import Path, PurePosixPath
from typing import Any

from mkdocs.commands.build import build
from mkdocs.config import load_config

from scripts.docs.command_line import command_line_page
from scripts.docs.entity import ROOT, Unit, units
from scripts.docs.links import IMAGES, convert, place_of, repository_page, source_page, title_of
from scripts.docs.python_pages import python_pages
from scripts.docs.unit_page import PAGES as UNIT_PAGES
from scripts.docs.unit_page import STAGES, unit_page, units_page

SECTIONS = ("tutorial", "guide", "reference", "explanation", "reports")
"""Folders of ``docs/``, in the order of the site's tabs."""

PROJECT = [PurePosixPath(name) for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
"""Pages outside ``docs/`` that have a place in the navigation."""

HEADINGS = {"python": "Python packages"}
"""Of folders in those, where it is not the folder's name."""

WANTED_DIAGRAM = re.compile(r"<!-- timing diagram: (\w+) -->")
START = PurePosixPath("docs/README.md")


def build_site(output: Path, diagram_of: Callable[[Unit], str]) -> None:
    """
    Build the whole site; a warning of MkDocs is an error.

    Parameters
    ----------
    output : Path
      The site's folder.
    diagram_of : callable
      A unit's timing diagram, as Markdown.

    Raises
    ------
    FileNotFoundError
      A page links to a file that is not there.
    mkdocs.exceptions.Abort
      MkDocs warned of something.
    """
    pages = all_pages(generated_pages(diagram_of), diagram_of)
    sources = output.with_name(f"{output.name}_sources")
    write_sources(pages, sources)
    logging.basicConfig(format="docs: %(levelname)s: %(message)s", level=logging.WARNING)
    config = load_config(
        str(ROOT / "mkdocs.yml"),
        docs_dir=str(sources),
        site_dir=str(output),
        nav=navigation(pages),
        strict=True,
    )
    config.plugins.on_startup(command="build", dirty=False)
    try:
        build(config)
    finally:
        config.plugins.on_shutdown()


def generated_pages(diagram_of: Callable[[Unit], str]) -> dict[PurePosixPath, str]:
    """Pages that are written from sources, by the place where they would stand in the repository."""
    all_units = units()
    pages = {PurePosixPath("docs/reference/cli.md"): command_line_page()}
    pages |= python_pages()
    pages[PurePosixPath(UNIT_PAGES, "README.md")] = units_page(all_units)
    for unit in all_units.values():
        pages[PurePosixPath(UNIT_PAGES, f"{unit.name}.md")] = unit_page(unit, all_units, diagram_of(unit))
    return pages


def all_pages(
    generated: dict[PurePosixPath, str], diagram_of: Callable[[Unit], str]
) -> dict[PurePosixPath, str]:
    """
    Every page of the site with its links as the site has them, and every image with no text.

    Parameters
    ----------
    generated : dict
      Pages by their places; they replace those that stand there.
    diagram_of : callable
      The diagram that a page asks for by the comment ``<!-- timing diagram: unit -->``.
    """
    all_units = units()
    wanted = set(generated) | {path for path in PROJECT if (ROOT / path).is_file()}
    wanted |= {PurePosixPath(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md")}
    pages: dict[PurePosixPath, str] = {}
    while wanted - set(pages):
        for path in sorted(wanted - set(pages)):
            if path in generated:
                pages[path] = convert(generated[path], path, wanted)
            elif path.suffix == ".md":
                pages[path] = WANTED_DIAGRAM.sub(
                    lambda found: diagram_of(all_units[found[1]]), repository_page(path, wanted)
                )
            else:
                pages[path] = "" if path.suffix in IMAGES else source_page(path)
    return pages


def write_sources(pages: dict[PurePosixPath, str], folder: Path) -> None:
    """What MkDocs reads: the pages, the images, and what the theme needs beside its own."""
    shutil.rmtree(folder, ignore_errors=True)
    for path, text in pages.items():
        place = folder / place_of(path)
        place.parent.mkdir(parents=True, exist_ok=True)
        if text:
            place.write_text(text)
        else:
            shutil.copyfile(ROOT / path, place)
    shutil.copytree(Path(__file__).parent / "assets", folder / "assets")


def navigation(pages: dict[PurePosixPath, str]) -> list[Any]:
    """MkDocs' navigation: the start page, a tab for each folder of ``docs/``, the project's own pages."""
    start = [{"Start": str(place_of(START))}] if START in pages else []
    tabs = [{folder.capitalize(): _folder(PurePosixPath("docs", folder), pages)} for folder in SECTIONS]
    project = [_entry(path, pages) for path in PROJECT if path in pages]
    return [*start, *(tab for tab in tabs if all(tab.values())), {"Project": project}]


def _folder(folder: PurePosixPath, pages: dict[PurePosixPath, str]) -> list[Any]:
    """Entries of a folder's pages, those of folders in it below their own heading."""
    inside = [path for path in pages if path.suffix == ".md" and path.is_relative_to(folder)]
    entries = [_entry(path, pages) for path in _in_order(inside, pages) if path.parent == folder]
    for below in dict.fromkeys(path.parent for path in sorted(inside) if path.parent.parent == folder):
        if below == UNIT_PAGES:
            entries.append({"RTL units": _units(pages)})
        else:
            members = [_entry(path, pages) for path in _in_order(inside, pages) if path.parent == below]
            heading = HEADINGS.get(below.name, below.name)
            entries += [{heading: members}] if members[1:] else members
    return entries


def _units(pages: dict[PurePosixPath, str]) -> list[Any]:
    """The units' list, then their pages by the folders of ``rtl/``."""
    entries: list[Any] = [str(place_of(PurePosixPath(UNIT_PAGES, "README.md")))]
    for stage in STAGES:
        members = [unit.name for unit in units().values() if unit.stage == stage]
        listed = [_entry(PurePosixPath(UNIT_PAGES, f"{name}.md"), pages) for name in members]
        entries += [{f"rtl/{stage}": listed}] if stage else listed
    return entries


def _in_order(paths: list[PurePosixPath], pages: dict[PurePosixPath, str]) -> list[PurePosixPath]:
    """A folder's own page first, then as the start page lists them, then by name."""
    listed = re.findall(r"\]\(([^)#\s]+\.md)", pages.get(START, ""))
    rank = {PurePosixPath("docs", target): index for index, target in reversed(list(enumerate(listed)))}
    return sorted(paths, key=lambda path: (path.name != "README.md", rank.get(path, len(listed)), path))


def _entry(path: PurePosixPath, pages: dict[PurePosixPath, str]) -> dict[str, str]:
    """A page's title and place."""
    return {title_of(pages[path]): str(place_of(path))}
