# SPDX-License-Identifier: Apache-2.0
"""Bytes that a picture takes on the line, before it is sent: never fewer than the board's session sends."""

from __future__ import annotations

from typing import Any

import numpy as np

from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import CRC_BYTES, HEADER_BYTES, MAX_PAYLOAD, WORD_BYTES
from quadshade.contract.shade_state import ShadeState, colour_state
from quadshade.contract.triangles import ScreenTriangles
from quadshade.packing.frame_file import state_runs
from quadshade.packing.pack import pack_primitives, packed_writes
from quadshade.setup.triangle_setup import setup_triangles

COBS_RUN = 254
"""COBS adds a byte to each started run of so many bytes, if it has no zero within."""


def frame_bytes(payload: int) -> int:
    """
    The most bytes of a frame with a payload of so many, both 00s included.

    The exact number depends on where the frame has zeros, in its number and CRC too: it is up to four less.
    """
    body = HEADER_BYTES + payload + CRC_BYTES
    return body - (-body // COBS_RUN) + 2


def frames_bytes(words: int, first: int = 0) -> int:
    """The most bytes of frames for so many words; ``first`` bytes stand before the words of each frame."""
    whole, rest = divmod(WORD_BYTES * words, MAX_PAYLOAD - first)
    return whole * frame_bytes(MAX_PAYLOAD) + (frame_bytes(first + rest) if rest else 0)


def picture_line_bytes(
    triangles: ScreenTriangles,
    formats: Formats,
    error: float = PACK_ERROR,
    limit: float | None = MAX_ERROR,
    **setup: Any,
) -> int:
    """
    The most bytes that a picture takes on an undamaged line: CLEAR, the shade unit's state, its triangles.

    Parameters
    ----------
    triangles : ScreenTriangles
    formats : Formats
      Of the board.
    error : float
      As for :func:`quadshade.packing.pack.pack_primitives`.
    limit, **setup
      As for :func:`quadshade.setup.triangle_setup.setup_triangles`.

    Returns
    -------
    int
      Less than a hundredth more than what is sent.

    Raises
    ------
    QuadshadeError
      As those two do.
    """
    primitives = setup_triangles(triangles, formats, limit=limit, **setup)
    words = pack_primitives(primitives, formats, error, triangles.shade).words
    return frame_bytes(WORD_BYTES) + _state_bytes(triangles.shade, words, formats) + frames_bytes(len(words))


def _state_bytes(state: ShadeState | None, words: np.ndarray, formats: Formats) -> int:
    """Of STATE frames, each with its address, if all that packed words need were to be written."""
    if not formats.with_shade:
        return 0
    given = colour_state(formats) if state is None else state
    writes = packed_writes(words, given, formats)
    return sum(frames_bytes(len(words), WORD_BYTES) for _, words in state_runs(writes))
