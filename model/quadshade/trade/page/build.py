# SPDX-License-Identifier: Apache-2.0
"""
One HTML file from data files: no server, no network.

The page holds a copy of every data file, since a browser reads none beside a page opened from disk; what is
shown carries the file and the path that it comes from.
"""

from __future__ import annotations

import json
import shutil
from importlib.resources import files
from pathlib import Path
from typing import Any

from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_json, write_text
from quadshade.trade.page.papers import paper_tables
from quadshade.trade.page.summary import summary

REPORTS = {
    "stability": "make stability",
    "extremes": "make extremes",
    "continuity": "make continuity",
    "adapt": "make adapt",
    "density": "make density",
    "throughput": "make throughput",
    "hostspeed": "make hostspeed",
    "demo": "make readme",
    "cho": "make cho",
    "edges": "make edges",
    "faults": "make faults",
    "boardspeed": "make boardspeed",
}
"""Reports with a section of their own, by the stem of their JSON file, and the command that writes it."""

SCRIPTS = ("numbers.js", "trade.js", "pareto.js", "sections.js")
TRADE = "trade.json"


def _read_json(path: Path) -> dict[str, Any] | None:
    """A JSON file's content, None where there is no such file."""
    try:
        return json.loads(path.read_text()) if path.is_file() else None
    except ValueError as problem:
        raise QuadshadeError(f"{path} is no JSON: {problem}", "make it again") from None


def collect(folder: Path, reports: Path, resources: Path) -> None:
    """
    Copy what other commands wrote into ``folder/data``, and write what follows from it.

    Parameters
    ----------
    folder : Path
      The page's folder; sweeps stand in ``data/<scene>/`` already.
    reports : Path
      Folder of the reports: JSON files, and plots beside them as PNG or SVG.
    resources : Path
      Table of area and clock, ``synth/resources.json``.
    """
    data = folder / "data"
    data.mkdir(parents=True, exist_ok=True)
    for name in REPORTS:
        for old in (*data.glob(f"{name}.*"), *data.glob(f"{name}_*")):
            old.unlink()
        plots = (path for kind in ("png", "svg") for path in sorted(reports.glob(f"{name}*.{kind}")))
        for path in (reports / f"{name}.json", *plots):
            if path.is_file():
                shutil.copyfile(path, data / path.name)
    if resources.is_file():
        shutil.copyfile(resources, data / "resources.json")
    tables = paper_tables(_read_json(data / "hostspeed.json"), _read_json(data / "resources.json"))
    write_json(data / "papers.json", tables)
    sweeps = {path.parent.name: json.loads(path.read_text()) for path in sorted(data.glob(f"*/{TRADE}"))}
    write_json(data / "summary.json", {name: summary(content) for name, content in sweeps.items()})


def build_page(folder: Path, reports: Path, resources: Path, scenes: list[str]) -> Path:
    """
    Write the page.

    Parameters
    ----------
    folder : Path
      With a sweep in ``data/<scene>/`` for every scene.
    reports, resources : Path
      As for :func:`collect`.
    scenes : list of str
      Names of the sweeps' folders, in the order of the page.

    Returns
    -------
    Path
      ``folder/index.html``.

    Raises
    ------
    QuadshadeError
      There is no sweep for a scene, or a report is no JSON.
    """
    for scene in scenes:
        if not (folder / "data" / scene / TRADE).is_file():
            raise QuadshadeError(f"there is no {folder}/data/{scene}/{TRADE}", "run `quadshade trade`")
    collect(folder, reports, resources)
    data = folder / "data"
    names = [*(f"{scene}/{TRADE}" for scene in scenes), *sorted(path.name for path in data.glob("*.json"))]
    plots = sorted(f"data/{path.name}" for kind in ("png", "svg") for path in data.glob(f"*.{kind}"))
    content = {
        "files": {f"data/{name}": _read_json(data / name) for name in names},
        "scenes": [f"data/{scene}/{TRADE}" for scene in scenes],
        "plots": plots,
        "reports": REPORTS,
    }
    # "</" would end the script element.
    inlined = json.dumps(content, separators=(",", ":")).replace("</", "<\\/")
    parts = files("quadshade.trade.page")
    page = (parts / "page.html").read_text()
    page = page.replace("/*style*/", (parts / "page.css").read_text())
    page = page.replace("/*script*/", "\n".join((parts / name).read_text() for name in SCRIPTS))
    index = folder / "index.html"
    write_text(index, page.replace("/*data*/", inlined))
    return index
