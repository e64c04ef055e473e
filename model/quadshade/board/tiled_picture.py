# SPDX-License-Identifier: Apache-2.0
"""A picture of any size, set up once: which tiles it has, and what draws one of them, bit for bit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from quadshade.board.board import Board
from quadshade.board.fallbacks import clear_word, matched_channels, painters_order
from quadshade.board.tile_plan import Cost, plan_tiles
from quadshade.choices import MAX_ERROR
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import PLANES
from quadshade.contract.shade_state import ShadeState
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.screen import EDGE_VARIANTS, edge_plane
from quadshade.packing.pack import pack_primitives
from quadshade.setup.packet import Primitives
from quadshade.setup.refit import refit, why_unfit
from quadshade.setup.tile import Cuttable, Rectangle
from quadshade.setup.triangle_setup import setup_triangles

COLOUR, DEPTH = PLANES[:2]

PACKED_SHARE = 0.25
"""Of a pixel's bytes, about, where boards pack what is read (docs/reports/readback.md)."""

EDGE_MARGIN = 1
"""An edge map looks at a pixel's neighbours."""

Planes = dict[str, np.ndarray]
"""(height, width, bytes) uint8 by the plane's name."""


def margin_of(planes: Iterable[str]) -> int:
    """Pixels round a tile that its planes depend on."""
    return EDGE_MARGIN * any(plane not in (COLOUR, DEPTH) for plane in planes)


class _Layer(NamedTuple):
    """What is drawn over what was there before."""

    cuttable: Cuttable
    shade: ShadeState | None
    triangles: int


class Part(NamedTuple):
    """
    What a board is sent of a layer for a tile.

    Attributes
    ----------
    shade : ShadeState or None
      To be loaded before.
    words : (m,) uint32
      Packed.
    triangles : int
    """

    shade: ShadeState | None
    words: np.ndarray
    triangles: int


class TiledPicture:
    """
    Triangles on a ground, of any size.

    Parameters
    ----------
    formats : Formats
      Of the picture, with coordinates for its size.
    width, height : int

    Attributes
    ----------
    colour : 3 ints
      What a board is told to clear its screen to.
    triangles : int
      Drawn so far.
    """

    def __init__(self, formats: Formats, width: int, height: int) -> None:
        self.formats, self.width, self.height = formats, width, height
        self.triangles = 0
        self.clear((0, 0, 0))

    def clear(self, colour: tuple[int, int, int]) -> None:
        """Begin anew, on a ground of a colour, 0 .. 255 each."""
        self._ground = clear_word(colour, self.formats)
        # Where boards draw in grey, one that has colours is to show it too.
        self.colour = (self._ground & 0xFF,) * 3 if self.formats.emitted_channels == 1 else colour
        self._layers: list[_Layer] = []

    def draw(
        self, triangles: ScreenTriangles, pack_error: float, limit: float | None = MAX_ERROR, **setup: Any
    ) -> list[str]:
        """
        Set triangles up and draw them; what is not as asked, a line each.

        Parameters
        ----------
        triangles : ScreenTriangles
        pack_error : float
          Grey levels by which words may be shorter: all of the picture's, before it is cut.
        limit, **setup
          As for :func:`quadshade.setup.triangle_setup.setup_triangles`.

        Raises
        ------
        QuadshadeError
          Triangles for a larger picture, or with channels that the formats do not have.
        """
        matched, notices = matched_channels(triangles, self.formats)
        if matched.width > self.width or matched.height > self.height:
            size = f"{matched.width}x{matched.height}"
            raise QuadshadeError(
                f"the triangles are for {size} pixels, the picture has {self.width}x{self.height}",
                "draw a larger one",
            )
        if self.formats.with_depth == 0 and matched.depth is not None:
            matched = replace(painters_order(matched), depth=None)
            notices.append("drawn in painter's order, as a board has no depth")
        primitives = setup_triangles(matched, self.formats, limit=limit, **setup)
        if pack_error > 0:
            primitives = pack_primitives(primitives, self.formats, pack_error, matched.shade).primitives
        self.add(primitives, matched.shade, len(triangles))
        return notices

    def add(self, primitives: Primitives, shade: ShadeState | None, triangles: int) -> None:
        """Draw what is set up already."""
        self._layers.append(_Layer(Cuttable(primitives, self.formats), shade, triangles))
        self.triangles += triangles

    def plan(
        self, most: tuple[int, int], planes: Sequence[str], boards: int = 1, packed: bool = False
    ) -> list[Cost]:
        """
        The tiles that are not all ground, the dearest one first.

        Parameters
        ----------
        most : tuple of int
          Width and height of a tile at most.
        planes : sequence of str
          What will be read.
        boards : int
          That draw at the same time.
        packed : bool
          Whether what is read is packed.
        """
        margin = margin_of(planes)
        extents = np.concatenate([np.zeros((0, 4), int), *(layer.cuttable.extents for layer in self._layers)])
        extents = extents + np.array([-margin, -margin, margin, margin])
        size = sum(len(self.empty(plane)) for plane in planes) * (PACKED_SHARE if packed else 1.0)
        return plan_tiles(extents, (self.width, self.height), most, size, boards)

    def parts(self, where: Rectangle, board: Formats) -> list[Part]:
        """What a board of some formats is sent, to show a rectangle of the picture at its top left."""
        found = []
        for layer in self._layers:
            cut = layer.cuttable.to(where)
            if len(cut):
                fitted = refit(cut, self.formats, board)
                words = pack_primitives(fitted, board, 0.0, layer.shade).words
                found.append(Part(layer.shade, words, len(np.unique(cut.triangle))))
        return found

    def window(self, tile: Rectangle, screen: tuple[int, int], planes: Sequence[str]) -> Rectangle:
        """
        The rectangle that is drawn for a tile: all of a screen where planes depend on what is round it.

        A screen repeats its border where it ends, so it is placed to end where the picture does.
        """
        margin = margin_of(planes)
        if not margin:
            return tile
        left = min(max(tile.left - margin, 0), self.width - screen[0])
        top = min(max(tile.top - margin, 0), self.height - screen[1])
        return Rectangle(left, top, *screen)

    def draw_tile(self, board: Board, tile: Rectangle, planes: Sequence[str], verify: bool | str) -> Planes:
        """
        Draw a tile on a board, and read planes of it.

        Raises
        ------
        QuadshadeError
          The board does not answer, or shows what it should not.
        """
        if reason := why_unfit(self.formats, board.formats):
            raise QuadshadeError(f"it is of another design: {reason}", "use another board")
        window = self.window(tile, (board.width, board.height), planes)
        board.clear(self.colour)
        for part in self.parts(window, board.formats):
            if part.shade is not None:
                board.state(part.shade)
            board.send(part.words, part.triangles)
        x, y = tile.left - window.left, tile.top - window.top
        found = {}
        for plane in planes:
            read = board.read_plane(plane, x + tile.width, y + tile.height, verify)[y:, x:]
            found[plane] = read[..., : len(self.empty(plane))]
        board.show()
        return found

    def ground(self, planes: Sequence[str]) -> Planes:
        """
        Planes of the picture where nothing is drawn, to paste tiles into.

        Raises
        ------
        QuadshadeError
          This machine has no memory for them.
        """
        size = (self.height, self.width)
        try:
            return {plane: np.tile(self.empty(plane), (*size, 1)) for plane in planes}
        except MemoryError:
            raise QuadshadeError(
                f"a picture of {self.width}x{self.height} pixels does not fit in this machine's memory",
                "give a smaller --size",
            ) from None

    def empty(self, plane: str) -> np.ndarray:
        """(bytes,) uint8: a pixel of a plane where nothing is drawn nearby."""
        colour = np.frombuffer(self._ground.to_bytes(4, "little"), np.uint8)[: self.formats.emitted_channels]
        if plane == COLOUR:
            return colour
        far = (1 << self.formats.depth_bits) - 1
        if plane == DEPTH:
            return np.frombuffer(far.to_bytes(4, "little"), np.uint8)[: -(-self.formats.depth_bits // 8)]
        variant = EDGE_VARIANTS[PLANES.index(plane) - PLANES.index("edges_diagonal")]
        flat = np.broadcast_to(colour, (3, 3, 3)), np.full((3, 3), far)
        pixel: np.ndarray = edge_plane(*flat, self.formats.depth_bits, variant)[1, 1]
        return pixel

    def content(self) -> Iterable[bytes]:
        """All that the picture follows from."""
        yield repr((self.formats, self.width, self.height, self._ground)).encode()
        for layer in self._layers:
            primitives = layer.cuttable.primitives
            if layer.shade is not None:
                yield layer.shade.writes().tobytes()
            yield primitives.words.tobytes() + primitives.orders.tobytes()
            for columns in (primitives.header, *primitives.edges.values()):
                for column in columns.values():
                    yield np.ascontiguousarray(column).tobytes()


def paste(planes: Planes, tile: Rectangle, found: Planes) -> None:
    """Write a tile into planes of the picture."""
    for plane, pixels in found.items():
        planes[plane][tile.top : tile.bottom, tile.left : tile.right] = pixels
