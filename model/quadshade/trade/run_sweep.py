# SPDX-License-Identifier: Apache-2.0
"""
A sweep over one scene: every point of a grid measured once, in parallel, and never again.

A point is written as soon as it is measured, so a run that was killed goes on where it stopped.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed

from quadshade.choices import COSTS
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically, write_bytes, write_json
from quadshade.trade.area import DEVICE, count_cells, no_tools
from quadshade.trade.grid import ALL, Grid, Point
from quadshade.trade.measure import HEAT_FULL, MEASURED, REFERENCE, Measured, measure, png
from quadshade.trade.pareto import mark_pareto
from quadshade.trade.store import forget_others, point_key, stage_digest, store, stored
from quadshade.trade.view import Stage, View, stage
from quadshade.trade.workers import workers

POINTS = "points"
NO_AREA = "--no-area leaves synthesis out"
"""The notice where nobody wants cells."""
CELLS = ("lut4", "ff", "bram", "dsp")
Stages = dict[tuple[str, str], Stage]
"""By subdivision and level of detail."""
Progress = Callable[[str, int, int], None]
"""Called with what is done (``points`` or ``cores``), how many of it are done, and of how many."""


@dataclass(frozen=True)
class Sweep:
    """
    A sweep's result, as it stands in ``trade.json``.

    Attributes
    ----------
    view : dict
      Settings of the scene.
    generics : dict
      Those that no point sets.
    device : str or None
      What cells were counted on; None where none were.
    notice : str
      Why cells were not counted; empty where they were.
    records : list of dict
      A point each, in the order of the grid, with paths of its pictures.
    reused : int
      How many points were measured before.
    """

    view: dict[str, Any]
    generics: dict[str, Any]
    device: str | None
    notice: str
    records: list[dict[str, Any]]
    reused: int

    def content(self) -> dict[str, Any]:
        """All but how it came about."""
        return {
            "view": self.view,
            "generics": self.generics,
            "device": self.device,
            "notice": self.notice,
            "heat_full": HEAT_FULL,
            "points": self.records,
        }


def sweep(
    view: View,
    grid: Grid,
    folder: Path,
    base: Formats | None = None,
    engine: str = "model",
    area: bool = True,
    device: str = DEVICE,
    jobs: int = -1,
    dask: str | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """
    Measure every point of a grid and write ``trade.json``, ``trade.csv`` and the pictures.

    Parameters
    ----------
    view : View
    grid : Grid
    folder : Path
      Made if need be. What was measured into it before is taken from there, if nothing that it depends on has
      changed.
    base : Formats, optional
      Generics that the points do not set.
    engine : str
    area : bool
      Count the cells of every core. Without the tools for that, ``notice`` says so.
    device : str
    jobs : int
      Processes, -1 for as many as there are cores.
    dask : str, optional
      Address of a Dask scheduler whose workers measure the points.
    progress : function, optional

    Returns
    -------
    Sweep

    Raises
    ------
    QuadshadeError
      Bad settings, a folder that cannot be written, no such scheduler.
    """
    base = Formats() if base is None else base
    tell = progress or (lambda *_: None)
    notice = no_tools(device) if area else NO_AREA
    # Everything that can be refused is refused before the work.
    configurations = [point.formats(base, view.num_lights) for point in grid]
    stages = _stages(view, grid, base)
    keys = _keys(view, grid, stages, base, engine)
    try:
        (folder / POINTS).mkdir(parents=True, exist_ok=True)
        reused = _measure_missing(stages, keys, folder / POINTS, base, engine, jobs, dask, tell)
        cells = {} if notice else _count_all(configurations, device, jobs, tell)
        references = _write_references(stages, folder)
        forget_others(folder / POINTS, set(keys.values()))
        records = []
        for point, formats in zip(grid, configurations, strict=True):
            record = stored(folder / POINTS, keys[point])
            if record is None:
                raise QuadshadeError(
                    f"{folder / POINTS / keys[point]} is gone", "run one sweep at a time there"
                )
            record |= {name: cells.get(formats, {}).get(name) for name in CELLS}
            drawn = record["refused"] is None
            record["picture"] = f"{POINTS}/{keys[point]}/picture.png" if drawn else None
            record["error_map"] = f"{POINTS}/{keys[point]}/error.png" if drawn else None
            record["reference"] = references[point.stage]
            if drawn and point.allowed is not None and not stages[point.stage].is_level:
                record["reference"] = f"{POINTS}/{keys[point]}/{REFERENCE}"
            records.append(record)
        mark_pareto(records)
        free = {n: v for n, v in base.generics().items() if n not in ("max_order", "frac_bits", "word_width")}
        result = Sweep(view.settings(), free, None if notice else device, notice, records, reused)
        _write(folder, result)
    except OSError as error:
        raise QuadshadeError(f"cannot write {folder}: {error.strerror or error}") from None
    return result


def _stages(view: View, grid: Grid, base: Formats) -> Stages:
    """Mesh and reference of every subdivision and level of detail."""
    projected = {lod: view.projected(base, lod) for lod in grid.lods}
    whole = projected[ALL] if ALL in projected else view.projected(base)
    return {
        (name, lod): stage(view, level, name, base, None if lod == ALL else whole)
        for name in grid.subdivisions
        for lod, level in projected.items()
    }


def _keys(view: View, grid: Grid, stages: Stages, base: Formats, engine: str) -> dict[Point, str]:
    """The folder of every point."""
    digests = {name: stage_digest(place) for name, place in stages.items()}
    return {point: point_key(point, view, digests[point.stage], base, engine) for point in grid}


def _measure_missing(
    stages: Stages,
    keys: dict[Point, str],
    folder: Path,
    base: Formats,
    engine: str,
    jobs: int,
    dask: str | None,
    tell: Progress,
) -> int:
    """Measure the points that are not there yet and keep each at once; how many were there."""
    missing = [point for point, key in keys.items() if stored(folder, key) is None]
    done = reused = len(keys) - len(missing)
    tell("points", done, len(keys))
    if missing:
        with workers(min(jobs, len(missing)), dask) as run:
            calls = (
                delayed(_measure_named)(point, keys[point], stages[point.stage], base, engine)
                for point in missing
            )
            for key, measured in run(calls):
                store(folder, key, measured)
                done += 1
                tell("points", done, len(keys))
    return reused


def _measure_named(point: Point, key: str, place: Stage, base: Formats, engine: str) -> tuple[str, Measured]:
    return key, measure(point, place, base, engine)


def _count_all(
    configurations: list[Formats], device: str, jobs: int, tell: Progress
) -> dict[Formats, dict[str, int]]:
    """Cells of every core that some point asks for; the tools are processes of their own."""
    wanted = list(dict.fromkeys(configurations))
    tell("cores", 0, len(wanted))
    cells = {}
    run = Parallel(n_jobs=min(jobs, len(wanted) or 1), prefer="threads", return_as="generator")
    for formats, counted in zip(wanted, run(delayed(count_cells)(f, device) for f in wanted), strict=True):
        cells[formats] = counted
        tell("cores", len(cells), len(wanted))
    return cells


def _write_references(stages: Stages, folder: Path) -> dict[tuple[str, str], str]:
    """The Phong-shaded picture of every subdivision, of levels of detail that of all triangles; its name."""
    names = {}
    for (subdivision, lod), place in stages.items():
        kind = subdivision.replace(":", "") if lod == ALL else "fine"
        names[subdivision, lod] = f"phong-{kind}.png"
        write_bytes(folder / names[subdivision, lod], png(place.reference))
    return names


def _write(folder: Path, result: Sweep) -> None:
    """``trade.json`` and ``trade.csv``, each whole or not at all."""
    columns: tuple[str, ...] = (
        "name",
        "shading",
        "order",
        "fraction",
        "subdivision",
        "lod",
        "fit",
        "word_width",
        "mesh_triangles",
        "triangles",
        "refused",
        *MEASURED,
        *CELLS,
        *(f"pareto_{cost}" for cost in COSTS),
        "picture",
        "error_map",
        "reference",
    )

    def write_rows(path: Path) -> None:
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
            writer.writeheader()
            for record in result.records:
                fronts = {f"pareto_{cost}": int(cost in record["pareto"]) for cost in COSTS}
                writer.writerow(record | fronts)

    write_json(folder / "trade.json", result.content())
    write_atomically(folder / "trade.csv", write_rows)
