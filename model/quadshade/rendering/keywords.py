# SPDX-License-Identifier: Apache-2.0
"""What kind of value each keyword of :func:`quadshade.render` takes, for one line about a wrong one."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from typing import Any, NamedTuple

import numpy as np

from quadshade.choices import VERIFIES
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError

SHOWN = 40
"""Characters of a wrong value that an error shows."""


class Kind(NamedTuple):
    """A test of a value, and what it asks for."""

    fits: Callable[[Any], bool]
    text: str


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_path(value: Any) -> bool:
    return isinstance(value, str | os.PathLike)


def _is_switch(value: Any) -> bool:
    return isinstance(value, bool | np.bool_)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not _is_switch(value)


def _is_count(value: Any) -> bool:
    return isinstance(value, Integral) and not _is_switch(value)


def _is_row(value: Any, fits: Callable[[Any], bool], counts: Sequence[int] = ()) -> bool:
    """Whether a value is a sequence, of some counts if there are any, whose elements fit; no text."""
    if isinstance(value, str | bytes) or not isinstance(value, Sequence | np.ndarray):
        return False
    return np.ndim(value) > 0 and (not counts or len(value) in counts) and all(map(fits, value))


def _is_size(value: Any) -> bool:
    return _is_text(value) or _is_row(value, _is_count, (2,))


def _is_camera(value: Any) -> bool:
    from quadshade.scene import Camera

    return isinstance(value, str | Camera)


def _is_light(value: Any) -> bool:
    from quadshade.shading import AmbientLight, DirectionalLight, PointLight

    return isinstance(value, str | AmbientLight | DirectionalLight | PointLight)


def _is_material(value: Any) -> bool:
    from quadshade.shading import Material

    return isinstance(value, str | Material)


def _is_background(value: Any) -> bool:
    return _is_text(value) or _is_number(value) or _is_row(value, _is_number, (1, 3))


def _are_generics(value: Any) -> bool:
    return isinstance(value, Mapping | Formats) or _is_row(value, _is_text)


def _is_budget(value: Any) -> bool:
    is_pair = isinstance(value, tuple) and len(value) == 2
    return _is_text(value) or _is_count(value) or (is_pair and _is_count(value[0]) and _is_text(value[1]))


def _is_rate(value: Any) -> bool:
    is_pair = isinstance(value, tuple) and len(value) == 2
    return _is_text(value) or _is_number(value) or (is_pair and _is_number(value[0]) and _is_count(value[1]))


def _are_colours(value: Any) -> bool:
    if isinstance(value, Mapping):
        return all(_is_text(kind) and _is_row(colour, _is_number) for kind, colour in value.items())
    return _is_text(value) or _is_row(value, _is_text)


def _is_port(value: Any) -> bool:
    return (
        _is_text(value)
        or hasattr(value, "read_plane")
        or (hasattr(value, "read") and hasattr(value, "write"))
        or (isinstance(value, list | tuple) and bool(value) and all(map(_is_port, value)))
    )


WORD = Kind(lambda value: _is_text(value) and bool(value), "a word")
NUMBER = Kind(_is_number, "a number")
COUNT = Kind(_is_count, "a whole number")
SWITCH = Kind(_is_switch, "True or False")
FILE = Kind(_is_path, "the path of a file")
CALLABLE = Kind(callable, "a function")
KINDS = (
    dict.fromkeys(
        ("exponent", "smoothness", "jump", "crease", "max_error", "frame_time", "fps", "clock", "timeout"),
        NUMBER,
    )
    | dict.fromkeys(("toon", "supersample", "baud"), COUNT)
    | dict.fromkeys(("cull",), SWITCH)
    | dict.fromkeys(("gbuffer", "waves", "resume"), FILE)
    | {
        "engine": WORD,
        "dask": WORD,
        "trace": CALLABLE,
        "size": Kind(_is_size, "a text as 640x480, or two whole numbers"),
        "camera": Kind(_is_camera, "a text as of --camera, or a Camera"),
        "lights": Kind(
            lambda value: _is_light(value) or _is_row(value, _is_light), "texts as of --light, or lights"
        ),
        "material": Kind(_is_material, "a text as of --material, or a Material"),
        "reflectance": Kind(
            lambda value: _is_text(value) or callable(value), "module:function, or a function"
        ),
        "background": Kind(_is_background, "one or three numbers from 0 to 1"),
        "generics": Kind(_are_generics, "a mapping, a list of name=value, or Formats"),
        "lod": Kind(lambda value: _is_text(value) or _is_count(value), "a number of triangles, or auto"),
        "budget": Kind(_is_budget, "a text as 20000bytes, a whole number, or both as a pair"),
        "edges": Kind(lambda value: _is_text(value) or _is_row(value, _is_text), "profile, inner, or both"),
        "edge_colours": Kind(_are_colours, "a mapping of a kind to three numbers, or texts"),
        "verify": Kind(
            lambda value: _is_switch(value) or _is_text(value),
            f"True, False, or one of {', '.join(VERIFIES)}",
        ),
        "faults": Kind(_is_rate, "a rate, or a rate and a seed"),
        "port": Kind(_is_port, "a port's name or URL, an open serial object, a Board, or several"),
    }
)
"""Kinds by keyword; words and grey levels that are not here are checked where they are read."""


def check_kind(name: str, value: Any, default: Any) -> None:
    """
    Refuse a value of another kind than a keyword takes; None is one where it is the default.

    Raises
    ------
    QuadshadeError
    """
    kind = KINDS.get(name)
    if kind is None or (value is None and default is None) or kind.fits(value):
        return
    shown = " ".join(repr(value).split())
    shown = shown if len(shown) <= SHOWN else f"{shown[:SHOWN]}..."
    raise QuadshadeError(f"{name} is {shown}, of type {type(value).__name__}", f"give {kind.text}")
