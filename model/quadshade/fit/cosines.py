# SPDX-License-Identifier: Apache-2.0
"""
Cosines whose final colour is best: least squares through the power that the hardware takes at the pixel.

A specular cosine counts as far as its power does. Every round weights a place with the square of the power's
slope, between the cosine that is drawn there and the one that should be: the squared error of that round is
that of the colour (Gauss and Newton, with secants). A diffuse cosine counts where there is light; in the
dark it only has to be negative. The best round by the colour's error counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from quadshade.contract.arrays import Floats
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.fit.elements import shared_elements
from quadshade.fit.places import Places
from quadshade.fit.weighting import FLOOR, ROUNDS, Weighted
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light, PointedLight
from quadshade.shading.material import Material
from quadshade.shading.reference import phong_at
from quadshade.shading.sample import SAMPLE_POINTS
from quadshade.shading.specular import ambient_colour, cosines, light_colours, specular_lights

DARK = 0.02
"""Weight of a place in the dark, where a diffuse cosine only has to be negative."""
FAINT = 1e-6
"""Weight of a place without specular light."""
SECANTS = 4
"""Rounds, least squares."""
CHUNK = 1 << 15


@dataclass(frozen=True)
class _Scene:
    """Cosines (p, lights) and colours (p, 3) that should be at places, and what makes colours of cosines."""

    diffuse: Floats
    specular: Floats
    colour: Floats
    ambient: Floats
    reflected: tuple[Floats, Floats]
    exponent: float

    def error(self, diffuse: Floats, specular: Floats) -> Floats:
        """(p, 3) what drawn cosines are off by, 1 for full intensity."""
        lit = np.maximum(diffuse, 0)
        shine = (diffuse > 0) * self.power(specular)
        drawn = self.ambient + lit @ self.reflected[0] + shine @ self.reflected[1]
        return np.clip(drawn, 0, 1) - self.colour

    def power(self, cosine: Floats) -> Floats:
        """What the table makes of a cosine."""
        return np.clip(cosine, 0, 1) ** self.exponent

    def slope(self, drawn: Floats) -> Floats:
        """(p, lights) of the power between drawn and true cosines, as a share of its largest slope."""
        step = np.abs(drawn - self.specular)
        rise = np.abs(self.power(drawn) - self.power(self.specular))
        tangent = self.exponent * np.clip(self.specular, 0, 1) ** (self.exponent - 1)
        return np.where(step > 1e-7, rise / np.maximum(step, 1e-7), tangent) / self.exponent


def fit_cosines(
    projected: Projected,
    triangles: ScreenTriangles,
    places: Places,
    fit: str,
    lights: Sequence[Light],
    material: Material,
    formats: Formats,
) -> ScreenTriangles:
    """
    The same triangles with the cosines that make the best colours.

    Parameters
    ----------
    projected : Projected
    triangles : ScreenTriangles
      Of it, from :func:`quadshade.shading.sample_specular`, without curves.
    places : Places
    fit : str
      ``least-squares`` or ``minimax``.
    lights, material, formats
      As for :func:`quadshade.shading.sample_specular`.

    Returns
    -------
    ScreenTriangles

    Raises
    ------
    UnsuitedError
      A scene for which it takes colour channels.
    """
    pointed = specular_lights(projected, lights, material)
    count, top = len(pointed), (1 << formats.value_bits) - 1
    first = formats.num_channels - formats.num_specular
    channels = np.r_[:count, first : first + count]
    scene = _scene(projected, places, pointed, lights, material, formats)
    elements = shared_elements(replace(triangles, samples=triangles.samples[:, channels]))
    true = np.concatenate([scene.diffuse, scene.specular], axis=1)
    used = np.isfinite(true).all(axis=1) & np.isfinite(scene.colour).all(axis=1)
    area = places.area * used
    parts = [
        Weighted(
            replace(elements, start=elements.start[:, [channel]] / top),
            places,
            np.where(used, true[:, channel], 0.0)[:, None],
            np.zeros(len(triangles)),
            -1.0,
            1.0,
        )
        for channel in range(2 * count)
    ]
    values = elements.start / top
    best, least, peaks = values, np.inf, np.ones(len(area))
    for number in range(1 + (ROUNDS if fit == "minimax" else SECANTS)):
        drawn = np.stack(
            [part.drawn(values[:, [channel]])[:, 0] for channel, part in enumerate(parts)], axis=1
        )
        error = np.abs(np.where(used[:, None], scene.error(drawn[:, :count], drawn[:, count:]), 0))
        peak = error.max(axis=1)
        size = peak.max(initial=0.0) if fit == "minimax" else float(area @ (error**2).sum(axis=1))
        if size < least:
            best, least = values, size
        if fit == "minimax" and number:
            peaks = peaks * (FLOOR + peak / max(peak.max(initial=0.0), 1e-12))
            peaks *= area.sum() / max(float(area @ peaks), 1e-300)
        lit = scene.diffuse > 0
        weight = np.concatenate(
            [
                np.where(lit | (drawn[:, :count] > 0), 1.0, DARK),
                FAINT + lit * scene.slope(drawn[:, count:]) ** 2,
            ],
            axis=1,
        )
        values = np.concatenate(
            [
                part.solve(area * peaks * weight[:, channel], begin=values[:, [channel]]).values
                for channel, part in enumerate(parts)
            ],
            axis=1,
        )
    samples = triangles.samples.copy()
    samples[:, channels] = elements.samples(best * top)
    return replace(triangles, samples=samples)


def _scene(
    projected: Projected,
    places: Places,
    pointed: Sequence[PointedLight],
    lights: Sequence[Light],
    material: Material,
    formats: Formats,
) -> _Scene:
    """What is to be drawn at places."""
    _, _, strength = cosines(projected, pointed, material, SAMPLE_POINTS)
    diffuse, specular = np.empty((2, len(places.triangle), len(pointed)))
    for start in range(0, len(places.triangle), CHUNK):
        rows = slice(start, start + CHUNK)
        here, points = projected.ordered(places.triangle[rows]), places.weights[rows, None]
        both = cosines(here, pointed, material, points, strength)
        diffuse[rows], specular[rows] = (both[which][..., 0].T for which in (0, 1))
    colour = phong_at(projected, places.triangle, places.weights, lights, material, formats)
    return _Scene(
        diffuse,
        specular,
        colour / (2.0**formats.value_bits - 1),
        ambient_colour(lights, material),
        light_colours(pointed, material, strength),
        material.exponent,
    )
