# SPDX-License-Identifier: Apache-2.0
"""The fast model equals the scalar one, pixel by pixel, on triangles and noise; cut streams are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.golden.compiled import draw_fast
from quadshade.golden.core.raster_core import draw_scalar
from quadshade.golden.core.setup_loader import load_packets
from tests.support.golden_stimuli import malformed_words, triangle_words

FORMATS = [
    Formats(),
    Formats(stream_width=64, span_depth=1),
    Formats(stream_width=128, num_channels=4, with_depth=0),
    Formats(word_width=24, frac_bits=14),
    Formats(word_width=40, frac_bits=28, stream_width=128),
    Formats(word_width=60, frac_bits=46, stream_width=32),
    Formats(num_channels=1, max_order=1, coord_bits=13, subpixel_bits=12),
    Formats(num_channels=8, max_order=0, stream_width=64, coord_bits=6),
    Formats(num_channels=3, max_order=0, with_depth=0, coord_bits=3, subpixel_bits=0, stream_width=128),
]


def changed(formats: Formats) -> str:
    """Generics that differ from the defaults."""
    default = Formats().generics()
    names = [f"{name}={value}" for name, value in formats.generics().items() if value != default[name]]
    return "-".join(names) or "default"


def assert_equal(words: np.ndarray, formats: Formats) -> int:
    """Both models draw the same; the number of pixels."""
    scalar = draw_scalar(words.tolist(), formats)
    fast = draw_fast(words, formats)
    drawn = [
        (int(p), int(x), int(y), tuple(v))
        for p, x, y, v in zip(fast.packet, fast.x, fast.y, fast.value.tolist(), strict=True)
    ]
    expected = [(pixel.packet, pixel.x, pixel.y, pixel.value) for pixel in scalar]
    wrong = [index for index, (a, b) in enumerate(zip(drawn, expected, strict=False)) if a != b]
    assert not wrong, f"{len(wrong)} wrong, first {wrong[0]}: {drawn[wrong[0]]} is not {expected[wrong[0]]}"
    assert len(drawn) == len(expected)
    assert fast.packets == len(list(load_packets(words.tolist(), formats)))
    # At most one pixel a clock, and nothing before the first packet is in.
    assert fast.clocks == 0 if not drawn else fast.clocks > len(drawn)
    return len(drawn)


@pytest.mark.parametrize("formats", FORMATS, ids=changed)
def test_fast_equals_scalar_on_triangles(formats: Formats, rng: np.random.Generator) -> None:
    assert assert_equal(triangle_words(formats, rng, 42), formats) > 10


@pytest.mark.parametrize("formats", FORMATS, ids=changed)
def test_fast_equals_scalar_on_nonsense(formats: Formats, rng: np.random.Generator) -> None:
    assert assert_equal(malformed_words(formats, rng, 40), formats) > 250


@st.composite
def small_formats(draw: st.DrawFn) -> Formats:
    """Any generics, with coordinates small enough for spans of every length."""
    word_width = draw(st.integers(12, 60))
    value_bits = draw(st.integers(1, min(word_width - 2, 16)))
    return Formats(
        num_channels=draw(st.integers(1, 8)),
        max_order=draw(st.integers(0, 2)),
        with_depth=draw(st.integers(0, 1)),
        word_width=word_width,
        frac_bits=draw(st.integers(0, word_width - value_bits - 2)),
        value_bits=value_bits,
        depth_bits=draw(st.integers(1, min(word_width - 2, 31))),
        subpixel_bits=draw(st.integers(0, 12)),
        coord_bits=draw(st.integers(3, 5)),
        stream_width=draw(st.sampled_from((32, 64, 128))),
        span_depth=draw(st.integers(1, 16)),
    )


@settings(max_examples=30)
@given(small_formats(), st.integers(0, 2**32))
def test_fast_equals_scalar_on_any_formats(formats: Formats, seed: int) -> None:
    assert_equal(malformed_words(formats, np.random.default_rng(seed), 8), formats)


def test_no_words_no_pixels() -> None:
    for formats in FORMATS:
        nothing = draw_fast(np.zeros(0, np.uint32), formats)
        assert (len(nothing.x), nothing.clocks, nothing.packets) == (0, 0, 0)
        assert draw_scalar([], formats) == []


@pytest.mark.parametrize("formats", FORMATS, ids=changed)
def test_stream_cut_within_a_packet_is_refused(formats: Formats, rng: np.random.Generator) -> None:
    words = malformed_words(formats, rng, 2)
    ends = {0, *np.cumsum([packet.beats for packet in load_packets(words.tolist(), formats)])}
    for length in range(len(words) + 1):
        beats, rest = divmod(length, formats.beat_words)
        if not rest and beats in ends:
            draw_fast(words[:length], formats)
            continue
        for draw in (lambda cut: draw_fast(cut, formats), lambda cut: draw_scalar(cut.tolist(), formats)):
            with pytest.raises(QuadshadeError, match="within a packet"):
                draw(words[:length])
