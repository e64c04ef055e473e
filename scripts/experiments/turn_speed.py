#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
What a frame of `turn` and a picture of `view` cost, beside VTK with OpenGL in software, in one run.

Processor time of one core, frame about frame of both, so that whatever else the machine does meets both; the
ratio is what another machine can compare. Writes docs/reports/turn_speed.md and .json.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np

import quadshade
from quadshade.animation.animate import QUIET, draw_frame
from quadshade.errors import QuadshadeError
from quadshade.files.markdown import markdown_table
from quadshade.scene import fit_camera
from quadshade.view import Viewed, ViewState
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "turn_speed.md"
VIEW_SIZE = 512
WANTED_SECONDS, WANTED_RATE = 3.0, 30
WARM = 3


def vtk_frames(scene: str, size: tuple[int, int]) -> Callable[[float], np.ndarray]:
    """VTK's picture of a scene turned by degrees, (h, w, 3) uint8, with the same mesh, normals and camera."""
    # One thread, as the other side has.
    os.environ["LP_NUM_THREADS"] = "1"
    try:
        import vtk
        from vtk.util import numpy_support
    except ModuleNotFoundError:
        raise QuadshadeError("VTK is not installed", "run `make turnspeed`, which installs it") from None
    mesh = quadshade.load_scene(scene)
    points, data = vtk.vtkPoints(), vtk.vtkPolyData()
    points.SetData(numpy_support.numpy_to_vtk(mesh.corners.reshape(-1, 3).astype(np.float32), deep=True))
    data.SetPoints(points)
    normals = mesh.normals.reshape(-1, 3).astype(np.float32)
    data.GetPointData().SetNormals(numpy_support.numpy_to_vtk(normals, deep=True))
    corners = np.arange(3 * len(mesh)).reshape(-1, 3)
    cells = np.column_stack([np.full(len(mesh), 3), corners]).astype(np.int64).ravel()
    polygons = vtk.vtkCellArray()
    polygons.ImportLegacyFormat(numpy_support.numpy_to_vtkIdTypeArray(cells, deep=True))
    data.SetPolys(polygons)
    mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
    mapper.SetInputData(data)
    actor.SetMapper(mapper)
    actor.GetProperty().SetInterpolationToPhong()
    actor.GetProperty().SetSpecular(0.5)
    actor.GetProperty().SetSpecularPower(20)
    actor.GetProperty().BackfaceCullingOn()
    renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    renderer.AddActor(actor)
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    camera, seen = renderer.GetActiveCamera(), fit_camera(mesh)
    camera.SetPosition(*seen.eye)
    camera.SetFocalPoint(*seen.target)
    camera.SetViewUp(*seen.up)
    camera.SetViewAngle(seen.fov)
    renderer.ResetCameraClippingRange()
    fetched = vtk.vtkUnsignedCharArray()

    def frame(degrees: float) -> np.ndarray:
        actor.SetOrientation(0, degrees, 0)
        window.Render()
        window.GetPixelData(0, 0, size[0] - 1, size[1] - 1, 1, fetched, 0)
        pixels: np.ndarray = numpy_support.vtk_to_numpy(fetched).reshape(size[1], size[0], 3)
        return pixels[::-1]

    return frame


def spent(work: Callable[[], Any]) -> float:
    """Seconds of processor time of all threads."""
    start = time.process_time()
    work()
    return time.process_time() - start


def measure(scene: str, size: tuple[int, int], frames: int) -> dict[str, Any]:
    """Processor seconds of every frame, of all sides in turn."""
    animation = quadshade.turn(scene, frames=frames, size=size, engine="model", reports=QUIET)
    other, square = vtk_frames(scene, size), vtk_frames(scene, (VIEW_SIZE, VIEW_SIZE))
    viewed = Viewed(scene, quadshade.load_scene(scene))

    def ours(frame: int, errors: bool) -> None:
        draw_frame(frame, animation.motion.pose(frame), animation.frame_settings(frame), errors)

    def looked(frame: int) -> None:
        state = {"yaw": 360 * frame / frames, "width": VIEW_SIZE, "height": VIEW_SIZE}
        viewed.show(ViewState.read(state), False)

    sides: dict[str, Callable[[int], Any]] = {
        "turn": lambda frame: ours(frame, True),
        "turn, no errors": lambda frame: ours(frame, False),
        "vtk": lambda frame: other(360 * frame / frames),
        "view": looked,
        "vtk, square": lambda frame: square(360 * frame / frames),
    }
    for work in sides.values():
        for frame in range(WARM):
            work(frame)
    seconds: dict[str, list[float]] = {name: [] for name in sides}
    for frame in range(frames):
        for name, work in sides.items():
            seconds[name].append(spent(lambda work=work, frame=frame: work(frame)))  # type: ignore[misc]
    lit = float((other(0.0) != 0).any(axis=2).mean())
    covered = float((animation[0].array != 0).any(axis=2).mean())
    return {
        "covered": [covered, lit],
        "seconds": {name: [round(one, 6) for one in own] for name, own in seconds.items()},
    }


def report(results: dict[str, Any]) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    seconds = {name: np.array(own) for name, own in results["seconds"].items()}
    width, height = results["size"]
    size, frames = f"{width}x{height}", results["frames"]
    peers = {"turn": "vtk", "turn, no errors": "vtk", "view": "vtk, square"}
    rows = [
        (
            f"`{name.split(',')[0]}`{', without errors' if 'no errors' in name else ''}",
            size if peer == "vtk" else f"{VIEW_SIZE}x{VIEW_SIZE}",
            f"{1000 * np.median(seconds[name]):.1f} ms",
            f"{1000 * np.median(seconds[peer]):.1f} ms",
            f"{np.median(seconds[name] / seconds[peer]):.2f}",
        )
        for name, peer in peers.items()
    ]
    whole, rate = seconds["turn"].sum(), 1 / np.median(seconds["view"])
    both = [
        (
            f"{frames} frames of `turn` with errors",
            f"{whole:.2f} s",
            f"≤ {WANTED_SECONDS:g} s {'met' if whole <= WANTED_SECONDS else 'MISSED'}",
        ),
        (
            "pictures of `view` a second of processor time",
            f"{rate:.0f}",
            f"≥ {WANTED_RATE} {'met' if rate >= WANTED_RATE else 'MISSED'}",
        ),
    ]
    ours, theirs = results["covered"]
    return "\n\n".join(
        [
            LICENCE + "\n# What a frame costs the host",
            paragraph(
                f"""Written by `{results["command"]}` (`make turnspeed`). {results["scene"]}, golden model,
                processor time of one core after start, median of {frames} frames; VTK {results["vtk"]} draws
                the same mesh with the same normals and camera by OpenGL in software
                ({results["renderer"]}, one thread), Phong shading, and its picture is fetched. Frames of all
                sides take turns. The golden model covers {ours:.1%} of the picture, VTK {theirs:.1%}: its
                shading is other, its work alike. The golden model computes set-up, every bit of the
                hardware's pixels and its clocks; *errors* compare each frame with Phong shading in float."""
            ),
            markdown_table(("what", "size", "processor time", "VTK", "ratio"), rows),
            markdown_table(("what", "measured", "wanted"), both) + "\n",
        ]
    )


@click.command(help=__doc__)
@click.option("--scene", default="sphere:690", show_default=True)
@click.option("--frames", default=60, show_default=True, type=click.IntRange(2, 1000))
@click.option("--width", default=640, show_default=True, type=click.IntRange(16, 2048))
@click.option("--height", default=480, show_default=True, type=click.IntRange(16, 2048))
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(scene: str, frames: int, width: int, height: int, output: Path) -> None:
    measured = measure(scene, (width, height), frames)
    import vtk

    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.Render()
    renderer = [line for line in window.ReportCapabilities().splitlines() if "renderer string" in line]
    results = {
        "command": command_line("turn_speed", scene=scene, frames=frames, width=width, height=height),
        "scene": scene,
        "frames": frames,
        "size": [width, height],
        "vtk": vtk.vtkVersion.GetVTKVersion(),
        "renderer": renderer[0].split(":")[1].strip() if renderer else window.GetClassName(),
        **measured,
    }
    write_report(output, report(results), results)
    click.echo(report(results))


if __name__ == "__main__":
    main()
