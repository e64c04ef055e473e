# SPDX-License-Identifier: Apache-2.0
"""
Speed of the host on one core: set-ups, the path from mesh to packets, the golden model; and its memory.

Everything is measured beside a plain Python loop of the same thing: the same functions with compilation off
(NUMBA_DISABLE_JIT=1, in a second process), which must give the same words, and the scalar golden model.
Writes docs/reports/hostspeed.md and hostspeed.json.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table

from quadshade.contract.formats import QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine.tool_runner import run_to_end
from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from quadshade.golden.compiled import draw_fast
from quadshade.golden.core.raster_core import draw_scalar
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import sample
from scripts.experiments.report_writer import (
    REPORTS,
    ROOT,
    command_line,
    met,
    output_option,
    write_report,
)
from scripts.experiments.setup_speed import (
    EXPLAINED,
    bounds,
    least_seconds,
    processor,
    setup_tables,
    setups,
    what_binds,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "hostspeed.md"
SCREEN = 1024
PLAIN_TRIANGLES = 200
SETUP_ROUNDS = 2000
TARGETS = {
    "host path": 300e3,
    "golden model": 20e6,
    "gibibytes": 4.0,
}
STAGES = ("project", "sample", "set up", "pack")


def fastest(work: Callable[[], object], repeats: int) -> float:
    """Least seconds of processor time that one call took."""
    return least_seconds({"": work}, repeats)[""]


def host_path(scene: str, cull: bool, repeats: int) -> dict:
    """Seconds of each stage, and what passed."""
    formats, mesh = Formats(), load_scene(scene)
    camera = parse_camera("from=0,0,1", mesh)
    projected = project(mesh, camera, SCREEN, SCREEN, formats, cull)
    triangles = sample(projected, formats=formats)
    primitives = setup_triangles(triangles, formats)
    words = pack(primitives, formats)
    works = (
        lambda: project(mesh, camera, SCREEN, SCREEN, formats, cull),
        lambda: sample(projected, formats=formats),
        lambda: setup_triangles(triangles, formats),
        lambda: pack(primitives, formats),
    )
    return {
        "faces": len(mesh),
        "triangles": len(projected),
        "packets": len(primitives),
        "words": hashlib.sha256(words.tobytes()).hexdigest(),
        "seconds": {stage: fastest(work, repeats) for stage, work in zip(STAGES, works, strict=True)},
    }


def golden_frame(count: int) -> tuple[np.ndarray, Formats]:
    """Words of random triangles of some 30 pixels, quadratic RGB with depth, on 640 x 480."""
    rng = np.random.default_rng(1)
    size = np.array([640, 480])
    vertices = np.clip(rng.uniform(0, 1, (count, 1, 2)) * size + rng.uniform(-10, 10, (count, 3, 2)), 0, size)
    formats = Formats(stream_width=128)
    triangles = ScreenTriangles(
        *size.tolist(),
        np.rint(vertices * 256).astype(np.int64),
        rng.uniform(0, 255, (count, 3, 6)),
        np.full((count, 3), QUADRATIC),
        rng.uniform(0, 65535, (count, 3)),
        ("r", "g", "b"),
    )
    return pack(setup_triangles(triangles, formats), formats), formats


def golden_model(count: int, repeats: int) -> dict:
    """Pixels per second of the compiled model, clocks included, and of the scalar one."""
    words, formats = golden_frame(count)
    drawn = draw_fast(words, formats)
    plain_words, _ = golden_frame(PLAIN_TRIANGLES)
    plain = draw_scalar(plain_words, formats)
    same = draw_fast(plain_words, formats)
    if [pixel.value for pixel in plain] != [tuple(value) for value in same.value.tolist()]:
        raise QuadshadeError("the scalar and the compiled model differ", "this is a bug: please report it")
    return {
        "triangles": count,
        "pixels": len(drawn.x),
        "clocks": drawn.clocks,
        "rate": len(drawn.x) / fastest(lambda: draw_fast(words, formats), repeats),
        "plain": len(plain) / fastest(lambda: draw_scalar(plain_words, formats), 1),
    }


def peak_memory(stacks: int, slices: int, *options: str) -> dict:
    """Peak resident memory, wall-clock and processor seconds of ``quadshade render``, every face drawn."""
    program = (
        "import resource, time\nfrom quadshade.cli.main import main\n"
        "try: main()\nfinally: print(time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    scene, size = f"sphere:{stacks}x{slices}", f"{SCREEN}x{SCREEN}"
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", program, "render", scene, "-o", f"{folder}/out.png"]
        command += ["--engine", "model", "--size", size, "--no-cull", *options]
        start = time.perf_counter()
        done = run_to_end(command, ROOT)
        seconds = time.perf_counter() - start
    if done.returncode:
        raise QuadshadeError(f"quadshade render {scene} failed: {done.stderr.strip()}")
    return {
        "scene": scene,
        "triangles": 2 * slices * (stacks - 1),
        "gibibytes": int(done.stdout.split()[-1]) / 2**20,
        "seconds": seconds,
        "processor_seconds": float(done.stdout.split()[-2]),
        "notices": done.stderr.strip().splitlines(),
    }


def plain_loops(scene: str) -> dict:
    """What the same functions do with compilation off: run in a process of its own."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "scripts.experiments.host_speed", "--plain", "--plain-scene", scene]
    done = run_to_end(command, ROOT, environment=environment)
    if done.returncode:
        raise QuadshadeError(f"the plain loops failed: {done.stderr.strip()}")
    return json.loads(done.stdout)


def measure(scene: str, plain_scene: str, golden: int, slices: int, repeats: int) -> dict:
    """All numbers of the report."""
    plain = plain_loops(plain_scene)
    compiled = host_path(plain_scene, False, 1)
    if compiled["words"] != plain["host_path"]["words"]:
        raise QuadshadeError("compiled and plain set-up differ", "this is a bug: please report it")
    return {
        "load": round(os.getloadavg()[0], 1),
        "processor": processor(),
        **setups(SETUP_ROUNDS, 4 * repeats),
        "bounds": bounds(SETUP_ROUNDS, 4 * repeats),
        "host_path": {name: host_path(scene, name == "culled", repeats) for name in ("all", "culled")},
        "golden": golden_model(golden, 2 * repeats),
        "memory": [peak_memory(stacks, slices) for stacks in (251, 501, 1001)],
        "plain": plain,
    }


def total_rate(path: dict, what: str = "triangles") -> float:
    """Triangles (or faces) per second through all stages."""
    return path[what] / sum(path["seconds"].values())


def sections(results: dict) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
    """Title, header and rows of every table of the report."""
    plain = results["plain"]
    found = setup_tables(results)

    path, slow = results["host_path"], plain["host_path"]
    rows = []
    for stage in (*STAGES, "whole path"):
        seconds, slow_seconds = (
            sum(p["seconds"].values()) if stage == "whole path" else p["seconds"][stage]
            for p in (path["all"], slow)
        )
        rate, slow_rate = path["all"]["triangles"] / seconds, slow["triangles"] / slow_seconds
        goal = met(rate, TARGETS["host path"]) if stage == "whole path" else ""
        rows.append((stage, f"{1e6 / rate:.3f}", f"{rate:,.0f}", f"{rate / slow_rate:,.0f}", goal))
    header = "stage", "µs a triangle", "triangles a second", "to a plain loop", "target"
    found.append(("Host path", header, rows))

    header = "culling", "faces in", "triangles set up", "packets", "triangles a second", "faces a second"
    rows = [
        (
            {"all": "off", "culled": "on"}[name],
            *(f"{p[key]:,}" for key in ("faces", "triangles", "packets")),
            f"{total_rate(p):,.0f}",
            f"{total_rate(p, 'faces'):,.0f}",
        )
        for name, p in path.items()
    ]
    found.append(("Faces and triangles", header, rows))

    golden = results["golden"]
    header = "triangles", "pixels", "clocks predicted", "million pixels a second", "to a plain loop", "target"
    cells = (
        f"{golden['triangles']:,}",
        f"{golden['pixels']:,}",
        f"{golden['clocks']:,}",
        f"{golden['rate'] / 1e6:.1f}",
    )
    goal = met(golden["rate"] / 1e6, TARGETS["golden model"] / 1e6)
    found.append(("Golden model", header, [(*cells, f"{golden['rate'] / golden['plain']:,.0f}", goal)]))

    header = "scene", "triangles", "peak GiB", "bytes a triangle", "seconds, start included", "target"
    first = results["memory"][0]
    rows = []
    for run in results["memory"]:
        more = run["gibibytes"] - first["gibibytes"], run["triangles"] - first["triangles"]
        slope = f"{more[0] * 2**30 / more[1]:,.0f}" if more[1] else ""
        cells = (
            f"{run['scene']}",
            f"{run['triangles']:,}",
            f"{run['gibibytes']:.2f}",
            slope,
            f"{run['seconds']:.1f}",
        )
        rows.append((*cells, met(run["gibibytes"], TARGETS["gibibytes"], most=True)))
    return [*found, ("Memory", header, rows)]


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    path = f"`{results['scene']}` on {SCREEN} x {SCREEN}"
    explained = {
        "Set-ups": EXPLAINED,
        "What binds the set-ups": what_binds(results),
        "Host path": f"""
Transform, light six points, set up and quantise, pack: {path}, quadratic RGB with
depth, default light and camera, culling off. A triangle counts where it has an area on the screen.
""",
        "Faces and triangles": "A triangle that covers no pixel centre is set up, but has no packet.",
        "Golden model": "640 x 480, quadratic RGB with depth, 128-bit stream; clock prediction included.",
        "Memory": f"""
`quadshade render --engine model --no-cull --size {SCREEN}x{SCREEN}`, in a process of its own. Bytes a
triangle are those beyond the first row.
""",
    }
    head = f"""
# Host speed

Written by `{results["command"]}`
(`make hostspeed`). Rates are of one core: the least processor time of several repetitions, compilation not
counted; on {results["processor"]}, at a load of {results["load"]}.
The plain loop is the same code with compilation off,
or the scalar golden model, measured in the same run, with the same words and pixels.
"""
    parts = [head.strip()]
    for title, header, rows in sections(results):
        parts.append(f"## {title}\n{explained[title].strip()}\n\n{markdown_table(header, rows)}")
    return "\n\n".join(parts) + "\n"


@click.command()
@click.option("--scene", default="sphere:317x317", show_default=True, help="Generated mesh of the host path.")
@click.option("--plain-scene", default="sphere:690", show_default=True, help="The same for plain loops.")
@click.option("--golden", default=10_000, show_default=True, help="Triangles of the golden model's frame.")
@click.option("--slices", default=500, show_default=True, help="Slices of the spheres of up to 1001 stacks.")
@click.option("--repeats", default=7, show_default=True, help="Repetitions, of which the fastest counts.")
@output_option(REPORT)
@click.option("--plain", is_flag=True, hidden=True, help="Print what runs with compilation off.")
@one_line_errors(REPORT.stem)
def main(
    scene: str, plain_scene: str, golden: int, slices: int, repeats: int, output: Path, plain: bool
) -> None:
    """Measure the host's speed on one core and write the tables."""
    if plain:
        print(json.dumps({**setups(1, 1), "host_path": host_path(plain_scene, False, 1)}))
        return
    options = {"scene": scene, "plain_scene": plain_scene, "golden": golden, "slices": slices}
    command = command_line("host_speed", **options, repeats=repeats)
    results = {"command": command, "scene": scene} | measure(scene, plain_scene, golden, slices, repeats)
    console = Console()
    console.width = max(console.width, 120)
    for title, header, rows in sections(results):
        shown = Table(*header, title=title)
        for row in rows:
            shown.add_row(*row)
        console.print(shown)
    write_report(output, report(results), results)


if __name__ == "__main__":
    main()
