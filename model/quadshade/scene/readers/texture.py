# SPDX-License-Identifier: Apache-2.0
"""Textures: the colour of a picture at texture coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO

import numpy as np

from quadshade.errors import QuadshadeError

REPEAT, MIRROR, CLAMP = "repeat", "mirror", "clamp"

INWARD = 2.0**-20
"""A corner's colour is taken this share of the way to the middle of its face: at the seam between two texels,
the texel is the face's own."""


@dataclass(frozen=True)
class Texture:
    """
    A picture with the way it is read.

    Attributes
    ----------
    texels : (height, width, 4) float64
      0 .. 1, red, green, blue, alpha; the first row is the upper one.
    wrap : (str, str)
      ``repeat``, ``mirror`` or ``clamp``, across and down.
    linear : bool
      Between four texels' centres; else the texel that is hit.
    """

    texels: np.ndarray
    wrap: tuple[str, str] = (REPEAT, REPEAT)
    linear: bool = False

    def at_corners(self, places: np.ndarray) -> np.ndarray:
        """
        The colours at faces' corners.

        Parameters
        ----------
        places : (n, 3, 2) float
          Across, and down from the upper edge; 1 is the picture's whole width or height.

        Returns
        -------
        (n, 3, 4) float64
        """
        if not np.isfinite(places).all() or (places.size and np.abs(places).max() > 1e9):
            raise QuadshadeError(
                "a texture coordinate is missing, not finite or beyond 1e9", "repair the mesh"
            )
        middle = places.mean(axis=1, keepdims=True)
        height, width = self.texels.shape[:2]
        texel = (places + (middle - places) * INWARD) * (width, height)
        if not self.linear:
            return self._fetch(np.floor(texel).astype(np.int64))
        low = np.floor(texel - 0.5)
        share = (texel - 0.5 - low)[..., None]
        out = np.zeros((*places.shape[:2], 4))
        for across in (0, 1):
            for down in (0, 1):
                weight = np.where(across, share[..., 0, :], 1 - share[..., 0, :])
                weight = weight * np.where(down, share[..., 1, :], 1 - share[..., 1, :])
                out += weight * self._fetch((low + (across, down)).astype(np.int64))
        return out

    def _fetch(self, texel: np.ndarray) -> np.ndarray:
        """Texels at (..., 2) whole coordinates, wrapped."""
        height, width = self.texels.shape[:2]
        column = _wrapped(texel[..., 0], width, self.wrap[0])
        return self.texels[_wrapped(texel[..., 1], height, self.wrap[1]), column]


def _wrapped(index: np.ndarray, size: int, how: str) -> np.ndarray:
    """Indices inside 0 .. size - 1."""
    if how == CLAMP:
        return np.clip(index, 0, size - 1)
    if how == MIRROR:
        folded = index % (2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded)
    return index % size


def read_texels(data: bytes, name: str) -> np.ndarray:
    """
    A picture's texels.

    Parameters
    ----------
    data : bytes
      A PNG, JPEG or another file that Pillow reads.
    name : str
      For messages.

    Returns
    -------
    (height, width, 4) float64

    Raises
    ------
    QuadshadeError
      No such picture.
    """
    import warnings

    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(BytesIO(data)) as picture:
                if picture.mode.startswith(("I", "F")):
                    raise QuadshadeError(
                        f"the texture {name} has the depth {picture.mode}", "save it with 8 bits a channel"
                    )
                return np.asarray(picture.convert("RGBA"), dtype=np.float64) / 255.0
    except QuadshadeError:
        raise
    except Exception as error:  # noqa: BLE001 - Pillow raises whatever its decoders stumble over
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise QuadshadeError(f"cannot read the texture {name}: {reason}", "save it as PNG") from None
