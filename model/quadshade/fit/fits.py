# SPDX-License-Identifier: Apache-2.0
"""The fits by name: from triangles sampled at six points to those that are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from quadshade.choices import FITS, JUMP, SMOOTHNESS, SPECULAR_FITS
from quadshade.contract.arrays import Floats, Ints
from quadshade.contract.formats import QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.fit import solve
from quadshade.fit.c1 import Target, anything_seen, fit_c1
from quadshade.fit.cosines import fit_cosines
from quadshade.fit.elements import shared_elements
from quadshade.fit.jumps import jump_penalty
from quadshade.fit.places import Places, held_beyond, places_of, without_wrong
from quadshade.fit.solve import MOST_STEPS
from quadshade.fit.weighting import Weighted, lower_peaks, smallest_peak
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.reference import phong_at
from quadshade.shading.sample import CHANNELS, sample

WEIGHTED = {"minimax": smallest_peak, "least-squares": lower_peaks}
"""What makes the largest error of a fit smaller."""


MOST_SPLIT = 1_000_000
"""Values of a mesh that ``c1`` splits; more take minutes and gigabytes."""


class _UnshadedError(Exception):
    """Phong shading has no colour for some place: a reflectance of the user's own."""


@dataclass(frozen=True)
class Fitted:
    """
    What a fit makes of a scene.

    Attributes
    ----------
    triangles : ScreenTriangles
    projected : Projected
      The scene of these triangles: ``c1`` sends parts of some.
    parent : (n,) int64
      The triangle that each of them lies in.
    notes : tuple of str
      Where it is not what was asked for, a sentence each.
    """

    triangles: ScreenTriangles
    projected: Projected
    parent: Ints
    notes: tuple[str, ...] = ()


def fit_colours(
    projected: Projected,
    triangles: ScreenTriangles,
    fit: str = "least-squares",
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    places: str = "pixels",
    smoothness: float = SMOOTHNESS,
    jump: float = JUMP,
) -> ScreenTriangles:
    """The triangles of :func:`fit_scene`, whose arguments these are."""
    return fit_scene(projected, triangles, fit, lights, material, formats, places, smoothness, jump).triangles


def fit_scene(
    projected: Projected,
    triangles: ScreenTriangles,
    fit: str = "least-squares",
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    places: str = "pixels",
    smoothness: float = SMOOTHNESS,
    jump: float = JUMP,
    moves: Sequence[tuple[int, int]] = ((0, 0),),
) -> Fitted:
    """
    The same triangles with the colours that are best over the whole picture.

    Parameters
    ----------
    projected : Projected
    triangles : ScreenTriangles
      Of it, sampled by :func:`quadshade.shading.sample` at six points, or by
      :func:`quadshade.shading.sample_specular` for the power at the pixel.
    fit : str
      ``six-point``: as sampled. ``least-squares``: the least squared error against Phong shading.
      ``minimax``: a small largest error, by weights that grow where the error is large (Lawson's iteration).
      ``smooth``: least squares of the error and of the derivative's jumps across edges. ``c1``: least squares
      without jumps, triangles split where there would be one. Cosines take the first three.
    lights, material, formats
      As for :func:`quadshade.shading.sample`.
    places : str
      Where the error is taken: see :func:`quadshade.fit.places.places_of`.
    smoothness : float
      Weight of the jumps, ``smooth``, in pixels.
    jump : float
      Of the derivative across an edge, root mean square, that may stay, ``c1``; grey levels per pixel.
    moves : sequence of (int, int)
      Sub-pixels by which the triangles are moved before they are drawn: parts cover what their triangle
      covers at all of these.

    Returns
    -------
    Fitted
      Neighbours meet in value wherever they did.

    Raises
    ------
    QuadshadeError
      An unknown fit, or triangles that are neither colours nor cosines at six points.
    """
    if fit not in FITS:
        raise QuadshadeError(f"the fit is {fit!r}", f"give one of {', '.join(FITS)}")
    if not 0 <= smoothness <= 1e9:
        raise QuadshadeError(f"the fit's smoothness is {smoothness:g}", "give 0 to 1e9")
    if not 0 <= jump <= 1e9:
        raise QuadshadeError(f"the fit's jump is {jump:g}", "give 0 to 1e9 grey levels per pixel")
    whole = np.arange(len(triangles))
    if fit == FITS[0] or not len(triangles):
        return Fitted(triangles, projected, whole)
    formats = Formats() if formats is None else formats
    material = Material() if material is None else material
    lights = default_lights(projected.axes) if lights is None else lights
    if triangles.shade is not None and triangles.channels[:1] == ("d0",):
        if fit not in SPECULAR_FITS:
            raise QuadshadeError(f"the fit {fit} of cosines", f"give {', '.join(SPECULAR_FITS)}")
        here = places_of(places, projected, formats)
        fitted = fit_cosines(projected, triangles, here, fit, lights, material, formats)
        return Fitted(fitted, projected, whole)
    if triangles.channels[:3] != CHANNELS or not (triangles.orders[:, :3] == QUADRATIC).all():
        raise QuadshadeError(f"the fit {fit} of what is not quadratic colours", "give the shading quadratic")
    wrong: list[int] = []

    def target(drawn: Projected) -> tuple[Places, Floats]:
        here = places_of(places, drawn, formats)
        try:
            colour = phong_at(drawn, here.triangle, here.weights, lights, material, formats)
        except QuadshadeError as reason:
            raise _UnshadedError(reason.message) from reason
        here, colour, lost = without_wrong(here, colour)
        wrong[:] = [lost]
        return here, colour

    colours = replace(triangles, samples=triangles.samples[:, :3], orders=triangles.orders[:, :3])
    elements = shared_elements(colours)
    largest = 2.0**formats.value_bits - 1
    most = {"smooth": solve.MOST_FACTORISED, "c1": MOST_SPLIT}.get(fit, np.inf)
    large: tuple[str, ...] = ()
    split = fit == "c1" and anything_seen(projected, jump, formats)
    if len(elements.start) > most and (split or fit == "smooth"):
        large = (f"fit: drawn by least squares: {len(elements.start)} values are too many for {fit}",)
        split, fit = False, "least-squares" if fit == "smooth" else fit
    try:
        if split:
            asked = Target(
                lambda drawn: sample(drawn, lights=lights, material=material, formats=formats), target
            )
            smooth = fit_c1(projected, elements, asked, jump, largest, formats, moves)
            notes = _notes(wrong[0], smooth.ended, smooth.unsplit)
            return Fitted(smooth.triangles, smooth.projected, smooth.parent, notes)
        here, colour = target(projected)
    except _UnshadedError as reason:
        return Fitted(triangles, projected, whole, (f"fit: drawn through six points: {reason}",))
    beyond = held_beyond(projected, formats) if places == "pixels" else np.zeros(len(projected))
    system = Weighted(elements, here, colour, beyond, 0, largest)
    if fit == "smooth":
        solution = system.solve_smooth(smoothness * jump_penalty(elements, projected.vertices, formats))
        values = solution.values
    else:
        solution = system.solve(here.area)
        values = solution.values
        if fit in WEIGHTED:
            values = WEIGHTED[fit](system, values)
    samples = triangles.samples.copy()
    samples[:, :3] = elements.samples(values)
    notes = large + _notes(wrong[0], solution.ended)
    return Fitted(replace(triangles, samples=samples), projected, whole, notes)


def _notes(wrong: int, ended: bool, unsplit: int = 0) -> tuple[str, ...]:
    """What a fit has to say."""
    notes = []
    if wrong:
        notes.append(
            f"fit: {wrong} triangles have colours that are no numbers and keep their six points there"
        )
    if unsplit:
        notes.append(
            f"fit: {unsplit} triangles are too small to be split, or share an edge with more than one other:"
            " the derivative may jump there"
        )
    if not ended:
        notes.append(f"fit: the best after {MOST_STEPS} steps is drawn, not the best of all")
    return tuple(notes)
