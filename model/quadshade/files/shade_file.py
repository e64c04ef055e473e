# SPDX-License-Identifier: Apache-2.0
"""The object ``shade`` of a triangles file: what the shade unit makes of the channels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from quadshade.contract.formats import COEFFICIENT_FRAC_BITS, POWER_BITS, SHADED_COLOURS, Formats
from quadshade.contract.shade_state import (
    COEFFICIENT_LIMIT,
    Curve,
    ShadeState,
    power_curve,
    shade_state,
    table_entries,
    table_places,
)
from quadshade.errors import QuadshadeError

EXPONENTS = (1, 1024)
_BELOW_LIMIT = math.nextafter(COEFFICIENT_LIMIT, 0)
_KEYS = ("specular", "ambient", "colour", "light", "exponent", "table", "tables", "gated")


class _Fault(Exception):
    """What is wrong; the caller adds the file."""


@dataclass(frozen=True)
class ShadeFile:
    """
    What a file says about its channels.

    Attributes
    ----------
    specular : int
      How many channels, the last ones, are specular.
    ambient : list of 3 floats
    colours : list of lists of 3 floats
      Of the diffuse channels, then of the specular ones.
    curves : list of callables
      One for each specular channel.
    gated : bool
    """

    specular: int
    ambient: list[float]
    colours: list[list[float]]
    curves: list[Curve]
    gated: bool

    def state(self, formats: Formats) -> ShadeState:
        """The shade unit's registers and tables."""
        return shade_state(
            formats, self.ambient, self.colours, self.curves, ((1 << self.specular) - 1) * self.gated
        )


def read_shade(content: object, channels: list[str], path: object) -> ShadeFile:
    """
    Check the object ``shade`` of a triangles file.

    Parameters
    ----------
    content : JSON value
    channels : list of str
      The file's channels.
    path : Path
      Of the file, for errors.

    Returns
    -------
    ShadeFile

    Raises
    ------
    QuadshadeError
      Anything that is missing, unknown or out of range.
    """
    try:
        return _read(content, channels)
    except _Fault as fault:
        raise QuadshadeError(f"{path}: shade: {fault}", "see docs/reference/triangles_file.md") from None


def _read(content: object, channels: list[str]) -> ShadeFile:
    if not isinstance(content, dict):
        raise _Fault("is not an object")
    for key in content:
        if key not in _KEYS:
            raise _Fault(f"unknown key {key!r}, the keys are {', '.join(_KEYS)}")
    specular = _specular(content.get("specular"), channels)
    gated = content.get("gated", True)
    if not isinstance(gated, bool):
        raise _Fault("gated is not true or false")
    return ShadeFile(
        specular,
        _numbers(content.get("ambient", [0, 0, 0]), SHADED_COLOURS, 0, 1, "ambient"),
        _colours(content, "colour", len(channels) - specular) + _colours(content, "light", specular),
        _curves(content, specular),
        gated,
    )


def _specular(given: object, channels: list[str]) -> int:
    """How many channels are specular: given as a number, or as the names of the last channels."""
    if isinstance(given, list):
        if not given or given != channels[-len(given) :]:
            raise _Fault(f"specular is not the last of the channels {', '.join(channels)}")
        return len(given)
    if isinstance(given, bool) or not isinstance(given, int) or not 1 <= given <= len(channels):
        raise _Fault(f"specular is not the last channels' names or their number, 1 to {len(channels)}")
    return given


def _colours(content: dict[str, Any], key: str, count: int) -> list[list[float]]:
    rows = content.get(key, [] if count == 0 else None)
    if not isinstance(rows, list) or len(rows) != count:
        raise _Fault(f"{key} is not a list of {count} colours")
    return [_numbers(row, SHADED_COLOURS, 0, _BELOW_LIMIT, f"{key} {i}") for i, row in enumerate(rows)]


def _curves(content: dict[str, Any], count: int) -> list[Curve]:
    """A curve for each specular channel."""
    given = [key for key in ("exponent", "table", "tables") if key in content]
    if len(given) != 1:
        raise _Fault(f"has {' and '.join(given) or 'no exponent'}; give one of exponent, table, tables")
    if given[0] == "table":
        return [_sampled(content["table"], "table")] * count
    if given[0] == "tables":
        tables = content["tables"]
        if not isinstance(tables, list) or len(tables) != count:
            raise _Fault(f"tables is not a list of {count} tables")
        return [_sampled(table, f"table {index}") for index, table in enumerate(tables)]
    exponents = content["exponent"]
    exponents = exponents if isinstance(exponents, list) else [exponents] * count
    return [power_curve(n) for n in _numbers(exponents, count, *EXPONENTS, "exponent")]


def _sampled(table: object, what: str) -> Curve:
    """The curve through values at equally spaced cosines, or through pairs of cosine and value."""
    if not isinstance(table, list) or len(table) < 2:
        raise _Fault(f"{what} is not a list of at least two values")
    if not isinstance(table[0], list):
        values = _numbers(table, len(table), 0, 1, what)
        places = np.linspace(0.0, 1.0, len(values))
    else:
        pairs = np.array([_numbers(pair, 2, 0, 1, what) for pair in table])
        places, values = pairs.T
        if (np.diff(places) < 0).any():
            raise _Fault(f"{what} has cosines that fall")
    return lambda cosine: np.interp(cosine, places, values)


def _numbers(given: object, count: int, low: float, high: float, what: str) -> list[float]:
    if not isinstance(given, list) or len(given) != count:
        raise _Fault(f"{what} is not {count} numbers")
    for value in given:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not low <= value <= high:
            raise _Fault(f"{what} has {str(value)[:40]}, not a number from {low:g} to {high:g}")
    return [float(value) for value in given]


def shade_content(state: ShadeState, formats: Formats) -> dict[str, Any]:
    """The object ``shade`` of a state; :func:`read_shade` gives the same state back."""
    top, scale = (1 << formats.value_bits) - 1, 1 << COEFFICIENT_FRAC_BITS
    diffuse = formats.num_channels - formats.num_specular
    colours = (state.coefficients / scale).tolist()
    full = top << (POWER_BITS - formats.value_bits)
    places = table_places(formats)[: table_entries(formats)]
    tables = [
        [[x, y] for x, y in zip(places.tolist(), ((words & 0xFFFF) / full).tolist(), strict=True)][::-1]
        for words in state.tables
    ]
    return {
        "specular": formats.num_specular,
        "ambient": ((state.ambient / scale - 0.5) / top).tolist(),
        "colour": colours[:diffuse],
        "light": colours[diffuse:],
        "tables": tables,
        "gated": state.gated != 0,
    }
