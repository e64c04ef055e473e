# SPDX-License-Identifier: Apache-2.0
"""The fits by name: from triangles sampled at six points to those that are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from quadshade.choices import FITS, SMOOTHNESS
from quadshade.contract.arrays import Floats
from quadshade.contract.formats import QUADRATIC, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.fit.elements import Elements, shared_elements
from quadshade.fit.jumps import jump_penalty
from quadshade.fit.places import Places, places_of
from quadshade.fit.solve import least_squares, normal_equations
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.reference import phong_at, quadratic_shape
from quadshade.shading.sample import CHANNELS

ROUNDS = 16
"""Of weighting the largest errors more, ``minimax``."""
FLOOR = 0.02
"""Weight that a place without error keeps in a round."""


def fit_colours(
    projected: Projected,
    triangles: ScreenTriangles,
    fit: str = "least-squares",
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    places: str = "pixels",
    smoothness: float = SMOOTHNESS,
) -> ScreenTriangles:
    """
    The same triangles with the colours that are best over the whole picture.

    Parameters
    ----------
    projected : Projected
    triangles : ScreenTriangles
      Of it, sampled by :func:`quadshade.shading.sample` at six points.
    fit : str
      ``six-point``: as sampled. ``least-squares``: the least squared error against Phong shading.
      ``minimax``: a small largest error, by weights that grow where the error is large (Lawson's iteration).
      ``smooth``: least squares of the error and of the derivative's jumps across edges.
    lights, material, formats
      As for :func:`quadshade.shading.sample`.
    places : str
      Where the error is taken: see :func:`quadshade.fit.places.places_of`.
    smoothness : float
      Weight of the jumps, ``smooth``, in pixels.

    Returns
    -------
    ScreenTriangles
      Neighbours meet in value wherever they did.

    Raises
    ------
    QuadshadeError
      An unknown fit, or triangles that are not colours at six points.
    """
    if fit not in FITS:
        raise QuadshadeError(f"the fit is {fit!r}", f"give one of {', '.join(FITS)}")
    if not 0 <= smoothness <= 1e9:
        raise QuadshadeError(f"the fit's smoothness is {smoothness:g}", "give 0 to 1e9")
    if fit == FITS[0] or not len(triangles):
        return triangles
    if triangles.channels[:3] != CHANNELS or not (triangles.orders[:, :3] == QUADRATIC).all():
        raise QuadshadeError(f"the fit {fit} of what is not quadratic colours", "give the shading quadratic")
    formats = Formats() if formats is None else formats
    material = Material() if material is None else material
    lights = default_lights(projected.axes) if lights is None else lights
    colours = replace(triangles, samples=triangles.samples[:, :3], orders=triangles.orders[:, :3])
    elements = shared_elements(colours)
    here = places_of(places, projected, formats)
    shape = quadratic_shape(here.weights)
    target = phong_at(projected, here.triangle, here.weights, lights, material, formats)
    penalty = None
    if fit == "smooth":
        penalty = smoothness * jump_penalty(elements, projected.vertices, formats)
    normal = normal_equations(len(projected), here, shape, target, here.area)
    largest = 2.0**formats.value_bits - 1
    values = least_squares(elements, normal, largest, penalty)
    if fit == "minimax":
        values = _minimax(elements, here, shape, target, values, largest)
    samples = triangles.samples.copy()
    samples[:, :3] = elements.samples(values)
    return replace(triangles, samples=samples)


def _minimax(
    elements: Elements,
    places: Places,
    shape: Floats,
    target: Floats,
    values: Floats,
    largest: float,
) -> Floats:
    """Lawson's iteration: each round weights a place by its error, and the best round counts."""
    best, least, weight = values, np.inf, places.area
    for number in range(ROUNDS + 1):
        drawn = np.einsum("ps,psc->pc", shape, values[elements.index[places.triangle]])
        error = np.abs(drawn - target).max(axis=1)
        if error.max() < least:
            best, least = values, error.max()
        if number == ROUNDS:
            break
        weight = weight * (FLOOR + error / max(error.max(), 1e-12))
        weight *= places.area.sum() / weight.sum()
        normal = normal_equations(len(elements.index), places, shape, target, weight)
        values = least_squares(elements, normal, largest, begin=values)
    return best
