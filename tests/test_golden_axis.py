# SPDX-License-Identifier: Apache-2.0
"""The core behind AXI: a pixel's bytes, what its registers count and answer, and the shade unit's writes."""

from __future__ import annotations

from dataclasses import asdict
from itertools import chain

import numpy as np
import pytest

from quadshade.contract.axis import GENERICS_FIRST, REGISTERS_FIRST
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import colour_state
from quadshade.errors import QuadshadeError
from quadshade.golden.core.raster_core import EmittedPixel
from quadshade.golden.core.setup_loader import packet_beats
from quadshade.golden.quadshade_axis import QuadshadeAxis, pixel_data
from quadshade.golden.shade.render_core import draw_scalar
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.golden_stimuli import triangles_of

SHADED = Formats(with_shade=1, num_channels=2, num_specular=1, coord_bits=6)
NINE = Formats(num_channels=2, with_depth=0, value_bits=9, frac_bits=20, coord_bits=6)
PIXELS = {
    "default": (Formats(), (7, 8, 9, 0x1234), "0201 0403 3412 07 08 09"),
    "no_depth": (NINE, (0x1FE, 0x101), "0201 0403 0000 fe01 0101"),
}


@pytest.mark.parametrize("name", PIXELS)
def test_fields_are_whole_bytes_the_lowest_first(name: str) -> None:
    formats, value, data = PIXELS[name]
    pixel = EmittedPixel(packet=0, last=False, x=0x0102, y=0x0304, value=value)
    assert pixel_data(pixel, formats) == bytes.fromhex(data)


@pytest.mark.parametrize("formats", [NINE, SHADED])
def test_pixels_come_by_primitive_and_are_counted(formats: Formats) -> None:
    primitives = setup_triangles(triangles_of(formats, np.random.default_rng(3), 6, 16), formats)
    words = pack(primitives, formats).tolist()
    unit, state = QuadshadeAxis(formats), None
    if formats.with_shade:
        state = colour_state(formats)
        for address, value in state.writes():
            assert unit.write(4 * address, value)
    expected = [pixel_data(pixel, formats) for pixel in draw_scalar(words, formats, state)]
    for times in (1, 2):
        frames = unit.draw(words)
        assert list(chain(*frames)) == expected and len(frames) == len(primitives) and all(frames)
        assert unit.read(REGISTERS_FIRST + 8) == (times * len(frames), True)
        assert unit.read(REGISTERS_FIRST + 12) == (times * len(expected), True)
    unit.counters = {"primitives": 2**32 - 1, "pixels": 2**32 - 1, "cut_packets": 2**32 - 1}
    unit.draw(words)
    assert unit.counters == {
        "primitives": len(frames) - 1,
        "pixels": len(expected) - 1,
        "cut_packets": 2**32 - 1,
    }
    unit.reset()
    assert unit.counters == {"primitives": 0, "pixels": 0, "cut_packets": 0}
    assert list(chain(*unit.draw(words))) == expected, "the shade unit's state stays"
    assert unit.draw([]) == []


@pytest.mark.parametrize("formats", [Formats(), Formats(stream_width=128), SHADED], ids=repr)
def test_a_cut_packet_draws_nothing_and_is_counted(formats: Formats) -> None:
    """By every length that a packet can be cut to; what stands around it is drawn as without it."""
    primitives = setup_triangles(triangles_of(formats, np.random.default_rng(4), 7, 16), formats)
    words, width, packets = pack(primitives, formats).tolist(), formats.beat_words, []
    while words:
        size = packet_beats(words[0], formats) * width
        packets.append(words[:size])
        words = words[size:]
    first, cut, last = packets[:3]
    expected = QuadshadeAxis(formats).draw(first + last)
    for beats in range(1, len(cut) // width + 1):
        words = first + cut[: beats * width] + last
        lasts = [False] * (len(words) // width)
        lasts[len(first) // width + beats - 1] = True
        unit, whole = QuadshadeAxis(formats), beats * width == len(cut)
        drawn = unit.draw(words, lasts)
        assert drawn == (QuadshadeAxis(formats).draw(words) if whole else expected)
        assert unit.counters["cut_packets"] == (0 if whole else 1)
        assert unit.read(REGISTERS_FIRST + 16) == (unit.counters["cut_packets"], True)
    with pytest.raises(QuadshadeError, match="ends within a packet"):
        unit.draw(words[:-width], lasts[:-1])


def test_registers_answer_where_they_are() -> None:
    unit = QuadshadeAxis(SHADED)
    assert unit.read(REGISTERS_FIRST) == (0x44485351, True) and unit.read(REGISTERS_FIRST + 4) == (1, True)
    for index, (name, value) in enumerate(SHADED.generics().items()):
        assert name == list(asdict(SHADED))[index]
        assert unit.read(REGISTERS_FIRST + GENERICS_FIRST + 4 * index) == (value, True)
    end = REGISTERS_FIRST + GENERICS_FIRST + 4 * len(SHADED.generics())
    for address in (0, 4, REGISTERS_FIRST - 4, REGISTERS_FIRST + 2, REGISTERS_FIRST + 20, end):
        assert unit.read(address) == (0, False)


def test_writes_are_whole_words_of_the_shade_unit() -> None:
    unit = QuadshadeAxis(SHADED)
    assert unit.write(0, 5) and unit.write(REGISTERS_FIRST - 4, 6)
    assert unit.state == {0: 5, REGISTERS_FIRST // 4 - 1: 6}
    for address, strobes in ((REGISTERS_FIRST, 15), (1, 15), (2, 15), (8, 7), (8, 0)):
        assert not unit.write(address, 9, strobes)
    assert not QuadshadeAxis(Formats()).write(0, 5)
    assert unit.state == {0: 5, REGISTERS_FIRST // 4 - 1: 6}
