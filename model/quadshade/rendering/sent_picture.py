# SPDX-License-Identifier: Apache-2.0
"""A picture as a board gets it: packed words, the clocks that they take, and what they look like."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from quadshade.board.frame_time import BoardClock, PictureClocks, packed_clocks
from quadshade.choices import MAX_ERROR, PACK_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import Pixels, ScreenTriangles
from quadshade.engine import draw_words
from quadshade.image import paint, visible
from quadshade.packing import pack_primitives
from quadshade.packing.pack import Packed
from quadshade.setup import setup_triangles
from quadshade.setup.packet import pack


class SentPicture(NamedTuple):
    """Packed words, the shade unit's state, and the formats of the board."""

    packed: Packed
    state: ShadeState | None
    formats: Formats

    def clocks(self, clock: BoardClock) -> PictureClocks:
        """What it takes at most, on an undamaged line."""
        return packed_clocks(self.packed, self.state, self.formats, clock)

    def shown(self, size: tuple[int, int], ground: tuple[int, int, int] = (0, 0, 0)) -> np.ndarray:
        """(h, w, 3) uint8: what the board shows on a ground."""
        formats = self.formats
        emitted = draw_words(pack(self.packed.primitives, formats), formats, state=self.state)
        depth = emitted.value[:, formats.emitted_channels] if formats.with_depth else None
        pixels = Pixels(emitted.packet, emitted.x, emitted.y, emitted.value, depth)
        return paint(visible(pixels, *size), pixels.value, ground, (1 << formats.value_bits) - 1)


def sent_picture(
    triangles: ScreenTriangles,
    formats: Formats,
    error: float = PACK_ERROR,
    limit: float | None = MAX_ERROR,
    **setup: Any,
) -> SentPicture:
    """
    Set up and pack.

    Parameters
    ----------
    triangles : ScreenTriangles
      As the board gets them (:func:`quadshade.board.fallbacks.sent_triangles`).
    formats : Formats
      Of the board.
    error, limit, **setup
      As for :func:`quadshade.board.frame_time.picture_clocks`.
    """
    primitives = setup_triangles(triangles, formats, limit=limit, **setup)
    packed = pack_primitives(primitives, formats, error, triangles.shade)
    return SentPicture(packed, triangles.shade, formats)
