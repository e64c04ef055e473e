# SPDX-License-Identifier: Apache-2.0
"""All that a user asks for, handed over whole, and what excludes what in it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeVar

from quadshade.choices import (
    ADAPTIVE_FITS,
    ADAPTIVE_SHADINGS,
    DEFAULT_SHADING,
    FITS,
    MEASURES,
    OWN_SAMPLES,
    PHONG,
    SETUPS,
    SHADING_ORDERS,
    SPECULAR_FITS,
    SPECULAR_ORDERS,
    STYLES,
)
from quadshade.contract.formats import CONSTANT, Formats
from quadshade.errors import QuadshadeError
from quadshade.rendering.groups import (
    COLOUR_CHANNELS,
    AdaptChoice,
    EngineChoice,
    PortChoice,
    SceneChoice,
    SetupChoice,
    StyleChoice,
)
from quadshade.rendering.keywords import check_kind
from quadshade.style.illustrate import TOON_STEPS

Kind = TypeVar("Kind")


def warn(text: str) -> None:
    """A notice as a Python warning."""
    warnings.warn(text, stacklevel=4)


def _nothing(_: str) -> None:
    """A step that nobody wants to hear of."""


@dataclass(frozen=True)
class Reports:
    """
    Whom to tell while a picture is made.

    Attributes
    ----------
    notice : callable
      Gets a line about what is not as asked; by default it becomes a warning.
    step : callable
      Gets what is being done now.
    progress : callable, optional
      As for :class:`quadshade.Board`.
    """

    notice: Callable[[str], None] = warn
    step: Callable[[str], None] = _nothing
    progress: Callable[[str, float, float, int], None] | None = None


def collect(kind: type[Kind], keywords: Mapping[str, Any]) -> Kind:
    """
    An object of a frozen dataclass from the keywords that have the names of its fields.

    Raises
    ------
    QuadshadeError
      A value of another kind than its keyword takes, or one that the class refuses.
    """
    given = {one.name: one.default for one in fields(kind) if one.name in keywords}  # type: ignore[arg-type]
    for name, default in given.items():
        check_kind(name, keywords[name], default)
    return kind(**{name: keywords[name] for name in given})


@dataclass(frozen=True)
class RenderSettings:
    """All that :func:`quadshade.render` is asked for."""

    scene: SceneChoice
    setup: SetupChoice = field(default_factory=SetupChoice)
    adapt: AdaptChoice = field(default_factory=AdaptChoice)
    style: StyleChoice = field(default_factory=StyleChoice)
    engine: EngineChoice = field(default_factory=EngineChoice)
    port: PortChoice = field(default_factory=PortChoice)

    @classmethod
    def collect(cls, keywords: Mapping[str, Any]) -> RenderSettings:
        """
        Settings from keywords of :func:`quadshade.render`, ``scene`` among them.

        Raises
        ------
        QuadshadeError
          A word or number that is out of range.
        TypeError
          A keyword that there is not.
        """
        kinds = (SceneChoice, SetupChoice, AdaptChoice, StyleChoice, EngineChoice, PortChoice)
        unknown = keywords.keys() - {one.name for kind in kinds for one in fields(kind)}
        if unknown:
            raise TypeError(f"there is no keyword {', '.join(sorted(unknown))}")
        return cls(
            collect(SceneChoice, keywords),
            collect(SetupChoice, keywords),
            collect(AdaptChoice, keywords),
            collect(StyleChoice, keywords),
            collect(EngineChoice, keywords),
            collect(PortChoice, keywords),
        )

    def of_scene(self, **changes: Any) -> RenderSettings:
        """The same settings with some of the scene's replaced."""
        return replace(self, scene=replace(self.scene, **changes))

    @property
    def core_generics(self) -> dict[str, int]:
        """The generics that the user has set, without those that a simulated board has beside its core."""
        from quadshade.board.settings import own_names

        given = self.scene.set_generics
        others = own_names() if self.port.is_simulated else []
        return {name: value for name, value in given.items() if name not in others}

    def checked(self) -> Formats:
        """
        Refuse what contradicts itself, before any work is done; the formats that are asked for.

        Raises
        ------
        QuadshadeError
        """
        from quadshade.scene.project import check_size
        from quadshade.style.gbuffer import check_gbuffer

        scene, shading = self.scene, self.scene.interpolation
        formats = Formats().with_generics(self.core_generics)
        if self.port.port is None:
            # Boards draw larger pictures in tiles, and say themselves what is too large.
            check_size(*scene.pixels, formats)
        if not self.adapt.is_adaptive:
            _check_orders(shading, formats)
        elif not formats.with_shade:
            check_colours(formats)
        method = self.setup.setup
        if method != SETUPS[0] and not shading.startswith("quadratic"):
            raise QuadshadeError(f"--setup {method} is for quadratic channels, the shading is {shading}")
        self._check_fit()
        if scene.toon is not None and shading not in SPECULAR_ORDERS:
            raise QuadshadeError(
                f"--toon with the shading {shading}", f"give --shading {' or '.join(SPECULAR_ORDERS)}"
            )
        if scene.chooses_level and self.adapt.budget is None:
            raise QuadshadeError("--lod auto without a budget", "give --budget, or a number of triangles")
        if self.port.port is not None and self.adapt.clock is not None:
            raise QuadshadeError("--clock is given, and the board has its own", "leave it out")
        if self.port.port is None and self.adapt.frame_time is None:
            for name, value in (("baud", self.port.baud), ("pack-error", self.port.pack_error)):
                if value is not None:
                    raise QuadshadeError(f"--{name} is for a board", "give --port as well")
        if self.adapt.is_adaptive:
            self._check_adaptive()
        if self.adapt.frame_time is not None and scene.supersample != 1:
            raise QuadshadeError("--supersample with a frame time", "leave one of them out")
        if self.style.needs_gbuffer and not self.port.is_given:
            check_gbuffer(self.gbuffer_formats(), self.style.gbuffer_order)
        return formats

    def gbuffer_formats(self) -> Formats:
        """Formats of the G-buffer's core: of the generics it takes three channels and no shade unit."""
        return Formats().with_generics({**self.core_generics, "num_channels": 3, "with_shade": 0})

    def _check_fit(self) -> None:
        """Refuse a fit of what is not fitted."""
        scene, shading, method = self.scene, self.scene.interpolation, self.setup.setup
        if scene.fit == FITS[0] or self.adapt.is_adaptive:
            return
        if scene.fit not in FITS:
            raise QuadshadeError(f"--fit {scene.fit} without --max-error or --budget", "give one of them")
        fitted = FITS if shading == DEFAULT_SHADING else SPECULAR_FITS
        what = None
        if scene.fit not in fitted or shading not in (DEFAULT_SHADING, "quadratic-specular"):
            what = f"the shading {shading}"
        elif method != SETUPS[0]:
            what = f"--setup {method}"
        elif scene.toon is not None:
            what = "steps of a cartoon (--toon)"
        if what is not None:
            raise QuadshadeError(f"--fit {scene.fit} with {what}", "leave one of them out")

    def _check_adaptive(self) -> None:
        """Refuse a shading or set-up that leaves nothing to choose."""
        shading = self.scene.interpolation
        if shading not in ADAPTIVE_SHADINGS:
            raise QuadshadeError(
                f"the shading is {shading}, but an error, a budget or a frame time chooses it",
                f"leave --shading out, or give {' or '.join(ADAPTIVE_SHADINGS)}",
            )
        if self.scene.toon is not None:
            raise QuadshadeError(
                "--toon with --max-error or --budget, which are about Phong shading", "leave it out"
            )
        if self.scene.fit not in ADAPTIVE_FITS:
            raise QuadshadeError(
                f"--fit {self.scene.fit} with --max-error or --budget, which choose orders",
                f"give --fit {' or '.join(ADAPTIVE_FITS)}",
            )
        if self.scene.fit != ADAPTIVE_FITS[0] and (
            self.adapt.measure != MEASURES[0] or not self.adapt.is_verified
        ):
            raise QuadshadeError(
                f"--fit {self.scene.fit} with --error-measure rms or --no-verify", "leave one of them out"
            )
        if self.setup.setup in OWN_SAMPLES:
            raise QuadshadeError(f"--setup {self.setup.setup} takes its own samples", "use another --setup")

    def styled(self) -> RenderSettings:
        """
        The settings as a style needs them: white paper, and for a cartoon the shade unit's steps.

        Raises
        ------
        QuadshadeError
          A style with what it excludes.
        """
        scene, style = self.scene, self.style.style
        shading = scene.interpolation
        excluded: tuple[tuple[bool, str], ...] = ()
        if style == "cartoon":
            excluded = (
                (shading not in (DEFAULT_SHADING, *SPECULAR_ORDERS), f"--shading {shading}"),
                (self.adapt.is_adaptive, "--max-error or --budget"),
            )
        elif style == "gooch":
            excluded = (
                (shading in SPECULAR_ORDERS, f"--shading {shading}"),
                (scene.reflectance is not None, "--reflectance"),
            )
        for wrong, what in excluded:
            if wrong:
                raise QuadshadeError(
                    f"--style {style} and {what} exclude each other", "leave one of them out"
                )
        if scene.background is None and (style != STYLES[0] or self.style.kinds):
            scene = replace(scene, background="1")
        if style == "cartoon":
            shading = shading if shading in SPECULAR_ORDERS else "quadratic-specular"
            scene = replace(scene, shading=shading, toon=TOON_STEPS if scene.toon is None else scene.toon)
        return replace(self, scene=scene)


def _check_orders(shading: str, formats: Formats) -> None:
    """Refuse formats that a shading does not go with."""
    if shading not in SPECULAR_ORDERS:
        check_colours(formats)
    needed = (SHADING_ORDERS | SPECULAR_ORDERS | {PHONG: CONSTANT})[shading]
    if formats.max_order < needed:
        raise QuadshadeError(f"generic max_order is {formats.max_order}", f"shading {shading} needs {needed}")


def check_colours(formats: Formats) -> None:
    """The channels that colours need; a shade unit passes three of more."""
    got = formats.num_channels
    if got < COLOUR_CHANNELS or (got > COLOUR_CHANNELS and not formats.with_shade):
        raise QuadshadeError(f"generic num_channels is {got}", f"a picture needs {COLOUR_CHANNELS}")


COVERAGE_GENERICS = (
    "with_depth",
    "word_width",
    "frac_bits",
    "value_bits",
    "depth_bits",
    "subpixel_bits",
    "coord_bits",
    "stream_width",
)
"""Generics that say which pixels a core covers, which of them is nearest, and what full intensity is."""


def reference_settings(
    settings: RenderSettings, size: tuple[int, int], generics: Mapping[str, int]
) -> RenderSettings:
    """
    Settings of the picture that one with ``settings`` is compared with: Phong shading over its coverage.

    Parameters
    ----------
    settings : RenderSettings
    size : tuple of int
      Width and height of the picture.
    generics : mapping of str to int
      Of the core that drew it.
    """
    kept = {name: generics[name] for name in COVERAGE_GENERICS}
    plain = RenderSettings(
        replace(
            settings.scene,
            shading=PHONG,
            size=size,
            generics=kept,
            fit=FITS[0],
            smoothness=None,
            jump=None,
            lod=None,
        ),
        style=replace(settings.style, gbuffer=None),
        engine=EngineChoice("model"),
    )
    return plain
