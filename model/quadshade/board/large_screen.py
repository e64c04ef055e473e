# SPDX-License-Identifier: Apache-2.0
"""What a picture costs that is larger than the screen of any board."""

from __future__ import annotations

import tomllib

from quadshade.board.settings import BoardSettings
from quadshade.engine.sources import repository_root

LINE_BITS = 10
"""Of a byte on the line: start bit, eight bits, stop bit."""

CLOCKS_A_SECOND = {"verilator": 1_000_000, "ghdl": 20_000}
"""Of a simulated board on one machine, rounded: Verilator's is that of ``docs/reports/boardspeed.md``."""


def largest_screen() -> tuple[str, int, int]:
    """Name, width and height of the board in ``synth/boards`` that has the largest screen."""
    sizes = []
    for path in sorted((repository_root() / "synth" / "boards").glob("*.toml")):
        generics = tomllib.loads(path.read_text()).get("generics", {})
        if "screen_width" in generics:
            sizes.append((path.stem, int(generics["screen_width"]), int(generics["screen_height"])))
    return max(sizes, key=lambda size: size[1] * size[2])


def large_screen_notice(settings: BoardSettings, engine: str) -> str:
    """
    Say that a simulated board's screen is one that no board has, before anything is compiled or drawn.

    Parameters
    ----------
    settings : BoardSettings
    engine : str
      What simulates the board: ``verilator``, ``ghdl`` or ``model``.

    Returns
    -------
    str
      A line with the largest screen that there is, an estimate of what reading the picture takes, and what to
      do; empty where a board has such a screen.
    """
    name, width, height = largest_screen()
    pixels = settings.screen_width * settings.screen_height
    if pixels <= width * height:
        return ""
    line_bits = pixels * settings.formats.emitted_channels * LINE_BITS
    text = (
        f"no board has {settings.screen_width}x{settings.screen_height} pixels, the largest screen is"
        f" {width}x{height} ({name}); reading the picture takes {_duration(line_bits / settings.baud)}"
        f" of a line at {settings.baud} baud"
    )
    if engine in CLOCKS_A_SECOND:
        clocks = line_bits * settings.clk_frequency_hz / settings.baud
        text += f", and about {_duration(clocks / CLOCKS_A_SECOND[engine])} of simulation"
    return f"{text}; give --screen {width}x{height}: larger pictures are drawn on it in tiles"


def _duration(seconds: float) -> str:
    """Seconds, or minutes where they are many."""
    if seconds < 100:
        return f"{max(round(seconds), 1)} s"
    return f"{round(seconds / 60)} minutes"
