# SPDX-License-Identifier: Apache-2.0
"""Options of ``render`` for styles, edges and the G-buffer, and what they do to a picture."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from quadshade.cli.options import PATH
from quadshade.contract.formats import Formats, parse_generics
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically
from quadshade.shading.specular import SPECULAR_ORDERS
from quadshade.style.illustrate import TOON_STEPS

if TYPE_CHECKING:
    from quadshade.cli.scene_options import SceneChoice, ShownScene

STYLES = ("none", "cartoon", "gooch", "hatch")
VARIANTS = ("diagonal", "eight")
ORDERS = ("quadratic", "linear")
SPACES = ("camera", "world")

STYLE_OPTIONS = (
    click.option(
        "--style",
        type=click.Choice(STYLES),
        default="none",
        show_default=True,
        help="cartoon: light in steps (--toon, else 4); gooch: cool-to-warm tones; hatch: strokes.",
    ),
    click.option(
        "--edges",
        metavar="KIND,...",
        help="Draw edges over the picture: profile (of depth), inner (of normals), or profile,inner.",
    ),
    click.option(
        "--edge-variant",
        type=click.Choice(VARIANTS),
        default="diagonal",
        show_default=True,
        help="Neighbours that depth's edges are found by: the diagonal ones, or all eight.",
    ),
    click.option(
        "--edge-color",
        "edge_colours",
        multiple=True,
        metavar="KIND=R,G,B",
        help="Colour of profile or inner edges, 0..1 (repeatable).  [default: black, and nearly black]",
    ),
    click.option(
        "--gbuffer",
        type=PATH,
        help="Write normals, depth and the triangle seen at every pixel, drawn by the engine, as NPZ.",
    ),
    click.option(
        "--gbuffer-order",
        type=click.Choice(ORDERS),
        default="quadratic",
        show_default=True,
        help="How normals are interpolated.",
    ),
    click.option(
        "--gbuffer-space",
        type=click.Choice(SPACES),
        default="camera",
        show_default=True,
        help="Axes of the normals.",
    ),
)


@dataclass(frozen=True)
class StyleChoice:
    """
    What the options ask for, checked.

    Attributes
    ----------
    style : str
    kinds : tuple of str
      Edges to draw; none if empty.
    variant : str
    colours : dict of str to 3 floats
    gbuffer : Path or None
    order, space : str
      Of the G-buffer's normals.
    """

    style: str = "none"
    kinds: tuple[str, ...] = ()
    variant: str = "diagonal"
    colours: dict[str, tuple[float, ...]] | None = None
    gbuffer: Path | None = None
    order: str = "quadratic"
    space: str = "camera"

    @property
    def needs_gbuffer(self) -> bool:
        """Whether a second pass draws normals and depth."""
        return bool(self.kinds) or self.gbuffer is not None


def style_options(command: Callable) -> Callable:
    """Add the options to a command; its function gets them as one :class:`StyleChoice`, ``style_choice``."""

    @functools.wraps(command)
    def wrapper(*positional: Any, **named: Any) -> Any:
        taken = ("style", "edges", "edge_variant", "edge_colours")
        taken += ("gbuffer", "gbuffer_order", "gbuffer_space")
        return command(*positional, style_choice=_chosen(*(named.pop(name) for name in taken)), **named)

    for option in reversed(STYLE_OPTIONS):
        wrapper = option(wrapper)
    return wrapper


def _chosen(
    style: str,
    edges: str | None,
    variant: str,
    colours: Sequence[str],
    gbuffer: Path | None,
    order: str,
    space: str,
) -> StyleChoice:
    from quadshade.style.edges import KINDS, parse_kinds

    kinds = () if edges is None else parse_kinds(edges)
    inks = {}
    for text in colours:
        kind, _, value = text.partition("=")
        try:
            numbers = tuple(float(number) for number in value.split(","))
        except ValueError:
            numbers = ()
        if kind not in KINDS or len(numbers) != 3 or not all(0 <= number <= 1 for number in numbers):
            raise QuadshadeError(
                f"the edge colour is {text!r}", "write profile=r,g,b or inner=r,g,b with numbers from 0 to 1"
            )
        if kind not in kinds:
            raise QuadshadeError(f"a colour for {kind} edges, which are not drawn", f"give --edges {kind}")
        inks[kind] = numbers
    if gbuffer is not None and gbuffer.suffix.lower() != ".npz":
        raise QuadshadeError(f"the G-buffer is {str(gbuffer)!r}", "give a name that ends in .npz")
    return StyleChoice(style, kinds, variant, inks, gbuffer, order, space)


def styled_choice(choice: StyleChoice, scene: SceneChoice) -> SceneChoice:
    """
    The scene's options as a style needs them: white paper, and for a cartoon the shade unit's steps.

    Raises
    ------
    QuadshadeError
      A style with what it excludes.
    """
    excluded = ()
    if choice.style == "cartoon":
        excluded = (
            (scene.shading not in ("quadratic", *SPECULAR_ORDERS), f"--shading {scene.shading}"),
            (scene.adapt_choice is not None, "--max-error or --budget"),
        )
    elif choice.style == "gooch":
        excluded = (
            (scene.shading in SPECULAR_ORDERS, f"--shading {scene.shading}"),
            (scene.reflectance is not None, "--reflectance"),
        )
    for wrong, what in excluded:
        if wrong:
            raise QuadshadeError(
                f"--style {choice.style} and {what} exclude each other", "leave one of them out"
            )
    if scene.background is None and (choice.style != "none" or choice.kinds):
        scene = replace(scene, background="1")
    if choice.style == "cartoon":
        shading = scene.shading if scene.shading in SPECULAR_ORDERS else "quadratic-specular"
        scene = replace(scene, shading=shading, toon=TOON_STEPS if scene.toon is None else scene.toon)
    return scene


def styled_scene(choice: StyleChoice, scene: ShownScene) -> ShownScene:
    """The scene as it is, or in Gooch's light."""
    if choice.style != "gooch":
        return scene
    from quadshade.shading.lights import default_lights
    from quadshade.style import gooch_material

    lights = scene.lights or default_lights(scene.projected.axes)
    surface, lights = gooch_material(scene.surface, lights)
    return replace(scene, surface=surface, lights=lights)


def draw_style(
    choice: StyleChoice,
    picture: np.ndarray,
    shown: np.ndarray,
    scene: ShownScene,
    generics: Sequence[str],
    engine: str,
) -> tuple[np.ndarray, dict]:
    """
    What a style makes of a picture: strokes, edges, and the G-buffer's file.

    Parameters
    ----------
    choice : StyleChoice
    picture : (h, w, 3) uint8
    shown : (h, w) int
      -1 where nothing was drawn.
    scene : ShownScene
    generics : sequence of str
      As the user gave them; the G-buffer's core has three channels and no shade unit.
    engine : str

    Returns
    -------
    picture : (h, w, 3) uint8
    stats : dict
      Of the G-buffer's pass, under ``gbuffer``; empty without one.
    """
    from quadshade.style import draw_edges, draw_gbuffer, find_edges, hatch

    if choice.style == "hatch":
        picture = hatch(picture, shown >= 0, scene.ground)
    if not choice.needs_gbuffer:
        return picture, {}
    formats = Formats().with_generics({**parse_generics(generics), "num_channels": 3, "with_shade": 0})
    gbuffer, drawing = draw_gbuffer(scene.projected, formats, engine, choice.order, choice.space)
    if choice.kinds:
        picture = draw_edges(picture, find_edges(gbuffer, choice.variant), choice.kinds, choice.colours)
    if choice.gbuffer is not None:
        write_atomically(choice.gbuffer, lambda temporary: np.savez_compressed(temporary, **gbuffer.arrays()))
    return picture, {"gbuffer": drawing.stats}
