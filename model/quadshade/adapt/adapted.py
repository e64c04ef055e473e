# SPDX-License-Identifier: Apache-2.0
"""A mesh for an allowed error or a budget: the best picture of each kind of channels, and of those."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from quadshade.adapt.colour_shader import ColourShader
from quadshade.adapt.cosine_shader import CosineShader, LightShader
from quadshade.adapt.curve import Curve, Picture
from quadshade.adapt.phong_pixels import PhongPixels
from quadshade.adapt.plan import LineCount, Planner
from quadshade.adapt.refit import Refit
from quadshade.adapt.result import Adapted, Rival
from quadshade.adapt.shader import OUTPUT_ROUNDING, Shader
from quadshade.choices import ADAPTIVE_FITS, FITS, MEASURES, UNITS, check_word
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.packing.line import picture_line_bytes
from quadshade.scene.project import Projected
from quadshade.shading.lights import Light
from quadshade.shading.material import Material
from quadshade.shading.specular import specular_formats

SHADERS = {kind.shading: kind for kind in (ColourShader, CosineShader, LightShader)}
SHADINGS = (*SHADERS, "auto")
FITTED = ("num_channels", "with_shade", "num_specular")
"""Generics that are fitted to the lights where the core has no shade unit."""
HOPELESS = 1.4
"""A kind of channels whose first picture takes so many times as much as another's, or the budget, is left."""
CLOSE = 1.1
"""Kinds of channels whose picture takes up to so many times as much as the cheapest are fitted anew too."""
WINDOW = 3
"""Limits whose pictures are fitted anew for an error; so many too dear ones end a budget's search."""


class ErrorCurve:
    """
    What a scene can be drawn for: the pictures for one error or budget after another, of one curve.

    More bytes never give more error, and a larger allowed error never costs more bytes.

    Parameters
    ----------
    projected, lights, material, formats, measure, verify, shading, specular, count_line, fit
      As for :func:`adapt`.

    Raises
    ------
    QuadshadeError
      As :func:`adapt`, for what is not about an error or a budget.
    """

    def __init__(
        self,
        projected: Projected,
        lights: Sequence[Light] | None = None,
        material: Material | None = None,
        formats: Formats | None = None,
        *,
        measure: str = "max",
        verify: bool = True,
        shading: str = "quadratic",
        specular: Formats | None = None,
        count_line: LineCount = picture_line_bytes,
        fit: str = ADAPTIVE_FITS[0],
    ) -> None:
        check_word("fit of an adaptive picture", fit, ADAPTIVE_FITS)
        if fit != ADAPTIVE_FITS[0] and (measure != "max" or not verify):
            raise QuadshadeError(
                f"the fit {fit} of an adaptive picture is for the largest error, verified",
                "leave out the fit, or the error measure and what leaves the verification out",
            )
        self.fit = fit
        # Limits that are looked at for pictures fitted anew, and ended by so many too dear ones.
        self._window = WINDOW if fit in FITS else 0
        self._refits: dict[tuple[str, int], Picture] = {}
        check_word("error measure", measure, MEASURES)
        check_word("shading", shading, SHADINGS)
        self.measure, self.verify = measure, verify
        self._planners: dict[str, Planner] = {}
        self._curves: dict[str, Curve] = {}
        self.refused: dict[str, QuadshadeError] = {}
        phong: PhongPixels | None = None
        for kind in SHADERS if shading == "auto" else (shading,):
            try:
                shader = _shader(kind, projected, lights, material, formats, specular, measure, verify)
                # Light that the shade unit cannot hold is known now.
                _ = shader.table().state
                if phong is None:
                    # Cosines' core has the same output and sub-pixels as that of colours.
                    phong = PhongPixels(projected, shader.lights, shader.material, shader.formats)
                self._planners[kind] = Planner(projected, shader, phong, count_line)
            except QuadshadeError as reason:
                self.refused[kind] = reason
        if not self._planners:
            raise next(iter(self.refused.values()))

    @property
    def curves(self) -> list[Curve]:
        """Those of all kinds of channels that can be had."""
        return self._curves_of(self._planners)

    def _curves_of(self, kinds: Iterable[str]) -> list[Curve]:
        """Of some kinds, each fitted when it is first asked for."""
        for kind in kinds:
            if kind not in self._curves and kind not in self.refused:
                try:
                    curve = Curve(self._planners[kind], self.verify)
                    # What the set-up cannot draw is known now.
                    _ = curve.planner.whole
                    self._curves[kind] = curve
                except QuadshadeError as reason:
                    self.refused[kind] = reason
        found = [self._curves[kind] for kind in kinds if kind in self._curves]
        if not found:
            raise next(iter(self.refused.values()))
        return found

    def _possible(self, max_error: float) -> tuple[list[Curve], list[Rival]]:
        """Kinds of channels whose picture for an error may take least, and what others take at least."""
        if self.measure != "max" or not self.verify or len(self._planners) == 1:
            return self.curves, []
        bounds = {kind: planner.least_possible(max_error) for kind, planner in self._planners.items()}
        kinds = sorted(bounds, key=lambda kind: bounds[kind])
        first = self._curves_of(kinds[:1])[0] if kinds[0] not in self.refused else None
        if first is None or first.planner.divides_much(max_error):
            return self.curves, []
        index = first.first_within(max_error)
        first.draw_around(index)
        picture = first.picture(index)
        most = picture.cost("bytes") if picture.error <= max_error else math.inf
        for kind, planner in self._planners.items():
            alike = planner is not first.planner and planner.shader.names == first.planner.shader.names
            if alike and bounds[kind] <= most:
                bounds[kind] = max(bounds[kind], planner.least_beside(first.planner, max_error))
        hopeless = [kind for kind in kinds if bounds[kind] > most]
        curves = self._curves_of([kind for kind in self._planners if kind not in hopeless])
        return curves, [Rival(kind, bounds[kind]) for kind in hopeless]

    def least_possible(self, max_error: float) -> int:
        """Bytes that no verified picture for a largest error is below, whatever its polynomials."""
        return min(planner.least_possible(max_error) for planner in self._planners.values())

    def for_error(self, max_error: float) -> Adapted:
        """The picture of the fewest bytes that keeps an error; see :func:`adapt`."""
        least = OUTPUT_ROUNDING if self.measure == "max" else float(np.sqrt(OUTPUT_ROUNDING**2 / 3))
        if not max_error > least:
            raise QuadshadeError(
                f"the allowed error is {max_error:g}",
                f"rounding the output costs {least:.3g} alone: give more",
            )
        if max_error == math.inf:
            raise QuadshadeError("the allowed error is infinite", "give a number of grey levels")
        curves, hopeless = self._possible(max_error)
        first = [curve.first_within(max_error) for curve in curves]
        floors = [curve.floor(index) for curve, index in zip(curves, first, strict=True)]
        enough = most = math.inf
        pictures: list[Picture] = []
        for number in np.argsort(floors, kind="stable"):
            curve, index = curves[number], first[number]
            if floors[number] > most:
                # No picture of these channels can win, so none is drawn.
                hopeless.append(Rival(curve.shading, floors[number]))
                continue
            picture = curve.picture(index)
            enough = min(enough, HOPELESS * picture.cost("bytes"))
            if picture.cost("bytes") <= enough:
                picture = curve.cheapest(max_error, "bytes", most)
                most = min(most, picture.cost("bytes") if picture.error <= max_error else math.inf)
            pictures.append(picture)
        if self.fit != ADAPTIVE_FITS[0]:
            least = min(picture.cost("bytes") for picture in pictures)
            for number, picture in enumerate(pictures):
                if picture.cost("bytes") <= CLOSE * least:
                    curve = self._curves[picture.plan.planner.shader.shading]
                    pictures[number] = self._cheapest_refit(curve, picture, max_error)
        pictures.sort(key=lambda picture: (picture.error > max_error, picture.cost("bytes")))
        hopeless.sort(key=lambda rival: rival.bytes or 0)
        return self._adapted(pictures, self.refused, hopeless)

    def for_budget(self, budget: int, unit: str = "bytes") -> Adapted:
        """The picture with the least error that takes no more than a budget; see :func:`adapt`."""
        check_word("budget's unit", unit, UNITS)
        pictures, refused = [], dict(self.refused)
        curves = self.curves
        refused |= self.refused
        for curve in curves:
            least = curve.picture(0).cost(unit)
            picture = curve.best(budget, unit) if least <= HOPELESS * budget else None
            if picture is None:
                refused[curve.shading] = QuadshadeError(
                    f"the budget is {budget} {'bytes on the line' if unit == 'line' else unit}",
                    f"the cheapest picture takes {least}: give more",
                )
            else:
                pictures.append(picture)
        if not pictures:
            raise refused[curves[0].shading]
        pictures.sort(key=lambda picture: (picture.error, picture.cost(unit)))
        if self.fit != ADAPTIVE_FITS[0]:
            pictures[0] = self._best_refit(pictures[0], budget, unit)
        adapted = self._adapted(pictures, refused)
        return replace(adapted, line_bytes=pictures[0].plan.line) if unit == "line" else adapted

    def _refit(self, curve: Curve, index: int) -> Picture:
        """The picture for a limit of the row, parts fitted anew."""
        key = curve.shading, index
        if key not in self._refits:
            limit = float(curve.steps[index])
            plan = Refit(curve.planner, limit).cheapest(curve.cheapest(limit, "bytes").plan)
            self._refits[key] = Picture(plan, plan.error(verify=True))
        return self._refits[key]

    def _cheapest_refit(self, curve: Curve, picture: Picture, max_error: float) -> Picture:
        """What takes least of a picture, of itself fitted anew, and of those for limits a little stricter."""
        plan = Refit(curve.planner, max_error).cheapest(picture.plan)
        first = curve.first_within(max_error)
        tried = [picture, Picture(plan, plan.error(verify=True))]
        tried += [self._refit(curve, index) for index in range(first, min(first + self._window, len(curve)))]
        return min(tried, key=lambda one: (one.error > max_error, one.cost("bytes"), one.error))

    def _best_refit(self, picture: Picture, budget: int, unit: str) -> Picture:
        """The one with the least error that a budget pays for, of a picture and of those fitted anew."""
        shading = picture.plan.planner.shader.shading
        curve = self._curves[shading]
        best, dear = picture, 0
        for index in range(curve.first_within(picture.error), len(curve)):
            tried = self._refit(curve, index)
            paid = tried.cost(unit) <= budget
            dear = 0 if paid else dear + 1
            if paid:
                best = min(best, tried, key=lambda one: (one.error, one.cost(unit)))
            if dear >= max(self._window, 1):
                break
        return best

    def _adapted(
        self, pictures: list[Picture], refused: dict[str, QuadshadeError], hopeless: Sequence[Rival] = ()
    ) -> Adapted:
        """The first picture, and what is known of the second."""
        best = pictures[0].plan.adapted(self.verify)
        rivals = [
            Rival(other.plan.planner.shader.shading, other.plan.bytes, other.error) for other in pictures[1:]
        ]
        for rival in (*rivals, *hopeless):
            return replace(best, rival=rival)
        for kind, reason in refused.items():
            return replace(best, rival=Rival(kind, reason=str(reason)))
        return best


def adapt(
    projected: Projected,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    *,
    max_error: float | None = None,
    budget: int | None = None,
    unit: str = "bytes",
    measure: str = "max",
    verify: bool = True,
    shading: str = "quadratic",
    specular: Formats | None = None,
    count_line: LineCount = picture_line_bytes,
    fit: str = ADAPTIVE_FITS[0],
) -> Adapted:
    """
    Pick for each triangle the cheapest orders, or divide it, for an allowed error or a budget.

    Errors are differences from Phong shading of the undivided mesh, in output units, the rounding of the
    output included, over every pixel drawn.

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights, optional
      By default those that go with the viewer.
    material : Material, optional
    formats : Formats, optional
    max_error : float, optional
      The largest error of any pixel and channel (``max``) or the root mean square (``rms``). This or a
      budget.
    budget : int, optional
      What a picture may take, in ``unit``; of the pictures that ``max_error`` gives for any error, the one
      with the least error that takes no more.
    unit : str
      ``bytes`` of the set-up stream, ``clocks`` of the core, or bytes on the serial ``line``.
    measure : str
      ``max`` or ``rms``.
    verify : bool
      Draw with the golden model, compare every pixel, and be stricter with triangles that exceed the limit.
      Without, the estimate from 28 points of each triangle decides, which is no bound.
    shading : str
      ``quadratic``: red, green and blue. ``quadratic-specular``: diffuse and specular cosines, the power at
      every pixel. ``quadratic-lights``: each light's diffuse and specular part. ``auto``: all are tried, and
      the one is taken that keeps the error in fewest bytes, or whose error is least for the budget.
    specular : Formats, optional
      Of the core that draws cosines; by default ``formats``, fitted to the lights.
    count_line : callable
      Bytes on the line of triangles for a core; by default those of :mod:`quadshade.packing.line`.
    fit : str
      ``six-point``: the planner's own polynomials. ``minimax``: parts are fitted anew at their pixels, a
      light's channels together, and the cheapest orders are taken whose drawing keeps the limit (``max``,
      verified); so are the pictures for some stricter limits. ``auto``: only the picture that is found is
      fitted anew. Never more bytes; it takes longer.

    Returns
    -------
    Adapted

    Raises
    ------
    QuadshadeError
      Neither or both of error and budget, an error that the output's rounding alone exceeds, a budget that
      the cheapest picture exceeds, an unknown unit, measure, shading or fit, a fit with an
      error measure it is not for, a core without three channels; with
      ``quadratic-specular`` :class:`quadshade.shading.specular.UnsuitedError` for a scene without cosines.
    """
    if (max_error is None) == (budget is None):
        raise QuadshadeError(
            "an adaptive picture needs a limit", "give a largest error or a budget, not both"
        )
    curve = ErrorCurve(
        projected, lights, material, formats,
        measure=measure, verify=verify, shading=shading, specular=specular, count_line=count_line, fit=fit,
    )  # fmt: skip
    if budget is not None:
        return curve.for_budget(budget, unit)
    assert max_error is not None
    return curve.for_error(max_error)


def _shader(
    kind: str,
    projected: Projected,
    lights: Sequence[Light] | None,
    material: Material | None,
    formats: Formats | None,
    specular: Formats | None,
    measure: str,
    verify: bool,
) -> Shader:
    """What shades for one choice of channels."""
    if kind == ColourShader.shading:
        return ColourShader(lights, material, formats, projected, measure, even=verify)
    if specular is None:
        given = {} if formats is None else formats.generics()
        if not given.get("with_shade"):
            given = {name: value for name, value in given.items() if name not in FITTED}
        specular = specular_formats(given, projected, lights, material)
    return SHADERS[kind](lights, material, specular, projected, measure)
