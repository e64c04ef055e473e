# SPDX-License-Identifier: Apache-2.0
"""The words and small texts that options and keywords take; it imports nothing heavy, for the help's sake."""

from __future__ import annotations

import math
import os
import re
from typing import Any

from quadshade.contract.formats import CONSTANT, LINEAR, QUADRATIC
from quadshade.errors import QuadshadeError

ENGINES = ("model", "ghdl", "verilator")
"""What draws: the golden model, the VHDL in GHDL, its netlist in Verilator."""

BOARD_ENGINES = ("verilator", "ghdl", "model")
"""What simulates a board; the first one where its tools are installed."""

SHADING_ORDERS = {"flat": CONSTANT, "gouraud": LINEAR, "quadratic": QUADRATIC}
SPECULAR_ORDERS = {"linear-specular": LINEAR, "quadratic-specular": QUADRATIC}
PHONG = "phong"
BOARD_SHADINGS = (*SHADING_ORDERS, *SPECULAR_ORDERS)
"""Shadings that hardware draws; Phong shading is computed in float on the host."""

SHADINGS = (*BOARD_SHADINGS, PHONG)
DEFAULT_SHADING = "quadratic"
DEFAULT_SIZE = "512x512"
ADAPTIVE_SHADINGS = ("quadratic", "quadratic-specular")

FITS = ("six-point", "least-squares", "minimax", "smooth", "c1")
"""
``six-point``      the quadratic through six samples: the default
``least-squares``  the least squared error over the picture, neighbours meeting in value
``minimax``        a small largest error
``smooth``         least squares of the error and of the derivative's jumps across edges
``c1``             least squares without jumps: triangles are split where one could be seen
"""

ADAPTIVE_FITS = ("six-point", "minimax", "auto")
"""
Of pictures for an allowed error or a budget: ``minimax`` also fits those for stricter limits anew, ``auto``
only the one that is found, and takes what is cheaper.
"""

ALL_FITS = (*FITS, "auto")
"""What ``--fit`` takes."""

SPECULAR_FITS = FITS[:3]
"""Fits of cosines, for the power at the pixel."""

SMOOTHNESS = 30.0
"""Default weight of the jumps, ``smooth``, in pixels."""

JUMP = 0.02
"""Default jump of the derivative that may stay, ``c1``, in grey levels per pixel."""

SUPERSAMPLES = (1, 2, 4)
"""Frames along each side of a pixel that a picture may be the mean of."""

SETUPS = ("unit", "abbas", "general", "xshading", "taylor")
"""
``unit``      the unit triangle, set up on the pixel lattice with a bound of its own error: the default
``abbas``     the printed formulas, the bottom vertex at the origin (Abbas et al., section 3)
``general``   six equations in six unknowns (Barrera et al., equations 8-11)
``xshading``  the unit triangle, mid-edge samples with the normals of Barrera et al., equation 27
``taylor``    the unit triangle, Taylor's quadratic at its middle (Bishop and Weimer)
"""

OWN_SAMPLES = ("xshading", "taylor")
"""Methods that take samples of their own, which needs normals."""

SAMPLED_SETUPS = tuple(method for method in SETUPS if method not in OWN_SAMPLES)
"""Methods for samples that are given."""

ROUNDINGS = ("joint", "independent")
STEPPINGS = ("centre", "fractional")

MAX_ERROR = 0.5
"""Grey levels that the bound may be where a drawing is not told otherwise."""

PACK_ERROR = 1.0 / 32.0
"""Grey levels that shorter words may add to the error at a pixel, unless a drawing is told otherwise."""

AUTO = "auto"
"""A level of detail that the budget chooses."""

VERIFIES = ("picture", "crc", "none")
"""
``picture``  a board's picture is fetched and compared with the golden model's: the default
``crc``      the board says four bytes, and the golden model's picture is shown if they are its CRC
``none``     the board's picture is fetched and believed
"""

MEASURES = ("max", "rms")
UNITS = ("bytes", "clocks", "line")
"""Of a budget: bytes of set-up words, clocks of the core, bytes on the serial line."""
COSTS = ("bytes", "clocks", "lut4", "line")
"""What a sweep's points pay for their error."""

SIM = "sim"
"""A port at which a simulated board is started."""

MOST_SIMULATED = 64
"""Simulated boards at a time."""

STYLES = ("none", "cartoon", "gooch", "hatch")
EDGE_KINDS = ("profile", "inner")
EDGE_VARIANTS = ("diagonal", "eight")
GBUFFER_ORDERS = {"linear": LINEAR, "quadratic": QUADRATIC}
SPACES = ("camera", "world")

_BUDGET = re.compile(r"([0-9]{1,15})(bytes|clocks|line)?")


def check_word(what: str, value: object, words: tuple[str, ...]) -> None:
    """Refuse a word that is not one of some; raises :class:`QuadshadeError`."""
    if not isinstance(value, str) or value not in words:
        raise QuadshadeError(f"the {what} is {value!r}", f"give one of {', '.join(words)}")


def parse_verify(value: Any) -> str:
    """One of :data:`VERIFIES`: True is the first, False the last; raises :class:`QuadshadeError`."""
    if isinstance(value, str):
        check_word("verification", value, VERIFIES)
        return value
    return VERIFIES[0] if value else VERIFIES[-1]


def parse_budget(value: Any) -> tuple[int, str]:
    """
    Number and unit of a budget.

    Parameters
    ----------
    value : str, int or tuple of (int, str)
      For example ``20000bytes``, ``180000clocks``, ``10000line``, or a number of bytes.

    Raises
    ------
    QuadshadeError
      Anything else.
    """
    text = "".join(map(str, value)) if isinstance(value, tuple) else str(value)
    match = _BUDGET.fullmatch(text.strip().lower())
    if not match:
        raise QuadshadeError(
            f"{value!r} is not a budget", "write for example 20000bytes, 180000clocks or 10000line"
        )
    return int(match[1]), match[2] or UNITS[0]


def parse_lod(value: Any) -> int | str | None:
    """Triangles, ``auto`` or None; raises :class:`QuadshadeError` for anything else."""
    text = str(value).strip().lower()
    if value is None or text == AUTO:
        return None if value is None else AUTO
    if isinstance(value, bool) or not re.fullmatch("[0-9]{1,9}", text):
        raise QuadshadeError(f"the level of detail is {value!r}", "give a number of triangles, or auto")
    return int(text)


def parse_frame_time(value: Any) -> float:
    """Milliseconds, from 0.01 to 1000000; raises :class:`QuadshadeError` for anything else."""
    milliseconds = _number(value)
    if not 0.01 <= milliseconds <= 1e6:
        raise QuadshadeError(f"the frame time is {value!r}", "give milliseconds from 0.01 to 1000000")
    return milliseconds


def parse_clock(value: Any) -> float:
    """Megahertz, from 0.1 to 1000; raises :class:`QuadshadeError` for anything else."""
    megahertz = _number(value)
    if not 0.1 <= megahertz <= 1000:
        raise QuadshadeError(f"the clock is {value!r}", "give megahertz from 0.1 to 1000")
    return megahertz


def parse_turn_time(value: Any) -> float | str:
    """Milliseconds or ``auto``; raises :class:`QuadshadeError` for anything else."""
    return AUTO if str(value).strip().lower() == AUTO else parse_frame_time(value)


def parse_fps(value: Any) -> float:
    """Frames a second, from 0.01 to 1000; raises :class:`QuadshadeError` for anything else."""
    fps = _number(value)
    if not 0.01 <= fps <= 1000:
        raise QuadshadeError(f"the fps are {value}", "give 0.01 to 1000 frames a second")
    return fps


def parse_limit(value: Any) -> float:
    """Grey levels above 0; raises :class:`QuadshadeError` for anything else."""
    levels = _number(value)
    if not 0 < levels < math.inf:
        raise QuadshadeError(f"{value!r} is not a number of grey levels above 0", "write for example =0.5")
    return levels


def parse_pack_error(value: Any) -> float:
    """Grey levels from 0; raises :class:`QuadshadeError` for anything else."""
    levels = _number(value)
    if not 0 <= levels < math.inf:
        raise QuadshadeError(f"{value!r} is not a number of grey levels from 0", "write for example 0.0625")
    return levels


def simulated_board(port: Any) -> str | None:
    """The board of ``synth/boards`` that ``sim:BOARD`` names, empty of ``sim``; None of another port."""
    name, _, board = port.partition(":") if isinstance(port, str) else ("", "", "")
    return board if name == SIM else None


def parse_ports(value: Any) -> tuple[Any, ...]:
    """
    Each of the ports that are given.

    Parameters
    ----------
    value : str, serial object, Board, sequence of them, or None
      ``sim:4`` stands for four simulated boards; ``sim:BOARD``, with a name, is one and stays as it is.

    Raises
    ------
    QuadshadeError
      A port that is there twice, or no number of simulated boards from 1 to ``MOST_SIMULATED``.
    """
    given = value if isinstance(value, list | tuple) else () if value is None else (value,)
    ports: list[Any] = []
    for one in given:
        count = simulated_board(one)
        if count is None or one == SIM or re.match("[a-z]", count):
            ports.append(one)
            continue
        if not re.fullmatch("[0-9]{1,4}", count) or not 1 <= int(count) <= MOST_SIMULATED:
            hint = f"write sim, sim:1 to sim:{MOST_SIMULATED}, or sim:BOARD, e.g. sim:icebreaker"
            raise QuadshadeError(f"the port is {one!r}", hint)
        ports += [SIM] * int(count)
    seen: dict[Any, Any] = {}
    for port in ports:
        if simulated_board(port) is None:
            # Two names may be links to one device.
            place = os.path.realpath(port) if isinstance(port, str) and os.path.exists(port) else port
            if place in seen.values():
                raise QuadshadeError(f"the port {port} is given twice", "give it once")
            seen[port] = place
    return tuple(ports)


def parse_faults(value: Any) -> tuple[float, int]:
    """
    Faults a byte and their seed.

    Parameters
    ----------
    value : str, float or tuple of (float, int)
      For example ``1e-3,7``; without a seed it is 1.

    Raises
    ------
    QuadshadeError
      No rate from 0 to 1, or no whole seed.
    """
    text = ",".join(map(str, value)) if isinstance(value, tuple) else str(value)
    rate, _, seed = text.partition(",")
    try:
        numbers = float(rate), int(seed or 1)
    except ValueError:
        numbers = (-1.0, 1)
    if not 0 <= numbers[0] <= 1:
        raise QuadshadeError(f"{value!r} is no rate of faults", "write for example 1e-3 or 1e-3,7")
    return numbers


def _number(value: Any) -> float:
    """A float, or nan for what is none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan
