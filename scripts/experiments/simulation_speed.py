#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Clock cycles per second of the core in GHDL and in Verilator, side by side on the same scene.

Verilator draws the scene many times over, so that both run for seconds. Cycles are counted per second of
processor time, as other programs may be running; what an empty stream takes (start, elaboration) is taken off
for both. Writes docs/reports/simspeed.md; exit code 1 if the pixels differ or the ratio is too low.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import click
import numpy as np
from rich.console import Console

from quadshade.contract.formats import Formats
from quadshade.engine.draw import draw_words
from quadshade.engine.ghdl import analyse
from quadshade.engine.sources import repository_root
from quadshade.engine.tool_runner import run_tool
from quadshade.engine.verilator import build_verilator
from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from quadshade.golden.compiled import EmittedPixels
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import DEFAULT_LIGHTS, Material, sample
from scripts.experiments.report_writer import REPORTS, command_line, output_option, write_report
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "simspeed.md"
LEAST_RATIO = 100


@dataclass(frozen=True)
class Run:
    """
    One engine's run.

    Attributes
    ----------
    engine : str
    cycles : int
    elapsed, processor, start : float
      Seconds by the clock; of the processor, for the simulator; of those, what an empty stream takes.
    """

    engine: str
    cycles: int
    elapsed: float
    processor: float
    start: float

    @property
    def seconds(self) -> tuple[float, float, float]:
        """By the clock, of the processor, of these to start."""
        return self.elapsed, self.processor, self.start

    @property
    def rate(self) -> float:
        """Cycles a second of processor time."""
        return self.cycles / (self.processor - self.start)


def timed(work: Callable[[], Any]) -> tuple[Any, float, float]:
    """What a function returns, seconds by the clock, and processor seconds of the programs it ran."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    result = work()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return result, perf_counter() - begin, processor


def scene_words(scene: str, size: int, formats: Formats) -> np.ndarray:
    """Set-up words of a scene in quadratic shading."""
    mesh = load_scene(scene)
    projected = project(mesh, parse_camera("from=0,0,1", mesh), size, size, formats)
    triangles = sample(projected, "quadratic", DEFAULT_LIGHTS, Material(), formats)
    return pack(setup_triangles(triangles, formats), formats)


def measure(engine: str, words: np.ndarray, formats: Formats) -> tuple[EmittedPixels, Run]:
    """Draw with an engine that is compiled already."""
    _, _, start = timed(lambda: draw_words(words[:0], formats, engine))
    drawn, elapsed, processor = timed(lambda: draw_words(words, formats, engine))
    return drawn, Run(engine, drawn.clocks, elapsed, processor, start)


def check_same(once: EmittedPixels, often: EmittedPixels) -> None:
    """Raise where the first copy of the scene is not what the other engine drew."""
    for name in ("packet", "x", "y", "value"):
        one = getattr(once, name)
        if not np.array_equal(one, getattr(often, name)[: len(one)]):
            raise QuadshadeError(f"the engines differ in {name}", "this is a bug: please report it")


def versions() -> str:
    """The simulators' versions, and how many processors there are."""
    names = [run_tool([tool, "--version"], Path.cwd()).splitlines() for tool in ("ghdl", "verilator", "g++")]
    ghdl, verilator, compiler = names
    back_end = next((line.strip() for line in ghdl if "code generator" in line), "")
    return f"{ghdl[0]}, {back_end}; {verilator[0]}; {compiler[0]}; {os.cpu_count()} processors"


@click.command(help=__doc__)
@click.option("--scene", default="sphere:690", show_default=True)
@click.option("--size", default=512, show_default=True, help="Pixels a side.")
@click.option("--copies", default=50, show_default=True, help="How often Verilator draws the scene.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scene: str, size: int, copies: int, output: Path) -> None:
    console = Console()
    formats = Formats()
    root = repository_root()
    words = scene_words(scene, size, formats)
    with tempfile.TemporaryDirectory() as scratch, console.status("compiling for Verilator"):
        _, elapsed, compiled = timed(lambda: build_verilator(formats, Path(scratch)))
        build_verilator(formats)
    analyse(root)
    with console.status("simulating in GHDL"):
        once, ghdl = measure("ghdl", words, formats)
    with console.status("simulating in Verilator"):
        often, verilator = measure("verilator", np.tile(words, copies), formats)
    check_same(once, often)
    ratio = verilator.rate / ghdl.rate
    worth_it = compiled * ghdl.rate / 1000
    header = ("engine", "cycles", "seconds", "processor seconds", "of these, start")
    rows = [
        (run.engine, run.cycles, *(f"{seconds:.2f}" for seconds in run.seconds), f"{run.rate:,.0f}")
        for run in (ghdl, verilator)
    ]
    body = f"""\
{markdown_table((*header, "cycles per processor second"), rows)}

Verilator is **{ratio:.0f} times** as fast as GHDL (at least {LEAST_RATIO} is asked for).
Compiling for Verilator, not counted above, took {elapsed:.1f} s ({compiled:.1f} s of the
processor), once for each set of generics: worth it from {worth_it:,.0f} thousand cycles on.
"""
    head = f"""\
# Simulation speed

Written by `make simspeed` (`{command_line("simulation_speed", scene=scene, size=size, copies=copies)}`):
{scene} at {size} by {size}, quadratic RGB with depth, default generics,
in GHDL once, in Verilator {copies} times over; the pixels are the same.

"""
    write_report(output, f"{head}{body}\nMeasured with {versions()}.\n")
    click.echo(body, nl=False)
    if ratio < LEAST_RATIO:
        sys.exit(1)


if __name__ == "__main__":
    main()
