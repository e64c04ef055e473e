# SPDX-License-Identifier: Apache-2.0
"""The small language of ``--camera``, ``--light`` and ``--material``: ``key=value,key=x,y,z``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from quadshade.errors import QuadshadeError

LARGEST = 1e50
"""Products of a few numbers up to this stay finite; so do the squares of distances."""

WORD = 0
"""Size of a setting that is a word, not numbers."""


def parse_settings(
    text: str, what: str, known: Mapping[str, tuple[int, ...]]
) -> dict[str, tuple[float, ...] | str]:
    """
    Read ``key=value`` pairs; a value's further numbers follow after commas.

    Parameters
    ----------
    text : str
      For example ``eye=0,0,3,fov=40``. ``color`` is read as ``colour``.
    what : str
      What is described, for the error message.
    known : mapping of str to tuple of int
      How many numbers each key takes (any of the tuple); ``(WORD,)`` for a word.

    Returns
    -------
    dict
      A tuple of floats, at most ``LARGEST``, or a str, for each key given.

    Raises
    ------
    QuadshadeError
      An unknown or doubled key, a value that is not finite numbers up to ``LARGEST``, or the wrong count
      of them.
    """
    hint = f"{what} takes {', '.join(known)}"
    groups: dict[str, list[str]] = {}
    key = ""
    for item in text.split(","):
        name, equals, value = item.partition("=")
        if equals:
            key = name.strip().lower().replace("color", "colour")
            if key not in known:
                raise QuadshadeError(f"{what} {text!r} has an unknown key {name.strip()!r}", hint)
            if key in groups:
                raise QuadshadeError(f"{what} {text!r} gives {key} twice", "give it once")
            groups[key] = [value]
        elif key:
            groups[key].append(item)
        else:
            raise QuadshadeError(f"{what} {text!r} is not key=value,key=value", hint)
    return {key: _value(values, f"{key} of {what} {text!r}", known[key]) for key, values in groups.items()}


def numbers_of(settings: dict[str, tuple[float, ...] | str]) -> dict[str, tuple[float, ...]]:
    """The settings that are numbers, not a word."""
    return {key: value for key, value in settings.items() if not isinstance(value, str)}


def _value(values: list[str], where: str, sizes: tuple[int, ...]) -> tuple[float, ...] | str:
    """One setting's numbers or word."""
    if sizes == (WORD,):
        if len(values) != 1 or not values[0].strip():
            raise QuadshadeError(f"{where} is not one word", "give one word")
        return values[0].strip().lower()
    try:
        numbers = tuple(float(value) for value in values)
    except ValueError:
        numbers = (math.nan,)
    if not all(abs(number) <= LARGEST for number in numbers):
        raise QuadshadeError(f"{where} is {','.join(values)!r}", f"give finite numbers, up to {LARGEST:g}")
    if len(numbers) not in sizes:
        wanted = " or ".join(str(size) for size in sizes)
        raise QuadshadeError(f"{where} has {len(numbers)} numbers", f"give {wanted}")
    return numbers


def parse_size(text: str) -> tuple[int, int]:
    """Width and height of ``WxH``."""
    match = re.fullmatch(r"([0-9]{1,6})[xX]([0-9]{1,6})", text.strip())
    if not match:
        raise QuadshadeError(f"the size is {text!r}", "write WIDTHxHEIGHT, e.g. 640x480")
    return int(match[1]), int(match[2])


def parse_background(text: str) -> tuple[int, int, int]:
    """8-bit background of one or three numbers from 0 to 1."""
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 3) or not all(0 <= number <= 1 for number in numbers):
        raise QuadshadeError(f"the background is {text!r}", "give one or three numbers from 0 to 1")
    red, green, blue = (round(255 * number) for number in (numbers * 3 if len(numbers) == 1 else numbers))
    return red, green, blue
