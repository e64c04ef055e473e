# SPDX-License-Identifier: Apache-2.0
"""What ``render`` and ``pack`` share: the scene and how it is to be shaded, from options to triangles."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from quadshade.cli.adapt_options import adapt_options, adapted_to, check_adaptive
from quadshade.cli.options import generic_option
from quadshade.cli.port_options import is_given
from quadshade.cli.setup_options import SETUPS, check_method, setup_options
from quadshade.contract.formats import CONSTANT, Formats, parse_generics
from quadshade.errors import QuadshadeError
from quadshade.scene.key_values import parse_background, parse_size
from quadshade.shading.sample import SHADING_ORDERS, widened
from quadshade.shading.specular import SPECULAR_ORDERS, UnsuitedError, sample_specular, specular_formats

if TYPE_CHECKING:
    from quadshade.adapt import Adapted
    from quadshade.contract.triangles import ScreenTriangles
    from quadshade.scene import Projected
    from quadshade.shading import Light, Material

PHONG = "phong"
SHADINGS = (*SHADING_ORDERS, *SPECULAR_ORDERS, PHONG)
COLOUR_CHANNELS = 3


@dataclass(frozen=True)
class SceneChoice:
    """What the options say; every attribute is the option of its name."""

    scene: str
    shading: str
    size: str
    camera: str
    light_texts: tuple[str, ...]
    material: str
    exponent: float | None
    toon: int | None
    reflectance: str | None
    cull: bool
    crease: float | None
    background: str | None
    generics: tuple[str, ...]
    setup_choice: dict
    adapt_choice: dict | None

    @property
    def path(self) -> Path:
        """The scene, as the file that it may be."""
        return Path(self.scene)

    def checked(self) -> Formats:
        """
        Refuse options that contradict each other, before any work is done; the formats that they ask for.

        Raises
        ------
        QuadshadeError
        """
        from quadshade.scene.project import check_size

        formats = Formats().with_generics(parse_generics(self.generics))
        check_size(*parse_size(self.size), formats)
        if self.adapt_choice is None:
            _check_orders(self.shading, formats)
        elif not formats.with_shade:
            _check_colours(formats)
        check_method(self.setup_choice["method"], self.shading)
        if self.toon is not None and self.shading not in SPECULAR_ORDERS:
            raise QuadshadeError(
                f"--toon with the shading {self.shading}", f"give --shading {' or '.join(SPECULAR_ORDERS)}"
            )
        check_adaptive(self.adapt_choice, self.shading, self.setup_choice["method"], self.toon)
        return formats


@dataclass(frozen=True)
class ShownScene:
    """
    A scene from its camera, in its light.

    Attributes
    ----------
    projected : Projected
    lights, surface
      For :func:`quadshade.shading.sample`.
    ground : tuple of int
      Background, 8 bits each.
    faces : int
      Of the mesh.
    """

    projected: Projected
    lights: tuple[Light, ...] | None
    surface: Material
    ground: tuple[int, int, int]
    faces: int


def scene_options(command: Callable) -> Callable:
    """Add the scene and its options to a command; its function gets them as one ``choice``."""
    options = (
        click.argument("scene"),
        click.option(
            "--shading",
            type=click.Choice(SHADINGS),
            default="quadratic",
            show_default=True,
            help="How colour is interpolated; -specular: diffuse and specular cosines, the power taken per "
            "pixel; phong is the reference, computed in float on the host.",
        ),
        click.option("--size", default="512x512", show_default=True, metavar="WxH", help="Pixels."),
        click.option(
            "--camera",
            default="",
            metavar="KEY=VALUE,...",
            help="eye=x,y,z or from=x,y,z (direction), target=x,y,z, up=x,y,z, fov=degrees or "
            "ortho=half-height, near=distance; what is missing is fitted to the scene.",
        ),
        click.option(
            "--light",
            "light_texts",
            multiple=True,
            metavar="KEY=VALUE,...",
            help="dir=x,y,z (towards the light), point=x,y,z or ambient=n, with colour=r,g,b (0..1) and, for "
            "points, attenuation=a,b,c. Repeatable; replaces the default lights.",
        ),
        click.option(
            "--material",
            default="",
            metavar="KEY=VALUE,...",
            help="colour=r,g,b, diffuse=, ambient=, specular= (one number or three), exponent=n, "
            "model=blinn or phong.",
        ),
        click.option("--exponent", type=float, help="Specular exponent.  [default: 20]"),
        click.option(
            "--toon",
            type=int,
            metavar="STEPS",
            help="Cartoon: diffuse light in so many steps, highlights with a sharp border. Needs a -specular "
            "shading.",
        ),
        click.option(
            "--reflectance",
            metavar="MODULE:FUNCTION",
            help="Your own reflectance: a function of point, normal, to_light and to_viewer.",
        ),
        click.option(
            "--cull/--no-cull", default=True, show_default=True, help="Drop triangles seen from behind."
        ),
        click.option(
            "--crease",
            type=float,
            metavar="DEGREES",
            help="Compute vertex normals; edges sharper than this stay sharp.  "
            "[default: the file's normals, else 60]",
        ),
        click.option(
            "--background",
            metavar="R,G,B",
            help="0..1; one number is grey.  [default: black; white with --style or --edges]",
        ),
        setup_options(SETUPS),
        adapt_options,
        generic_option,
    )
    names = {field.name for field in fields(SceneChoice)}

    @functools.wraps(command)
    def with_choice(*arguments: Any, **given: Any) -> Any:
        own = {name: value for name, value in given.items() if name not in names}
        choice = SceneChoice(**{name: value for name, value in given.items() if name in names})
        return command(*arguments, choice=choice, **own)

    for option in reversed(options):
        with_choice = option(with_choice)
    return with_choice


def show_scene(choice: SceneChoice, formats: Formats) -> ShownScene:
    """
    Read a scene and look at it.

    Raises
    ------
    QuadshadeError
      A wrong camera, light, material or background, or a mesh that cannot be read.
    """
    from quadshade.scene import load_scene, parse_camera, project
    from quadshade.shading import load_reflectance, parse_light, parse_material

    lights = tuple(parse_light(text) for text in choice.light_texts) or None
    reflectance = None if choice.reflectance is None else load_reflectance(choice.reflectance)
    surface = parse_material(choice.material, choice.exponent, reflectance)
    ground = parse_background("0" if choice.background is None else choice.background)
    with progress(f"reading {choice.scene}"):
        mesh = load_scene(choice.scene, choice.crease)
        camera = parse_camera(choice.camera, mesh)
        projected = project(mesh, camera, *parse_size(choice.size), formats, choice.cull)
    if not formats.with_depth:
        projected = projected.back_to_front()
    return ShownScene(projected, lights, surface, ground, len(mesh))


def shade_scene(
    choice: SceneChoice, shown: ShownScene, formats: Formats
) -> tuple[ScreenTriangles, Formats, Adapted | None]:
    """What is to be drawn, the formats of a core for it, and what was adapted, if anything was."""
    given = choice.shading if is_given("shading") else None
    adapted = adapted_to(
        choice.adapt_choice, given, shown.projected, shown.lights, shown.surface, formats,
        parse_generics(choice.generics),
    )  # fmt: skip
    if adapted is not None:
        return adapted.triangles, adapted.formats, adapted
    return *_sample(choice, shown, formats), None


def _sample(choice: SceneChoice, shown: ShownScene, formats: Formats) -> tuple[ScreenTriangles, Formats]:
    """As :func:`shade_scene`, where nothing is adapted."""
    from quadshade.shading import sample, toon_curves

    shading, x_shading = choice.shading, choice.setup_choice["method"] == "xshading"
    projected, lights, surface = shown.projected, shown.lights, shown.surface
    if shading in SPECULAR_ORDERS:
        try:
            curves = None if choice.toon is None else toon_curves(choice.toon, surface.exponent)
            generics = parse_generics(choice.generics)
            fitted = specular_formats(generics, projected, lights, surface, choice.toon is not None)
            triangles = sample_specular(projected, shading, lights, surface, fitted, x_shading, curves)
            return triangles, fitted
        except UnsuitedError as reason:
            shading = shading.removesuffix("-specular").replace("linear", "gouraud")
            steps = "" if choice.toon is None else ", without steps"
            click.echo(f"quadshade: notice: drawn as {shading}{steps}: {reason}", err=True)
            _check_colours(formats)
    order = "flat" if shading == PHONG else shading
    triangles = sample(projected, order, lights, surface, formats, x_shading)
    return widened(triangles, formats.num_channels), formats


def _check_orders(shading: str, formats: Formats) -> None:
    """Refuse formats that a shading does not go with."""
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


@contextmanager
def progress(text: str) -> Iterator[None]:
    """A spinner on stderr while the work lasts, where that is a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    with console.status(text):
        yield
