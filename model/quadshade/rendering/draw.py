# SPDX-License-Identifier: Apache-2.0
"""From settings to a picture, and from a file of triangles to pixels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from quadshade.choices import ADAPTIVE_SHADINGS, PHONG
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import Drawing, ScreenTriangles
from quadshade.engine import default_engine, draw
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically
from quadshade.files.triangle_file import open_triangles
from quadshade.image import paint, visible
from quadshade.rendering.groups import COLOUR_CHANNELS, EngineChoice, SetupChoice
from quadshade.rendering.in_time import assumed_clock, in_time
from quadshade.rendering.levels import best_level, level_note
from quadshade.rendering.phong_over import is_whole, phong_over
from quadshade.rendering.picture import Picture, Stats
from quadshade.rendering.settings import RenderSettings, Reports
from quadshade.rendering.shade import Shaded, ShownScene, default_count, shade_scene, show_scene
from quadshade.rendering.supersample import jitter, mean, moved
from quadshade.rendering.timing import Pace
from quadshade.shading.reference import phong


def render_picture(
    settings: RenderSettings, reports: Reports | None = None, pace: Pace | None = None
) -> Picture:
    """
    Draw a scene with an engine or on a board.

    Parameters
    ----------
    settings : RenderSettings
    reports : Reports, optional
    pace : Pace, optional
      Of the frames before, where there is a frame time.

    Returns
    -------
    Picture

    Raises
    ------
    QuadshadeError
      Settings that contradict each other, a scene that cannot be read or drawn, an engine that is not
      installed, or a board that does not answer.
    """
    reports = reports or Reports()
    notes: list[str] = []
    tell = reports.notice

    def notice(text: str) -> None:
        notes.append(text)
        tell(text)

    settings, reports = settings.styled(), replace(reports, notice=notice)
    if settings.port.is_given:
        from quadshade.rendering.board import render_on_board

        picture = render_on_board(settings, reports, pace)
    else:
        picture = _render_with_engine(settings, reports, pace)
    return replace(picture, notes=tuple(notes))


def _render_with_engine(settings: RenderSettings, reports: Reports, pace: Pace | None) -> Picture:
    """As :func:`render_picture`, without a board."""
    formats = settings.checked()
    choice = settings.scene
    shading = choice.interpolation
    # Phong shading is the host's own work: of the engine it needs coverage and depth only.
    engine = settings.engine.engine or ("model" if shading == PHONG else default_engine())
    scene = show_scene(settings, formats, reports)
    scene = best_level(settings, scene, formats, reports, default_count(settings))
    timing = None
    if settings.adapt.frame_time is not None:
        clock = assumed_clock(settings)
        scene, timing = in_time(settings, scene, formats, clock, reports, pace or Pace())
    projected = scene.projected
    reports.step(f"drawing {len(projected)} triangles with the engine {engine}")
    shaded = shade_scene(settings, scene, formats, reports)
    formats = shaded.formats
    drawing, shown, array, gbuffer = _frame(settings, scene, shaded, engine)
    if choice.supersample > 1:
        moves = jitter(choice.supersample, formats)
        array = mean(_moved_frames(settings, scene, shaded, engine, moves, reports))
    adaptive, note = adapt_report(settings, scene, shaded, drawing)
    kind = "adaptive" if adaptive else shading
    stats = _stats(drawing, choice.name, kind, scene, shown, adaptive, gbuffer)
    if timing is not None:
        stats = replace(stats, timing=timing.as_dict())
        note += timing.note()
    if len(projected) and not (shown >= 0).any():
        reports.notice("the picture is empty: no triangle covers a pixel's centre; give a larger --size")
    clocks = "" if shading == PHONG else f", {stats.clocks} clocks"
    frames = "" if choice.supersample == 1 else f" a picture, the mean of {choice.supersample**2} pictures"
    summary = (
        f"{projected.width}x{projected.height}, {len(projected)} triangles, "
        f"{stats.pixels} pixels{level_note(scene)}"
        f"{clocks}{frames}{undefined_note(drawing, settings.setup)}{note}"
    )
    triangle, depth = _seen(drawing, shown, formats)
    picture = Picture(array, stats, shaded.triangles, triangle, depth, (), summary, settings)
    if is_whole(settings, scene, drawing):
        picture = replace(picture, shades=partial(phong_over, scene, triangle, formats))
    return picture


class Frame(NamedTuple):
    """What an engine drew, which of it is seen, the picture with its style, and the G-buffer's counts."""

    drawing: Drawing
    shown: np.ndarray
    array: np.ndarray
    gbuffer: dict[str, Any] | None


def _frame(settings: RenderSettings, scene: ShownScene, shaded: Shaded, engine: str) -> Frame:
    """One frame of a picture, of triangles where they are."""
    projected, formats = scene.projected, shaded.formats
    drawing = draw(
        shaded.triangles, formats, engine, settings.engine.waves_path, **settings.setup.arguments()
    )
    shown = visible(drawing.pixels, projected.width, projected.height)
    value = drawing.pixels.value
    if settings.scene.interpolation == PHONG:
        value = _phong_values(scene, drawing, shown, formats)
    array = paint(shown, value, scene.ground, (1 << formats.value_bits) - 1)
    array, gbuffer = draw_style(settings, array, shown, scene, engine)
    return Frame(drawing, shown, array, gbuffer)


def _moved_frames(
    settings: RenderSettings,
    scene: ShownScene,
    shaded: Shaded,
    engine: str,
    moves: list[tuple[int, int]],
    reports: Reports,
) -> Iterator[np.ndarray]:
    """(h, w, 3) uint8 pictures of the same triangles, each moved; without waves and files."""
    plain = replace(settings, engine=EngineChoice(engine), style=replace(settings.style, gbuffer=None))
    for number, by in enumerate(moves, 1):
        reports.step(f"drawing frame {number} of {len(moves)}")
        placed = replace(scene, projected=moved(scene.projected, by, shaded.formats))
        triangles = moved(shaded.triangles, by, shaded.formats)
        yield _frame(plain, placed, shaded._replace(triangles=triangles), engine).array


def _phong_values(scene: ShownScene, drawing: Drawing, shown: np.ndarray, formats: Formats) -> np.ndarray:
    """(n, 3) float32 colours of the drawing's pixels; only what is seen is worth shading."""
    pixels = drawing.pixels
    seen = shown[shown >= 0]
    value = np.zeros((len(pixels), COLOUR_CHANNELS), dtype=np.float32)
    place = pixels.triangle[seen], pixels.x[seen], pixels.y[seen]
    value[seen] = phong(scene.projected, *place, scene.lights, scene.surface, formats)
    return value


def _seen(drawing: Drawing, shown: np.ndarray, formats: Formats) -> tuple[np.ndarray, np.ndarray | None]:
    """The triangle, and the depth if there is one, at every place of the screen."""
    covered = shown >= 0
    triangle = np.full(shown.shape, -1, dtype=np.int32)
    triangle[covered] = drawing.pixels.triangle[shown[covered]]
    if drawing.pixels.depth is None:
        return triangle, None
    depth = np.full(shown.shape, (1 << formats.depth_bits) - 1, dtype=np.uint32)
    depth[covered] = drawing.pixels.depth[shown[covered]]
    return triangle, depth


def _stats(
    drawing: Drawing,
    scene: str,
    shading: str,
    shown_scene: ShownScene,
    shown: np.ndarray,
    adaptive: dict[str, Any] | None,
    gbuffer: dict[str, Any] | None,
) -> Stats:
    """The engine's counts, with what the picture is of."""
    counts = dict(drawing.stats)
    if shading == PHONG:
        # The engine drew coverage and depth only: its clocks are not those of Phong shading.
        counts.update(clocks=None, clocks_per_pixel=None, words=None)
    height, width = shown.shape
    seen = int(np.count_nonzero(shown >= 0))
    return Stats(
        **counts,
        scene=scene,
        shading=shading,
        width=width,
        height=height,
        faces=shown_scene.faces,
        whole_faces=len(shown_scene.whole),
        visible_pixels=seen,
        adaptive=adaptive,
        gbuffer=gbuffer,
    )


def draw_style(
    settings: RenderSettings, picture: np.ndarray, shown: np.ndarray, scene: ShownScene, engine: str
) -> tuple[np.ndarray, dict[str, Any] | None]:
    """
    What a style makes of a picture: strokes, edges, and the G-buffer's file.

    Parameters
    ----------
    settings : RenderSettings
      Of its generics, the G-buffer's core takes three channels and no shade unit.
    picture : (h, w, 3) uint8
    shown : (h, w) int
      -1 where nothing was drawn.
    scene : ShownScene
    engine : str

    Returns
    -------
    picture : (h, w, 3) uint8
    stats : dict or None
      Of the G-buffer's pass, if there was one.
    """
    from quadshade.style import draw_edges, draw_gbuffer, find_edges

    choice = settings.style
    picture = draw_tones(choice.style, picture, shown >= 0, scene.ground)
    if not choice.needs_gbuffer:
        return picture, None
    gbuffer, drawing = draw_gbuffer(
        scene.projected, settings.gbuffer_formats(), engine, choice.gbuffer_order, choice.gbuffer_space
    )
    if choice.kinds:
        edges = find_edges(gbuffer, choice.edge_variant)
        picture = draw_edges(picture, edges, choice.kinds, choice.colours)
    if choice.gbuffer_path is not None:
        arrays = gbuffer.arrays()
        write_atomically(
            choice.gbuffer_path,
            lambda temporary: np.savez_compressed(temporary, allow_pickle=False, **arrays),
        )
    return picture, dict(drawing.stats)


def draw_tones(
    style: str, picture: np.ndarray, covered: np.ndarray, ground: tuple[int, int, int]
) -> np.ndarray:
    """
    Strokes in place of tones, or smooth borders between a cartoon's; other pictures as they are.

    Parameters
    ----------
    style : str
    picture : (h, w, 3) uint8
    covered : (h, w) bool
      Where something was drawn.
    ground : 3 ints
      Background.

    Returns
    -------
    (h, w, 3) uint8
    """
    from quadshade.style import hatch, smooth_tones

    if style == "hatch":
        return hatch(picture, covered, ground)
    return smooth_tones(picture, covered) if style == "cartoon" else picture


def adapt_note(shaded: Shaded) -> str:
    """Labelled lines: bytes, kind of channels, what the next best kind takes, and the mix; or nothing."""
    from quadshade.adapt import stream_bytes

    adapted = shaded.adapted
    if adapted is None:
        return ""
    size = stream_bytes(adapted.triangles, adapted.formats)
    rival = adapted.rival
    other = ""
    if rival is not None and rival.bytes is not None:
        other = f" (as {rival.shading} {'about ' * (rival.error is None)}{rival.bytes})"
    mix = adapted.mix()
    orders = ", ".join(f"{count} {order}" for order, count in mix["triangles_by_order"].items())
    powers = sum(mix["specular_by_order"].values()) - mix["specular_by_order"]["constant"]
    if adapted.shading == ADAPTIVE_SHADINGS[1]:
        orders += f", {powers} with a power"
    return (
        f"\n  channels   {adapted.shading}\n  bytes      {size}{other}"
        + (f"\n  line       at most {adapted.line_bytes} bytes" if adapted.line_bytes is not None else "")
        + f"\n  triangles  {mix['triangles']} sent: {orders}"
        f"\n  divided    {mix['divided']} of {mix['triangles_of_mesh']} triangles seen"
    )


def adapt_report(
    settings: RenderSettings, scene: ShownScene, shaded: Shaded, drawing: Drawing
) -> tuple[dict[str, Any] | None, str]:
    """What the statistics and the summary say about an adaptive picture; nothing about others."""
    adapted, choice = shaded.adapted, settings.adapt
    if adapted is None:
        return None, ""
    from quadshade.adapt import error_figures, pixel_errors

    limit = choice.max_error if choice.measure == "max" else None
    errors = pixel_errors(
        drawing.pixels, adapted.root, scene.projected, scene.lights, scene.surface, shaded.formats
    )
    figures = error_figures(errors, math.inf if limit is None else limit)
    mix = adapted.mix()
    budget, unit = choice.number_and_unit
    content = {
        "max_error": choice.max_error,
        "budget": budget,
        "budget_unit": unit if budget is not None else None,
        **mix,
        "bytes": 4 * drawing.stats["words"] + mix["state_bytes"],
        "measured_max": figures.largest,
        "measured_rms": figures.rms,
        "share_over_max_error": None if limit is None else figures.exceeding,
    }
    over = "" if limit is None else f", {figures.exceeding:.4%} of the pixels over {limit:g}"
    # What was verified is what was measured.
    estimate = "" if adapted.verified else f" (estimated {adapted.measure} {adapted.error:.3f}, no bound)"
    note = (
        f"{adapt_note(shaded)}\n  error      largest {figures.largest:.2f}, rms {figures.rms:.3f} grey levels"
        f"{estimate}{over}"
    )
    return content, note


def undefined_note(drawing: Drawing, setup: SetupChoice) -> str:
    """What to say about triangles that a method could not set up, or nothing."""
    count = drawing.stats["triangles_undefined"]
    return f", {count} triangles undefined by {setup.setup} and drawn as 0" if count else ""


def draw_triangles(
    triangles: ScreenTriangles | str | Path,
    generics: dict[str, int],
    setup: SetupChoice,
    engine: EngineChoice,
) -> Drawing:
    """
    Draw triangles that are on the screen already.

    Parameters
    ----------
    triangles : ScreenTriangles, str or Path
      Or a triangles file (``docs/reference/triangles_file.md``).
    generics : dict of str to int
      Those that the user has set.
    setup : SetupChoice
    engine : EngineChoice

    Returns
    -------
    Drawing

    Raises
    ------
    QuadshadeError
      A malformed file, triangles that the core cannot draw or that are too many, or a missing engine.
    """
    if isinstance(triangles, ScreenTriangles):
        name, loaded = "triangles", triangles
        formats = triangle_formats(triangles).with_generics(generics)
    elif not isinstance(triangles, str | Path):
        raise QuadshadeError(
            f"the triangles are of type {type(triangles).__name__}", "give a path or ScreenTriangles"
        )
    else:
        name = str(triangles)
        loaded, formats = open_triangles(Path(triangles), generics)
    try:
        return draw(
            loaded, formats, engine.engine or default_engine(), engine.waves_path, **setup.arguments()
        )
    except MemoryError:
        raise QuadshadeError(
            f"{name}: {len(loaded)} triangles are too many for this machine's memory", "split the file"
        ) from None


def triangle_formats(triangles: ScreenTriangles) -> Formats:
    """Formats of a core for triangles: their channels, depth and shade unit; the rest is the default."""
    shade = {} if triangles.shade is None else {"with_shade": 1, "num_specular": len(triangles.shade.tables)}
    return Formats(num_channels=len(triangles.channels), with_depth=int(triangles.depth is not None), **shade)
