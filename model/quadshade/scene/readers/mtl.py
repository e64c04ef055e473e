# SPDX-License-Identifier: Apache-2.0
"""Material libraries of OBJ files: the diffuse colour, as a number and as a texture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.part import text_lines
from quadshade.scene.readers.texture import CLAMP, REPEAT, Texture, read_texels

HARMLESS = {"-blendu": 1, "-blendv": 1, "-bm": 1, "-boost": 1, "-texres": 1}
"""Options of a texture that do not change the colours read here, and how many words follow each."""


@dataclass(frozen=True)
class Material:
    """
    What of a material is drawn.

    Attributes
    ----------
    colour : (3,) float64 or None
      Kd; None: not given.
    texture : Texture or None
      map_Kd; multiplied by Kd.
    scale, offset : (2,) float64
      Of the texture coordinates (``-s``, ``-o``).
    transparent : bool
      Less than opaque, which a picture does not show.
    """

    colour: np.ndarray | None = None
    texture: Texture | None = None
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    transparent: bool = False


def read_mtl(text: str, name: str, fetch: Callable[[str], bytes]) -> dict[str, Material]:
    """
    The materials of a library, by name.

    Parameters
    ----------
    text : str
    name : str
      The library's, for messages.
    fetch : callable
      The content of a file beside the library.

    Returns
    -------
    dict

    Raises
    ------
    QuadshadeError
      A colour that is malformed, or given as a spectrum or in XYZ; a texture that is missing or has options
      that change its colours.
    """
    materials: dict[str, Material] = {}
    current: str | None = None
    for number, line in enumerate(text_lines(text), 1):
        words = line.split(" #")[0].split()
        if not words or words[0].startswith("#"):
            continue
        key, where = words[0].lower(), f"{name}, line {number}"
        if key == "newmtl":
            current = " ".join(words[1:])
            materials[current] = Material()
        elif current is None:
            continue
        elif key == "kd":
            materials[current] = replace(materials[current], colour=_colour(words[1:], where))
        elif key == "map_kd":
            materials[current] = _with_texture(materials[current], words[1:], where, fetch)
        elif key in ("d", "tr") and len(words) > 1:
            opacity = _numbers(words[-1:], where)[0]
            opaque = opacity >= 1 if key == "d" else opacity <= 0
            materials[current] = replace(materials[current], transparent=not opaque)
        elif key == "map_d":
            materials[current] = replace(materials[current], transparent=True)
    return materials


def _colour(words: list[str], where: str) -> np.ndarray:
    """(3,) colour of one or three numbers."""
    if words[:1] in (["spectral"], ["xyz"]):
        raise QuadshadeError(
            f"{where} gives a colour as {words[0]}, which is not read", "write Kd red green blue"
        )
    numbers = _numbers(words, where)
    if len(numbers) not in (1, 3) or not all(0 <= value <= 1 for value in numbers):
        raise QuadshadeError(
            f"{where} has the colour {' '.join(words)[:60]}", "give three numbers from 0 to 1"
        )
    return np.array(numbers * (3 // len(numbers)))


def _with_texture(
    material: Material, words: list[str], where: str, fetch: Callable[[str], bytes]
) -> Material:
    """The material with the texture of a map_Kd statement."""
    wrap, index = REPEAT, 0
    while index < len(words) - 1 and words[index].startswith("-"):
        option, index = words[index].lower(), index + 1
        if option == "-clamp":
            wrap = CLAMP if words[index].lower() == "on" else REPEAT
            index += 1
        elif option in ("-s", "-o"):
            numbers: list[float] = []
            while len(numbers) < 3 and index < len(words) - 1 and _is_number(words[index]):
                numbers.append(float(words[index]))
                index += 1
            default = 1.0 if option == "-s" else 0.0
            across, down = [*numbers, default, default][:2]
            change = {"scale" if option == "-s" else "offset": (across, down)}
            material = replace(material, **change)  # type: ignore[arg-type]
        elif option in HARMLESS:
            index += HARMLESS[option]
        else:
            raise QuadshadeError(
                f"{where} has a texture with {option}, which is not read", "apply it to the texture"
            )
    file = " ".join(words[index:])
    texels = read_texels(fetch(file), file)
    return replace(material, texture=Texture(texels, (wrap, wrap)))


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _numbers(words: list[str], where: str) -> list[float]:
    """The numbers of a line."""
    if not words or not all(_is_number(word) for word in words):
        raise QuadshadeError(f"{where} has {' '.join(words)[:40]!r} where numbers should be", "repair it")
    return [float(word) for word in words]
