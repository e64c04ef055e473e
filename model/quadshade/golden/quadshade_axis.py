# SPDX-License-Identifier: Apache-2.0
"""The core behind AXI (``rtl/quadshade_axis.vhd``): what its streams carry and its registers answer."""

from __future__ import annotations

from collections.abc import Sequence

from quadshade.contract.axis import (
    AXI_DATA_BITS,
    IDENTITY,
    REGISTERS,
    REGISTERS_FIRST,
    pixel_bytes,
    pixel_places,
)
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState
from quadshade.golden.core.raster_core import EmittedPixel
from quadshade.golden.core.setup_loader import sent_packets, whole_packets
from quadshade.golden.shade.render_core import draw_scalar


def pixel_data(pixel: EmittedPixel, formats: Formats) -> bytes:
    """The bytes of a pixel that ``tkeep`` marks, the lowest first."""
    places = pixel_places(formats)
    count = formats.emitted_channels
    channel_bits = places["value"][1] // count
    value = sum(one << channel_bits * index for index, one in enumerate(pixel.value[:count]))
    depth = pixel.value[-1] if formats.with_depth else 0
    fields = {"x": pixel.x, "y": pixel.y, "depth": depth, "value": value}
    data = sum(fields[name] << low for name, (low, _) in places.items())
    return data.to_bytes(pixel_bytes(formats), "little")


class QuadshadeAxis:
    """
    The core with its registers.

    Parameters
    ----------
    formats : Formats

    Attributes
    ----------
    state : dict of int
      What was written to the shade unit, by its own address.
    """

    def __init__(self, formats: Formats) -> None:
        self.formats = formats
        self.state: dict[int, int] = {}
        self.reset()

    def reset(self) -> None:
        """Zero the counters; the shade unit keeps its state."""
        self.counters = {"primitives": 0, "pixels": 0, "cut_packets": 0}

    def draw(self, words: Sequence[int], lasts: Sequence[bool] = ()) -> list[list[bytes]]:
        """
        The pixels of a stream of words, up to each ``tlast``.

        The host's packets end with a last pixel; those of a malformed one may run into the next.

        Parameters
        ----------
        words : sequence of int
          32-bit set-up words, whole beats.
        lasts : sequence of bool
          ``tlast`` of every beat; if left out, it is low.

        Returns
        -------
        list of list of bytes
          A pixel's bytes, primitive by primitive.

        Raises
        ------
        QuadshadeError
          The stream ends within a packet, without ``tlast``.
        """
        cut = 0
        if lasts:
            cut = sum(not packet.whole for packet in sent_packets(words, lasts, self.formats))
            words = whole_packets(words, lasts, self.formats)
        state = ShadeState.from_registers(self.state, self.formats) if self.formats.with_shade else None
        frames: list[list[bytes]] = [[]]
        for pixel in draw_scalar(words, self.formats, state):
            frames[-1].append(pixel_data(pixel, self.formats))
            if pixel.last:
                frames.append([])
        ended = len(frames) - 1
        frames = frames if frames[-1] else frames[:-1]
        pixels = sum(map(len, frames))
        for name, more in (("primitives", ended), ("pixels", pixels), ("cut_packets", cut)):
            self.counters[name] = (self.counters[name] + more) % (1 << AXI_DATA_BITS)
        return frames

    def write(self, address: int, data: int, strobes: int = 15) -> bool:
        """A write of AXI4-Lite to a byte address; False is the answer SLVERR."""
        if not self.formats.with_shade or address >= REGISTERS_FIRST or address % 4 or strobes != 15:
            return False
        self.state[address // 4] = data
        return True

    def read(self, address: int) -> tuple[int, bool]:
        """What a read of a byte address gives while the core is idle, and whether it is not SLVERR."""
        values = {"identity": IDENTITY, "status": 1, **self.counters}
        values |= {f"generic_{name}": value for name, value in self.formats.generics().items()}
        for register in REGISTERS:
            if address == REGISTERS_FIRST + register.offset:
                return values[register.name], True
        return 0, False
