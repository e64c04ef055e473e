# SPDX-License-Identifier: Apache-2.0
"""``--lod auto``: in how many triangles a scene looks most like all of it, for a budget."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from quadshade.choices import PHONG
from quadshade.contract.formats import Formats
from quadshade.engine import draw
from quadshade.errors import QuadshadeError
from quadshade.image import paint, visible
from quadshade.rendering.settings import RenderSettings, Reports, reference_settings
from quadshade.rendering.shade import ShownScene, adapted_scene, at_level, show_scene
from quadshade.scene.detail import levels

if TYPE_CHECKING:
    from quadshade.adapt import Adapted
    from quadshade.adapt.plan import LineCount

WORSE = 2
"""So many levels in a row that are worse than one with more triangles end the search."""


def level_for_words(
    settings: RenderSettings, drawer: str, reports: Reports, count_line: LineCount
) -> tuple[Formats, ShownScene]:
    """Formats, and the scene as it is drawn, for who takes words; ``drawer`` computes no Phong shading."""
    formats = settings.checked()
    if settings.scene.interpolation == PHONG:
        raise QuadshadeError(f"the shading is phong, which no {drawer} computes", "use another --shading")
    shown = show_scene(settings, formats, reports)
    return formats, best_level(settings, shown, formats, reports, count_line)


def best_level(
    settings: RenderSettings,
    shown: ShownScene,
    formats: Formats,
    reports: Reports,
    count_line: LineCount,
) -> ShownScene:
    """
    The scene as it is drawn: with ``--lod auto`` in the triangles that are best for the budget.

    All triangles, a half, a quarter and so on are planned for the budget. The golden model draws each plan,
    and the one counts whose picture has the least root mean square from Phong shading of all triangles,
    outlines included.

    Parameters
    ----------
    settings : RenderSettings
    shown : ShownScene
      With all triangles.
    formats, reports, count_line
      As for :func:`quadshade.rendering.shade.shade_scene`.

    Returns
    -------
    ShownScene
      The same object where the level is not to be chosen.

    Raises
    ------
    QuadshadeError
      The budget does not pay for the coarsest level.
    """
    if not settings.scene.chooses_level or not len(shown.projected):
        return shown
    reference = phong_picture(settings, shown, formats)
    best, least, worse, told = None, np.inf, 0, reports
    refusal = QuadshadeError("the budget pays for no level of detail", "give more")
    faces = None
    for count in (len(shown.whole), *levels(len(shown.whole))):
        try:
            scene = at_level(shown, count, settings.scene, formats)
        except QuadshadeError:
            # No coarser one can be made.
            break
        if scene.faces == faces or not len(scene.projected):
            continue
        faces = scene.faces
        reports.step(f"planning {faces} triangles")
        try:
            adapted = adapted_scene(settings, scene, formats, told, count_line)
        except QuadshadeError as reason:
            refusal = reason
            continue
        finally:
            # What is told of one level holds for all.
            told = replace(reports, notice=lambda _: None)
        error = float(np.square(plan_picture(adapted, scene) - reference).mean())
        if error < least:
            best, least, worse = replace(scene, adapted=adapted), error, 0
        else:
            worse += 1
            if worse == WORSE:
                break
    if best is None:
        raise refusal
    return best


def level_note(scene: ShownScene) -> str:
    """What the summary says about a level of detail."""
    whole = len(scene.whole)
    return "" if scene.faces == whole else f", {scene.faces} of the mesh's {whole} triangles used"


def plan_picture(adapted: Adapted, scene: ShownScene) -> np.ndarray:
    """(h, w, 3) float64: what a plan looks like."""
    pixels = draw(adapted.triangles, adapted.formats, "model").pixels
    shown = visible(pixels, scene.projected.width, scene.projected.height)
    full = (1 << adapted.formats.value_bits) - 1
    return paint(shown, pixels.value, scene.ground, full).astype(np.float64)


def phong_picture(settings: RenderSettings, shown: ShownScene, formats: Formats) -> np.ndarray:
    """(h, w, 3) float64: Phong shading of all triangles, without strokes and edges."""
    from quadshade.rendering.draw import render_picture

    projected = shown.projected
    plain = replace(settings, style=replace(settings.style, edges=None, edge_colours=()))
    if plain.style.style != "gooch":
        plain = replace(plain, style=replace(plain.style, style="none"))
    wanted = reference_settings(plain, (projected.width, projected.height), formats.generics())
    wanted = wanted.of_scene(background=tuple(level / 255 for level in shown.ground), supersample=1)
    return render_picture(wanted, Reports(notice=lambda _: None)).array.astype(np.float64)
