# SPDX-License-Identifier: Apache-2.0
"""Triangles to pixels: set-up on the host, then one of the engines."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from quadshade.choices import ENGINES, MAX_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import Drawing, Pixels, ScreenTriangles
from quadshade.engine.ghdl import draw_ghdl
from quadshade.engine.tool_runner import INSTALL_OR_MODEL, is_replaced, missing_tool
from quadshade.engine.verilator import PROGRAMS, draw_verilator, verilator_available
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import EmittedPixels
from quadshade.golden.shade import render_core
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles


def default_engine() -> str:
    """
    ``verilator`` where its tools, a C++ compiler among them, and the RTL are at hand, else ``model``.

    Raises
    ------
    QuadshadeError
      An environment variable names a tool that is not there: whoever set it does not want another engine.
    """
    if problem := missing_tool([variable for variable in PROGRAMS if is_replaced(variable)]):
        raise QuadshadeError(problem, f"{INSTALL_OR_MODEL}, or unset the variable")
    return "verilator" if verilator_available() else "model"


def draw_words(
    words: np.ndarray,
    formats: Formats,
    engine: str = "model",
    waves: Path | None = None,
    state: ShadeState | None = None,
) -> EmittedPixels:
    """
    Draw a stream of set-up words.

    Parameters
    ----------
    words : (m,) uint32
      32-bit set-up words, whole packets.
    formats : Formats
    engine : str
      One of ``ENGINES``.
    waves : Path, optional
      GHW file to write; needs an engine that simulates VHDL.
    state : ShadeState, optional
      Of the shade unit, for formats that have it; if left out, the first three channels are the colour.

    Returns
    -------
    EmittedPixels

    Raises
    ------
    QuadshadeError
      Unknown engine, a stream that ends within a packet, a missing simulator, waves without one.
    """
    if engine not in ENGINES:
        raise QuadshadeError(f"there is no engine {engine!r}", f"the engines are {', '.join(ENGINES)}")
    if engine == "ghdl" and (waves is not None or len(words)):
        return draw_ghdl(words, formats, waves, state=state)
    if waves is not None:
        raise QuadshadeError(f"the engine {engine} has no waves", "use --engine ghdl")
    # Without words nothing is drawn, and nothing need be compiled for it.
    if engine == "verilator" and len(words):
        return draw_verilator(words, formats, state=state)
    return render_core.draw(words, formats, state)


def draw(
    triangles: ScreenTriangles,
    formats: Formats,
    engine: str = "model",
    waves: Path | None = None,
    fractional: bool = False,
    rounding: str = "joint",
    method: str = "unit",
    limit: float | None = MAX_ERROR,
    strict: bool = False,
) -> Drawing:
    """
    Set triangles up and draw them.

    Parameters
    ----------
    triangles : ScreenTriangles
    formats : Formats
    engine : str
      One of ``ENGINES``.
    waves : Path, optional
      GHW file to write; needs an engine that simulates VHDL.
    fractional : bool
      Step colour at the fractional edge, as in the loop of Abbas et al., section 5, not at pixel centres.
    rounding, method, limit, strict
      As for :func:`quadshade.setup.triangle_setup.setup_triangles`; the limit is half a grey level.

    Returns
    -------
    Drawing

    Raises
    ------
    QuadshadeError
      A triangle out of range, or what :func:`draw_words` raises.
    """
    primitives = setup_triangles(triangles, formats, fractional, rounding, method, limit, strict)
    words = pack(primitives, formats)
    emitted = draw_words(words, formats, engine, waves, triangles.shade)
    triangle = primitives.triangle[emitted.packet].astype(np.int32)
    colours = formats.emitted_channels
    stats = {
        "engine": engine,
        "clocks": emitted.clocks,
        "pixels": len(triangle),
        "triangles": len(triangles),
        "triangles_drawn": len(np.unique(primitives.triangle)),
        "packets": len(primitives),
        "words": len(words),
        "clocks_per_pixel": emitted.clocks / len(triangle) if len(triangle) else 0.0,
        "bound": float(primitives.bound[:, :colours].max(initial=0.0)),
        "triangles_undefined": len(np.unique(primitives.triangle[primitives.undefined])),
        "generics": formats.generics(),
    }
    depth = emitted.value[:, colours] if formats.with_depth and triangles.depth is not None else None
    return Drawing(Pixels(triangle, emitted.x, emitted.y, emitted.value[:, :colours], depth), stats)
