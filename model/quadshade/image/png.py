# SPDX-License-Identifier: Apache-2.0
"""Reading and writing pictures through Pillow."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from quadshade.errors import QuadshadeError


def write_png(path: Path, picture: np.ndarray) -> None:
    """
    Write an 8-bit RGB picture.

    Parameters
    ----------
    path : Path
    picture : (height, width, 3) uint8
    """
    Image.fromarray(picture).save(path, format="PNG")


def encode_png(picture: np.ndarray) -> bytes:
    """The bytes of a PNG file of an 8-bit RGB picture, (height, width, 3) uint8."""
    encoded = BytesIO()
    Image.fromarray(picture).save(encoded, format="PNG")
    return encoded.getvalue()


def read_picture(path: Path) -> np.ndarray:
    """
    Read a picture as 8-bit RGB; transparency is dropped.

    Parameters
    ----------
    path : Path

    Returns
    -------
    (height, width, 3) uint8

    Raises
    ------
    QuadshadeError
      No such file, not a picture, a damaged one, or one with more than 8 bits a channel.
    """
    try:
        with Image.open(path) as image:
            # Pillow reads a PNG of 16 bits as one of 8; only the file's own layout tells.
            layouts = (str(arguments) for _, _, _, arguments in image.tile)
            if image.mode.startswith(("I", "F")) or any("16" in layout for layout in layouts):
                raise QuadshadeError(f"{path} has more than 8 bits a channel", "convert it to 8 bits")
            return np.asarray(image.convert("RGB"))
    except UnidentifiedImageError:
        raise QuadshadeError(f"{path} is no picture", "give a PNG file") from None
    except OSError as error:
        if error.strerror is None:
            raise QuadshadeError(f"cannot read {path}: {error}", "the file is damaged") from None
        raise QuadshadeError(f"cannot read {path}: {error.strerror}", "give a PNG file") from None
    except (SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise QuadshadeError(f"cannot read {path}: {error}", "the file is damaged") from None
