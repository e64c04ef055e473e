# SPDX-License-Identifier: Apache-2.0
"""
Groups of settings, each checked when it is made.

Every field has the name of a keyword of :func:`quadshade.render`, which is also that of the command line's
option; it holds what was given, text or object. Properties say what it means.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from quadshade.choices import (
    ALL_FITS,
    AUTO,
    DEFAULT_SHADING,
    DEFAULT_SIZE,
    EDGE_KINDS,
    EDGE_VARIANTS,
    GBUFFER_ORDERS,
    MAX_ERROR,
    MEASURES,
    PACK_ERROR,
    ROUNDINGS,
    SETUPS,
    SHADINGS,
    SPACES,
    STEPPINGS,
    STYLES,
    SUPERSAMPLES,
    VERIFIES,
    check_word,
    parse_budget,
    parse_clock,
    parse_faults,
    parse_frame_time,
    parse_limit,
    parse_lod,
    parse_pack_error,
    parse_ports,
    parse_verify,
)
from quadshade.contract.formats import Formats, parse_generics
from quadshade.errors import QuadshadeError
from quadshade.scene.key_values import parse_background, parse_size

if TYPE_CHECKING:
    import trimesh

    from quadshade.board.tile_store import TileStore
    from quadshade.scene import Camera, Mesh
    from quadshade.scene.turned import Turn
    from quadshade.shading import Light, Material
    from quadshade.shading.material import Reflectance

COLOUR_CHANNELS = 3


@dataclass(frozen=True)
class SceneChoice:
    """What is looked at, from where, in which light, and how its colours are interpolated."""

    scene: str | Path | Mesh | Turn | trimesh.Trimesh | trimesh.Scene
    shading: str | None = None
    size: str | tuple[int, int] | None = None
    camera: str | Camera = ""
    lights: str | Light | Sequence[str | Light] = ()
    material: str | Material = ""
    exponent: float | None = None
    toon: int | None = None
    reflectance: str | Reflectance | None = None
    cull: bool = True
    crease: float | None = None
    background: str | float | Sequence[float] | None = None
    generics: Mapping[str, int] | Sequence[str] | Formats = ()
    fit: str = ALL_FITS[0]
    smoothness: float | None = None
    jump: float | None = None
    supersample: int = 1
    lod: str | int | None = None

    def __post_init__(self) -> None:
        if self.shading is not None:
            check_word("shading", self.shading, SHADINGS)
        check_word("fit", self.fit, ALL_FITS)
        if self.smoothness is not None and self.fit != "smooth":
            raise QuadshadeError(f"a smoothness with the fit {self.fit}", "give --fit smooth")
        if self.jump is not None and self.fit != "c1":
            raise QuadshadeError(f"a jump with the fit {self.fit}", "give --fit c1")
        parse_lod(self.lod)
        if self.supersample not in SUPERSAMPLES:
            raise QuadshadeError(
                f"the supersample is {self.supersample}", f"give {', '.join(map(str, SUPERSAMPLES))}"
            )

    @property
    def name(self) -> str:
        """What the scene is called in reports."""
        return str(self.scene) if isinstance(self.scene, str | Path) else "mesh"

    @property
    def level(self) -> int | None:
        """Triangles at most, where that is a number."""
        level = parse_lod(self.lod)
        return level if isinstance(level, int) else None

    @property
    def chooses_level(self) -> bool:
        """Whether the budget says in how many triangles the scene is drawn."""
        return parse_lod(self.lod) == AUTO

    @property
    def interpolation(self) -> str:
        """The shading, by default ``quadratic``."""
        return self.shading or DEFAULT_SHADING

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height."""
        if self.size is None or isinstance(self.size, str):
            return parse_size(DEFAULT_SIZE if self.size is None else self.size)
        return parse_size("x".join(map(str, self.size)))

    @property
    def ground(self) -> tuple[int, int, int]:
        """The background, 8 bits each; black by default."""
        given = self.background
        if given is None or isinstance(given, str):
            return parse_background("0" if given is None else given)
        numbers = given if isinstance(given, Sequence) else (given,)
        return parse_background(",".join(map(str, numbers)))

    @property
    def set_generics(self) -> dict[str, int]:
        """The generics that the user has set."""
        if isinstance(self.generics, Formats):
            return self.generics.generics()
        if isinstance(self.generics, Mapping):
            return dict(self.generics)
        return parse_generics(self.generics)


@dataclass(frozen=True)
class SetupChoice:
    """Where coefficients come from, how they are rounded and stepped, and how far a triangle may be off."""

    setup: str = SETUPS[0]
    rounding: str = ROUNDINGS[0]
    stepping: str = STEPPINGS[0]
    strict: bool | float | None = None
    divide: float | None = None

    def __post_init__(self) -> None:
        check_word("set-up", self.setup, SETUPS)
        check_word("rounding", self.rounding, ROUNDINGS)
        check_word("stepping", self.stepping, STEPPINGS)
        if self.is_strict and self.divide is not None:
            raise QuadshadeError("--strict and --divide are given", "give one of them")
        parse_limit(self.limit)

    @property
    def is_strict(self) -> bool:
        """Whether a triangle beyond the limit is refused, not divided."""
        return self.strict is not None and self.strict is not False

    @property
    def limit(self) -> float:
        """Grey levels that a triangle's bound may be."""
        given = self.strict if self.is_strict else self.divide
        return MAX_ERROR if given is None or given is True else given

    def arguments(self) -> dict[str, Any]:
        """Arguments of :func:`quadshade.engine.draw` and :meth:`quadshade.Board.draw`."""
        return {
            "fractional": self.stepping == STEPPINGS[1],
            "rounding": self.rounding,
            "method": self.setup,
            "limit": parse_limit(self.limit),
            "strict": self.is_strict,
        }


@dataclass(frozen=True)
class AdaptChoice:
    """An allowed error, a budget or a frame time, for which orders are chosen, triangles divided; or none."""

    max_error: float | None = None
    budget: str | int | tuple[int, str] | None = None
    error_measure: str | None = None
    verify: bool | str = True
    frame_time: float | None = None
    clock: float | None = None

    def __post_init__(self) -> None:
        if self.frame_time is not None:
            parse_frame_time(self.frame_time)
            if self.max_error is not None or self.budget is not None:
                raise QuadshadeError("a frame time with --max-error or --budget", "give one of them")
        if self.clock is not None:
            parse_clock(self.clock)
            if self.frame_time is None:
                raise QuadshadeError("--clock is for a frame time", "give --frame-time as well")
        if self.error_measure is not None:
            check_word("error measure", self.error_measure, MEASURES)
            if not self.is_adaptive:
                raise QuadshadeError(
                    "--error-measure is given without an error", "give --max-error or --budget"
                )
        if self.budget is not None:
            parse_budget(self.budget)

    @property
    def is_verified(self) -> bool:
        """Whether every pixel is compared with Phong shading."""
        return parse_verify(self.verify) != VERIFIES[-1]

    @property
    def is_adaptive(self) -> bool:
        """Whether there is an error, a budget or a frame time."""
        return any(given is not None for given in (self.max_error, self.budget, self.frame_time))

    @property
    def measure(self) -> str:
        """What is meant by error: by default ``max``, in a frame time ``rms``."""
        return self.error_measure or MEASURES[self.frame_time is not None]

    @property
    def number_and_unit(self) -> tuple[int | None, str]:
        """The budget, in one of :data:`quadshade.choices.UNITS`."""
        return (None, "bytes") if self.budget is None else parse_budget(self.budget)

    def arguments(self) -> dict[str, Any]:
        """Arguments of :func:`quadshade.adapt.adapt`."""
        number, unit = self.number_and_unit
        limits = {"max_error": self.max_error, "budget": number, "unit": unit}
        return limits | {"measure": self.measure, "verify": self.is_verified}


@dataclass(frozen=True)
class StyleChoice:
    """Strokes or tones, edges over the picture, and a file of normals and depth."""

    style: str = STYLES[0]
    edges: str | Sequence[str] | None = None
    edge_variant: str = EDGE_VARIANTS[0]
    edge_colours: Sequence[str] | Mapping[str, Sequence[float]] = ()
    gbuffer: str | Path | None = None
    gbuffer_order: str = "quadratic"
    gbuffer_space: str = SPACES[0]

    def __post_init__(self) -> None:
        check_word("style", self.style, STYLES)
        check_word("edge variant", self.edge_variant, EDGE_VARIANTS)
        check_word("G-buffer's order", self.gbuffer_order, tuple(GBUFFER_ORDERS))
        check_word("G-buffer's space", self.gbuffer_space, SPACES)
        _ = self.kinds, self.colours
        if self.gbuffer_path is not None and self.gbuffer_path.suffix.lower() != ".npz":
            raise QuadshadeError(f"the G-buffer is {str(self.gbuffer)!r}", "give a name that ends in .npz")

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """Edges to draw; none if empty."""
        from quadshade.style.edges import parse_kinds

        if self.edges is None:
            return ()
        return parse_kinds(self.edges if isinstance(self.edges, str) else ",".join(self.edges))

    @cached_property
    def colours(self) -> dict[str, Sequence[float]]:
        """Colours of edges, 0 .. 1, where they are not the default ones."""
        texts = self.edge_colours
        if isinstance(texts, Mapping):
            texts = [f"{kind}={','.join(map(str, colour))}" for kind, colour in texts.items()]
        inks: dict[str, Sequence[float]] = {}
        for text in [texts] if isinstance(texts, str) else texts:
            kind, _, value = text.partition("=")
            numbers: tuple[float, ...]
            try:
                numbers = tuple(float(number) for number in value.split(","))
            except ValueError:
                numbers = ()
            in_range = all(0 <= number <= 1 for number in numbers)
            if kind not in EDGE_KINDS or len(numbers) != COLOUR_CHANNELS or not in_range:
                raise QuadshadeError(
                    f"the edge colour is {text!r}",
                    "write profile=r,g,b or inner=r,g,b with numbers from 0 to 1",
                )
            if kind not in self.kinds:
                raise QuadshadeError(
                    f"a colour for {kind} edges, which are not drawn", f"give --edges {kind}"
                )
            inks[kind] = numbers
        return inks

    @property
    def gbuffer_path(self) -> Path | None:
        """The file of normals and depth."""
        return None if self.gbuffer is None else Path(self.gbuffer)

    @property
    def needs_gbuffer(self) -> bool:
        """Whether a second pass draws normals and depth."""
        return bool(self.kinds) or self.gbuffer is not None


@dataclass(frozen=True)
class EngineChoice:
    """What draws, and whether its waveforms are kept."""

    engine: str | None = None
    waves: str | Path | None = None

    @property
    def waves_path(self) -> Path | None:
        """The file of waveforms."""
        return None if self.waves is None else Path(self.waves)


@dataclass(frozen=True)
class PortChoice:
    """A board instead of an engine: a port, as :class:`quadshade.Board` takes it, or an open board."""

    port: Any = None
    baud: int | None = None
    faults: str | float | tuple[float, int] | None = None
    timeout: float | None = None
    trace: Callable[[str], None] | None = None
    pack_error: float | None = None
    verify: bool | str = True
    resume: str | Path | TileStore | None = None
    dask: str | None = None

    def __post_init__(self) -> None:
        if self.port is None:
            for name in ("faults", "timeout", "trace"):
                if getattr(self, name) is not None:
                    raise QuadshadeError(f"--{name.replace('_', '-')} is for a board", "give --port as well")
            if parse_verify(self.verify) == "crc":
                raise QuadshadeError("--verify crc is for a board", "give --port as well")
        if self.dask is not None and (self.trace or self.is_open or len(self.ports) > 1):
            raise QuadshadeError(
                "boards of Dask workers are not open here, and each worker has one of its own",
                "give --dask with one --port, as the workers understand it, and no --trace",
            )
        if self.is_open and (self.baud or self.faults or self.timeout or self.trace):
            raise QuadshadeError(
                "the board is open, with its baud, faults, timeout and trace", "leave them out"
            )
        if self.faults is not None:
            parse_faults(self.faults)
        parse_pack_error(self.added_error)
        parse_verify(self.verify)
        _ = self.ports

    @cached_property
    def ports(self) -> tuple[Any, ...]:
        """Each port by itself: ``sim:4`` is four, and none may be there twice."""
        return parse_ports(self.port)

    @property
    def is_given(self) -> bool:
        """Whether boards draw, or workers, not an engine here."""
        return self.port is not None or self.dask is not None

    @property
    def is_simulated(self) -> bool:
        """Whether a board is one's own simulation, with generics that are chosen here."""
        return "sim" in [one for one in self.ports if isinstance(one, str)]

    @property
    def name(self) -> str:
        """What the port is called in reports."""
        if self.dask is not None:
            return self.dask
        if isinstance(self.port, str):
            return self.port
        if isinstance(self.port, Sequence):
            return ", ".join(PortChoice(one).name for one in self.port)
        session = getattr(self.port, "session", None)
        return str(getattr(self.port if session is None else session.transport, "name", "board"))

    @property
    def is_open(self) -> bool:
        """Whether a board is open already."""
        return any(hasattr(one, "read_plane") for one in self.ports)

    @property
    def added_error(self) -> float:
        """Grey levels that packing may add."""
        return PACK_ERROR if self.pack_error is None else self.pack_error
