# SPDX-License-Identifier: Apache-2.0
"""
Readers of mesh files from PyPI, and Quadshade's own, over the cases of the tests; writes
``docs/reports/mesh_readers.md``.

A case is right where the picture has its pixels in its colours, or where the reader refuses what has to be
refused. pip fetches the other readers into a temporary folder, apt the sample files; each reader has a
process of its own, as some crash.
"""

from __future__ import annotations

import json
import resource
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np

from quadshade.engine.tool_runner import run_to_end
from quadshade.files.markdown import markdown_table
from scripts.experiments.mesh_reader_adapters import ADAPTERS, OTHERS
from scripts.experiments.real_meshes import debian_files
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors
from tests.support.mesh_cases import Case, Colour
from tests.support.mesh_pictures import CASES, lit_pixels

REPORT = REPORTS / "mesh_readers.md"
OURS = "quadshade"
SAMPLES = "assimp-testmodels"
"""Debian's package of the formats' own sample files."""

MARKS = {
    "right": "✓",
    "refused": "refused",
    "wrong": "wrong",
    "unseen": "drawn",
    "crash": "crash",
    "none": "–",
}
KINDS = ("obj", "ply", "off", "stl", "glb", "gltf")
SECONDS, MEMORY = 30, 4 << 30
CLOSE = 2
"""Levels of a colour, of 255, that a reader may be off: some keep floats of 32 bits."""


def same_picture(got: dict[Colour, int], wanted: dict[Colour, int]) -> bool:
    """Whether pixels by colour are those wanted."""
    total: Counter[Colour] = Counter()
    for colour, count in got.items():
        close = [right for right in wanted if max(abs(np.subtract(colour, right))) <= CLOSE]
        total[close[0] if close else colour] += count
    return dict(total) == dict(wanted)


def judge(case: Case, reader: str, folder: Path) -> str:
    """What a reader makes of a case: a key of ``MARKS``."""
    kinds, read = ADAPTERS[reader]
    if case.name.rpartition(".")[2] not in kinds:
        return "none"
    path = case.write(folder)
    try:
        mesh = read(path)
        got = lit_pixels(mesh, case)
    except (Exception, SystemExit):  # noqa: BLE001 - readers raise whatever they like, meshio the latter
        return "right" if case.lit is None else "refused"
    if case.lit is None:
        return "unseen"
    return "right" if same_picture(got, dict(case.lit)) else "wrong"


def measure_surface(path: Path, reader: str) -> str:
    """Triangles and area of a sample file, as text to compare; how it ended else."""
    kinds, read = ADAPTERS[reader]
    if path.suffix.lower()[1:] not in kinds:
        return "none"
    try:
        corners = read(path).corners
    except (Exception, SystemExit) as error:  # noqa: BLE001 - as above
        reason = " ".join(str(error).replace(str(path), path.name).split())
        return f"refused {reason}"
    area = (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        / 2
    )
    return f"{area:.3e}"


def in_processes(reader: str, others: Path, option: str, names: list[str]) -> dict[str, str]:
    """Outcomes of files by name; a process that dies costs the file that it read, others go to the next."""
    results: dict[str, str] = {}
    while len(results) < len(names):
        left = [name for name in names if name not in results]
        with tempfile.TemporaryDirectory() as folder:
            listed, log = Path(folder) / "names.json", Path(folder) / "log"
            listed.write_text(json.dumps(left))
            command = [sys.executable, "-m", "scripts.experiments.mesh_readers", "--reader", reader]
            run_to_end(
                [*command, option, str(listed), "--log", str(log), "--others", str(others)], Path.cwd()
            )
            lines = log.read_text().splitlines() if log.exists() else []
        for line in lines:
            name, _, outcome = line.rpartition("\t")
            results[name] = outcome
        if len(lines) < len(left):
            results[left[len(lines)]] = "crash"
    return results


def work(reader: str, names: list[str], log: Path, samples: bool) -> None:
    """The process's part: outcomes, each written as soon as it is there; a file has 30 seconds and 4 GiB."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    with log.open("w") as out, tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(names):
            signal.alarm(SECONDS)
            if samples:
                outcome = measure_surface(Path(name), reader)
            else:
                place = Path(folder) / str(number)
                place.mkdir()
                outcome = judge(CASES[name], reader, place)
            out.write(f"{name}\t{outcome}\n")
            out.flush()


def fetch_readers(folder: Path) -> dict[str, str]:
    """The other readers that pip could fetch, with their versions."""
    found = {}
    for reader, package in OTHERS.items():
        command = [
            sys.executable,
            "-m",
            "pip",
            "install",
            "-q",
            "--no-deps",
            "--target",
            str(folder),
            *package,
        ]
        if run_to_end(command, folder).returncode == 0:
            found[reader] = package[0]
    return found


def fetch_samples(folder: Path) -> list[Path]:
    """Debian's sample files; none where apt cannot fetch them."""
    return [path for path in debian_files(SAMPLES, folder) if path.suffix.lower()[1:] in KINDS]


def by_kind(results: dict[str, dict[str, str]]) -> Iterator[list[str]]:
    """Rows of right cases over all, by format."""
    for kind in KINDS:
        names = [name for name in CASES if name.endswith(f".{kind}")]
        cells = []
        for outcomes in results.values():
            given = [outcomes[name] for name in names if outcomes[name] != "none"]
            cells.append(f"{given.count('right')} of {len(given)}" if given else "–")
        yield [kind, *cells]


def report(numbers: dict) -> str:
    """The report's text, from nothing but its numbers."""
    results: dict[str, dict[str, str]] = numbers["cases"]
    readers = list(results)
    wrong = [name for name in CASES if any(results[r][name] not in ("right", "none") for r in readers)]
    rows = [[name, *(MARKS[results[reader][name]] for reader in readers)] for name in wrong]
    about = f"""
        {len(CASES)} small files of the tests, valid and damaged, through readers from PyPI
        ({", ".join(numbers["packages"])}) and through Quadshade's own. *Right* is a picture with the case's
        pixels in the case's colours, or an error where the file is damaged or names what is missing: nothing
        may be dropped in silence. Other readers are not written for this rule.
        `{command_line("mesh_readers")}`
        """
    why = """
        No reader is right on all cases of any format, and most of what is wrong is silent: a colour that is
        dropped, an index out of range, half of a file. tinyobjloader comes nearest, for OBJ alone; it keeps
        positions as 32-bit floats, where OBJ has decimals, takes NaN for a coordinate, and refuses comments
        and backslashes behind data. Assimp asks for the memory that a file's header promises to need,
        whatever the file's size. pygltflib reads a glTF's JSON and leaves accessors to its user; plyfile is
        under the GPL; impasse and pyassimp are Assimp again. So a small reader a format is in
        `quadshade.scene.readers`, with NumPy, Pillow for textures and mapbox_earcut for concave polygons.
        """
    marks = """
        *refused*: an error for a file that is valid; *drawn*: no error for one that is not; *wrong*: another
        picture; *crash*: the process died, or took 30 seconds; –: a format that the reader has not.
        """
    text = [
        f"{LICENCE}\n# Readers of mesh files\n",
        f"{paragraph(about)}\n",
        f"{markdown_table(('right', *readers), list(by_kind(results)))}\n",
        *(sample_tables(numbers["samples"]) if numbers["samples"] else []),
        "## Why the readers are Quadshade's own\n",
        f"{paragraph(why)}\n",
        "## Cases that one of them gets wrong\n",
        f"{paragraph(marks)}\n",
        markdown_table(("case", *readers), rows),
    ]
    return "\n".join(text) + "\n"


def sample_tables(samples: dict[str, dict[str, str]]) -> list[str]:
    """What the readers make of the sample files."""
    ours = samples[OURS]
    about = f"""
        The {len(ours)} files of Debian's {SAMPLES}, for which nobody has written down what is right: the area
        of the surface that each reader makes of them, against Quadshade's.
        """
    header = ("reader", "same area", "another", "it refuses", "Quadshade refuses", "both", "crash")
    refused = [
        [Path(name).name, ", ".join(others), ours[name].removeprefix(f"refused {Path(name).name}: ")]
        for name in ours
        if ours[name].startswith("refused")
        and (others := [reader for reader, outcomes in samples.items() if outcomes[name][:1].isdecimal()])
    ]
    return [
        "## The formats' own sample files\n",
        f"{paragraph(about)}\n",
        f"{markdown_table(header, list(compare_samples(samples)))}\n",
        "Files that Quadshade refuses and another reader takes:\n",
        f"{markdown_table(('file', 'taken by', 'why Quadshade refuses it'), refused)}\n",
    ]


def compare_samples(samples: dict[str, dict[str, str]]) -> Iterator[list[str]]:
    """Rows of how many sample files each reader shows as Quadshade does."""
    ours = samples[OURS]
    for reader, outcomes in samples.items():
        if reader == OURS:
            continue
        count: Counter[str] = Counter()
        for name, outcome in outcomes.items():
            if outcome == "none":
                continue
            pair = outcome.startswith("refused"), ours[name].startswith("refused")
            key = {(True, True): "both", (True, False): "it", (False, True): "ours"}.get(pair, "another")
            if outcome == "crash":
                key = "crash"
            elif key == "another" and abs(float(outcome) - float(ours[name])) <= 2e-3 * float(ours[name]):
                key = "same"
            count[key] += 1
        yield [reader, *(str(count[key]) for key in ("same", "another", "it", "ours", "both", "crash"))]


@click.command(help=__doc__)
@click.option("--reader", hidden=True)
@click.option("--cases", "listed", hidden=True, type=click.Path(path_type=Path))
@click.option("--samples", "sampled", hidden=True, type=click.Path(path_type=Path))
@click.option("--log", hidden=True, type=click.Path(path_type=Path))
@click.option("--others", hidden=True, type=click.Path(path_type=Path))
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(
    reader: str | None,
    listed: Path | None,
    sampled: Path | None,
    log: Path | None,
    others: Path | None,
    output: Path,
) -> None:
    if reader is not None and log is not None and others is not None:
        sys.path.append(str(others))
        names = json.loads((listed or sampled or Path()).read_text())
        work(reader, names, log, listed is None)
        return
    with tempfile.TemporaryDirectory() as folder:
        place, models = Path(folder) / "readers", Path(folder) / "samples"
        place.mkdir()
        models.mkdir()
        packages = fetch_readers(place)
        readers = [OURS, "trimesh", *packages]
        files = [str(path) for path in fetch_samples(models)]
        cases = {name: in_processes(name, place, "--cases", list(CASES)) for name in readers}
        samples = {name: in_processes(name, place, "--samples", files) for name in readers} if files else {}
        samples = {
            reader: {str(Path(name).relative_to(models)): outcome for name, outcome in outcomes.items()}
            for reader, outcomes in samples.items()
        }
    numbers = {"packages": ["trimesh", *packages.values()], "cases": cases, "samples": samples}
    write_report(output, report(numbers), numbers)
    click.echo("\n".join(report(numbers).splitlines()[:20]))


if __name__ == "__main__":
    main()
