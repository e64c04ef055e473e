# SPDX-License-Identifier: Apache-2.0
"""``quadshade render``: a mesh becomes a picture."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from quadshade.cli.adapt_options import adapt_options, adapt_report, adapted_to, check_adaptive
from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import (
    GENERICS_EPILOG,
    PATH,
    check_writable,
    engine_option,
    generic_option,
    parse_generics,
    stats_option,
    waves_option,
    write_atomically,
    write_json,
)
from quadshade.cli.setup_options import SETUPS, check_method, setup_options, undefined_note
from quadshade.errors import QuadshadeError
from quadshade.formats import CONSTANT, Formats
from quadshade.shading.sample import SHADING_ORDERS, widened
from quadshade.shading.specular import SPECULAR_ORDERS, UnsuitedError, sample_specular, specular_formats

if TYPE_CHECKING:
    from quadshade.scene import Projected
    from quadshade.shading import Light, Material
    from quadshade.triangles import Drawing, ScreenTriangles

SHADINGS = (*SHADING_ORDERS, *SPECULAR_ORDERS, "phong")
COLOUR_CHANNELS = 3


@click.command(epilog=GENERICS_EPILOG)
@click.argument("scene")
@click.option("-o", "--output", required=True, type=PATH, help="PNG file to write.")
@engine_option
@click.option(
    "--shading",
    type=click.Choice(SHADINGS),
    default="quadratic",
    show_default=True,
    help="How colour is interpolated; -specular: diffuse and specular cosines, the power taken per pixel; "
    "phong is the reference, computed in float on the host.",
)
@click.option("--size", default="512x512", show_default=True, metavar="WxH", help="Pixels.")
@click.option(
    "--camera",
    default="",
    metavar="KEY=VALUE,...",
    help="eye=x,y,z or from=x,y,z (direction), target=x,y,z, up=x,y,z, fov=degrees or ortho=half-height, "
    "near=distance; what is missing is fitted to the scene.",
)
@click.option(
    "--light",
    "light_texts",
    multiple=True,
    metavar="KEY=VALUE,...",
    help="dir=x,y,z (towards the light), point=x,y,z or ambient=n, with colour=r,g,b (0..1) and, for points, "
    "attenuation=a,b,c. Repeatable; replaces the default lights.",
)
@click.option(
    "--material",
    default="",
    metavar="KEY=VALUE,...",
    help="colour=r,g,b, diffuse=, ambient=, specular= (one number or three), exponent=n, "
    "model=blinn or phong.",
)
@click.option("--exponent", type=float, help="Specular exponent.  [default: 20]")
@click.option(
    "--reflectance",
    metavar="MODULE:FUNCTION",
    help="Your own reflectance: a function of point, normal, to_light and to_viewer.",
)
@click.option("--cull/--no-cull", default=True, show_default=True, help="Drop triangles seen from behind.")
@click.option(
    "--crease",
    type=float,
    metavar="DEGREES",
    help="Compute vertex normals; edges sharper than this stay sharp.  "
    "[default: the file's normals, else 60]",
)
@click.option(
    "--background", default="0", metavar="R,G,B", help="0..1; one number is grey.  [default: black]"
)
@setup_options(SETUPS)
@adapt_options
@stats_option
@waves_option
@generic_option
def render(
    scene: str,
    output: Path,
    engine: str | None,
    shading: str,
    size: str,
    camera: str,
    light_texts: tuple[str, ...],
    material: str,
    exponent: float | None,
    reflectance: str | None,
    cull: bool,
    crease: float | None,
    background: str,
    stats: Path | None,
    waves: Path | None,
    generics: tuple[str, ...],
    setup_choice: dict,
    adapt_choice: dict | None,
) -> None:
    """
    Draw SCENE: a mesh file (OBJ, PLY, STL, GLB) or a generated mesh.

    Generated: sphere:168, sphere:12x17 (stacks x slices), torus:288, torus:16x9 (rings x sides), icosphere:3.

    \b
    quadshade render sphere:168 -o sphere.png --exponent 50
    quadshade render part.stl -o part.png --camera from=1,1,2 --material colour=0.8,0.3,0.1
    quadshade render scene.glb -o scene.png --light dir=1,1,1 --light ambient=0.2 --size 640x480
    quadshade render torus:288 -o torus.png --engine ghdl --stats stats.json --waves torus.ghw
    quadshade render torus:288 -o torus.png --generic stream_width=128
    quadshade render sphere:690 -o sphere.png --max-error 4
    quadshade render sphere:690 -o sphere.png --budget 30000bytes --error-measure rms
    """
    with leave_at_once():
        from quadshade.engine import default_engine
        from quadshade.image import paint, write_png
        from quadshade.scene import load_scene, parse_camera, project
        from quadshade.scene.project import check_size
        from quadshade.shading import load_reflectance, parse_light, parse_material

        if not scene.startswith(("sphere:", "torus:")):
            import trimesh  # noqa: F401 - what reads it takes it from there

    formats = Formats().with_generics(parse_generics(generics))
    # Phong shading is the host's own work: of the engine it needs coverage and depth only.
    # The shade unit is in the golden model only.
    modelled = shading == "phong" or shading in SPECULAR_ORDERS or formats.with_shade
    engine = engine or ("model" if modelled else default_engine())
    width, height = _parse_size(size)
    check_size(width, height, formats)
    _check_choices(output, shading if adapt_choice is None else "flat", formats)
    check_method(setup_choice["method"], shading)
    check_adaptive(adapt_choice, shading, setup_choice["method"])
    check_writable(output, stats, waves, inputs=[Path(scene)])
    lights = tuple(parse_light(text) for text in light_texts) or None
    surface = parse_material(
        material, exponent, None if reflectance is None else load_reflectance(reflectance)
    )
    ground = _parse_background(background)

    with _progress(f"reading {scene}"):
        mesh = load_scene(scene, crease)
        projected = project(mesh, parse_camera(camera, mesh), width, height, formats, cull)
    if not formats.with_depth:
        projected = projected.back_to_front()
    with _progress(f"drawing {len(projected)} triangles with the engine {engine}"):
        adapted = adapted_to(adapt_choice, projected, lights, surface, formats)
        if adapted is None:
            triangles, formats = _sample(
                projected,
                shading,
                lights,
                surface,
                formats,
                parse_generics(generics),
                setup_choice["method"] == "xshading",
            )
        else:
            triangles = adapted.triangles
        drawing, shown, value = _draw(
            projected, triangles, shading == "phong", lights, surface, formats, engine, waves, setup_choice
        )
        adaptive, note = adapt_report(adapt_choice, adapted, drawing, projected, lights, surface, formats)
    picture = paint(shown, value, ground, (1 << formats.value_bits) - 1)
    write_atomically(output, lambda temporary: write_png(temporary, picture))
    if stats is not None:
        kind = "adaptive" if adaptive else shading
        write_json(stats, _stats(drawing, scene, kind, len(mesh), shown) | adaptive)
    clocks = "" if shading == "phong" else f", {drawing.stats['clocks']} clocks"
    clocks += undefined_note(drawing.stats, setup_choice["method"])
    click.echo(
        f"{output}: {width}x{height}, {len(projected)} triangles, {len(drawing.pixels)} pixels{clocks}{note}"
    )


def _sample(
    projected: Projected,
    shading: str,
    lights: tuple[Light, ...] | None,
    surface: Material,
    formats: Formats,
    generics: dict[str, int],
    x_shading: bool,
) -> tuple[ScreenTriangles, Formats]:
    """What the engine is to draw, and the formats of a core for it."""
    from quadshade.shading import sample

    if shading in SPECULAR_ORDERS:
        try:
            fitted = specular_formats(generics, projected, lights, surface)
            return sample_specular(projected, shading, lights, surface, fitted, x_shading), fitted
        except UnsuitedError as reason:
            shading = shading.removesuffix("-specular").replace("linear", "gouraud")
            click.echo(f"quadshade: notice: drawn as {shading}: {reason}", err=True)
            _check_colours(formats)
    order = "flat" if shading == "phong" else shading
    triangles = sample(projected, order, lights, surface, formats, x_shading)
    return widened(triangles, formats.num_channels), formats


def _draw(
    projected: Projected,
    triangles: ScreenTriangles,
    is_phong: bool,
    lights: tuple[Light, ...] | None,
    surface: Material,
    formats: Formats,
    engine: str,
    waves: Path | None,
    setup_choice: dict,
) -> tuple[Drawing, np.ndarray, np.ndarray]:
    """What the engine drew, which of its pixels are seen, and their colours."""
    from quadshade.engine import draw
    from quadshade.image import visible
    from quadshade.shading.reference import phong

    drawing = draw(triangles, formats, engine, waves, **setup_choice)
    pixels = drawing.pixels
    shown = visible(pixels, projected.width, projected.height)
    if not is_phong:
        return drawing, shown, pixels.value
    # The engine's coverage and depth; only what is seen is worth shading.
    seen = shown[shown >= 0]
    value = np.zeros((len(pixels), COLOUR_CHANNELS), dtype=np.float32)
    value[seen] = phong(
        projected, pixels.triangle[seen], pixels.x[seen], pixels.y[seen], lights, surface, formats
    )
    return drawing, shown, value


def _stats(drawing: Drawing, scene: str, shading: str, faces: int, shown: np.ndarray) -> dict:
    """The engine's counts, with what the picture is of."""
    stats = dict(drawing.stats)
    if shading == "phong":
        # The engine drew coverage and depth only: its clocks are not those of Phong shading.
        stats.update(clocks=None, clocks_per_pixel=None, words=None)
    height, width = shown.shape
    return stats | {
        "scene": scene,
        "shading": shading,
        "width": width,
        "height": height,
        "faces": faces,
        "visible_pixels": int(np.count_nonzero(shown >= 0)),
    }


def _check_choices(output: Path, shading: str, formats: Formats) -> None:
    """Refuse options that contradict each other before any work is done."""
    if output.suffix.lower() != ".png":
        raise QuadshadeError(f"the output is {str(output)!r}", "give a name that ends in .png")
    if shading not in SPECULAR_ORDERS:
        _check_colours(formats)
    needed = (SHADING_ORDERS | SPECULAR_ORDERS).get(shading, CONSTANT)
    if formats.max_order < needed:
        raise QuadshadeError(f"generic max_order is {formats.max_order}", f"shading {shading} needs {needed}")


def _check_colours(formats: Formats) -> None:
    """The channels that colours need; a shade unit passes three of more."""
    got = formats.num_channels
    if got < COLOUR_CHANNELS or (got > COLOUR_CHANNELS and not formats.with_shade):
        raise QuadshadeError(f"generic num_channels is {got}", f"a picture needs {COLOUR_CHANNELS}")


def _parse_size(text: str) -> tuple[int, int]:
    """Width and height of ``WxH``."""
    match = re.fullmatch(r"([0-9]{1,6})[xX]([0-9]{1,6})", text.strip())
    if not match:
        raise QuadshadeError(f"the size is {text!r}", "write WIDTHxHEIGHT, e.g. 640x480")
    return int(match[1]), int(match[2])


def _parse_background(text: str) -> tuple[int, int, int]:
    """8-bit background of one or three numbers from 0 to 1."""
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 3) or not all(0 <= number <= 1 for number in numbers):
        raise QuadshadeError(f"the background is {text!r}", "give one or three numbers from 0 to 1")
    levels = tuple(round(255 * number) for number in numbers)
    return levels * 3 if len(levels) == 1 else levels


@contextmanager
def _progress(text: str) -> Iterator[None]:
    """A spinner on stderr while the work lasts, where that is a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    with console.status(text):
        yield
