# SPDX-License-Identifier: Apache-2.0
"""Generics of a board (``rtl/board.vhd``): those of the core, and what is around it."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

from quadshade.contract.formats import Formats, parse_generics
from quadshade.errors import QuadshadeError
from quadshade.scene.key_values import parse_size

LEAST_CLOCKS = 4
"""Fewest clocks of a bit on the line."""


@dataclass(frozen=True)
class BoardSettings:
    """
    What a board is built with.

    Attributes
    ----------
    formats : Formats
    screen_width, screen_height : int
    clk_frequency_hz, baud : int
      System clock and the line's rate after power-up. A simulated clock is slow on purpose: a byte takes few
      clocks, and so little time.
    fifo_words : int
      Of the command FIFO: a power of two, at most 32768.
    with_edge_map, single_port_memory : int
      0 or 1.

    Raises
    ------
    QuadshadeError
      A value out of range.
    """

    formats: Formats = field(default_factory=Formats)
    screen_width: int = 160
    screen_height: int = 120
    clk_frequency_hz: int = 5_000_000
    baud: int = 1_000_000
    fifo_words: int = 1024
    with_edge_map: int = 0
    single_port_memory: int = 0

    def __post_init__(self) -> None:
        limit = 1 << self.formats.coord_bits
        for name in ("screen_width", "screen_height"):
            if not 1 <= getattr(self, name) <= limit:
                raise QuadshadeError(
                    f"{name} is {getattr(self, name)}", f"give 1 to {limit} (generic coord_bits)"
                )
        if self.fifo_words.bit_count() != 1 or not 64 <= self.fifo_words <= 32768:
            raise QuadshadeError(f"fifo_words is {self.fifo_words}", "give a power of two from 64 to 32768")
        if not 1 <= self.clk_frequency_hz < 1 << 31:
            raise QuadshadeError(f"clk_frequency_hz is {self.clk_frequency_hz}", "give hertz below 2**31")
        if not 1 <= self.baud <= self.clk_frequency_hz // LEAST_CLOCKS:
            raise QuadshadeError(
                f"{self.baud} baud at {self.clk_frequency_hz} Hz",
                f"give at most a quarter of the clock: {self.clk_frequency_hz // LEAST_CLOCKS}",
            )
        for name in ("with_edge_map", "single_port_memory"):
            if getattr(self, name) not in (0, 1):
                raise QuadshadeError(f"{name} is {getattr(self, name)}", "give 0 or 1")

    def generics(self) -> dict[str, int]:
        """Every generic of the entity ``board`` by its VHDL name."""
        own = {name: getattr(self, name) for name in own_names()}
        return self.formats.generics() | own

    def with_generics(self, settings: Mapping[str, int]) -> BoardSettings:
        """
        A copy with some generics replaced, the core's or the board's.

        Raises
        ------
        QuadshadeError
          A name that neither has, or a value out of range.
        """
        own = {name: value for name, value in settings.items() if name in own_names()}
        core = {name: value for name, value in settings.items() if name not in own}
        unknown = sorted(core.keys() - self.formats.generics().keys())
        if unknown:
            known = ", ".join(self.generics())
            raise QuadshadeError(f"a board has no generic {unknown[0]!r}", f"the generics are {known}")
        return replace(self, formats=self.formats.with_generics(core), **own)


def own_names() -> list[str]:
    """Generics that the core does not have."""
    return [one.name for one in fields(BoardSettings) if one.name != "formats"]


def board_settings(
    preset: str | None, screen: str | None, generics: tuple[str, ...], shade: bool = False
) -> BoardSettings:
    """
    Generics of a simulated board from a real one's, a size, and settings.

    Raises
    ------
    QuadshadeError
      An unknown board, a wrong size, or generics that no board has.
    """
    settings = BoardSettings()
    if preset is not None:
        settings = settings.with_generics(_preset(preset))
    if shade:
        settings = settings.with_generics({"with_shade": 1, "num_channels": 2, "num_specular": 1})
    if screen is not None:
        width, height = parse_size(screen)
        settings = settings.with_generics({"screen_width": width, "screen_height": height})
    return settings.with_generics(parse_generics(generics))


def _preset(name: str) -> dict[str, int]:
    """Generics of a real board, but for its clock."""
    from quadshade.engine.sources import repository_root

    folder = repository_root() / "synth" / "boards"
    known = sorted(path.stem for path in folder.glob("*.toml"))
    if name not in known:
        raise QuadshadeError(f"there is no board {name!r}", f"the boards are {', '.join(known)}")
    generics = tomllib.loads((folder / f"{name}.toml").read_text()).get("generics", {})
    return {key: value for key, value in generics.items() if key not in ("clk_frequency_hz", "baud")}
