# SPDX-License-Identifier: Apache-2.0
"""The models of the link's units against zlib and cobs, and transmitter against receiver."""

from __future__ import annotations

import zlib
from itertools import combinations_with_replacement

import pytest
from cobs import cobs
from hypothesis import given
from hypothesis import strategies as st

from quadshade.contract.protocol import BREAK_BITS, PHASE_BITS
from quadshade.golden.common.crc32 import CRC_RESIDUE, crc_of
from quadshade.golden.link.cobs_decoder import CobsDecoder, decode_line
from quadshade.golden.link.cobs_encoder import encode_line
from quadshade.golden.link.uart_rx import UartRx
from quadshade.golden.link.uart_tx import UartTx
from quadshade.link.frames import sealed

BODIES = st.builds(
    lambda pieces: b"".join(pieces)[:1024],
    st.lists(
        st.one_of(st.binary(max_size=20), st.sampled_from([b"\0", b"\1" * 253, b"\2" * 254])), min_size=1
    ),
).filter(len)


@given(st.binary())
def test_crc_is_zlibs(data: bytes) -> None:
    assert crc_of(data) == zlib.crc32(data)
    assert crc_of(sealed(data)) == CRC_RESIDUE


@given(BODIES)
def test_cobs_is_that_of_cobs(body: bytes) -> None:
    line = encode_line(body)
    assert line == b"\0" + cobs.encode(body) + b"\0"
    assert decode_line(line) == [body]


@given(st.binary(max_size=40))
def test_decoder_accepts_what_cobs_accepts(line: bytes) -> None:
    expected = []
    for piece in line.split(b"\0")[:-1]:
        try:
            expected += [cobs.decode(piece)] if piece else []
        except cobs.DecodeError:
            continue
    assert decode_line(line) == expected


@given(st.lists(st.one_of(st.integers(0, 255), st.none()), max_size=300), BODIES)
def test_decoder_is_at_a_frames_start_after_any_zero(noise: list[int | None], body: bytes) -> None:
    decoder, got = CobsDecoder(), bytearray()
    for byte in noise:
        decoder.error() if byte is None else decoder.add(byte)
    decoder.add(0)
    results = [decoder.add(byte) for byte in encode_line(body)]
    got += bytes(result.data for result in results if result.data is not None)
    assert (bytes(got), results[-1].end, results[-1].good) == (body, True, True)


def received(line: list[int], step: int) -> tuple[list[int], int, int]:
    """Bytes, framing errors and breaks that the receiver sees on a line, clock by clock."""
    uart, data, errors, breaks = UartRx(), [], 0, 0
    for level in [*line, *[1] * 8]:
        uart.clock(level, step)
        data += [uart.outputs.data] if uart.outputs.valid else []
        errors += uart.outputs.framing_error
        breaks += uart.outputs.break_seen
    return data, errors, breaks


@pytest.mark.parametrize("clocks", [4, 8.333, 12, 33.3, 100])
@pytest.mark.parametrize("skew", [-0.02, 0, 0.02])
def test_receiver_takes_what_the_transmitter_sends(clocks: float, skew: float) -> None:
    step = round((1 << PHASE_BITS) / clocks)
    # At four clocks a bit there is no room for a step above a quarter.
    sender, sent, line = UartTx(), [0, 255, 0x55, 0xAA, 1, 128, *range(40)], []
    waiting = iter(sent)
    offered = next(waiting)
    while offered is not None or sender.busy:
        taken = sender.ready(round(step * (1 + skew)))
        sender.clock(offered, round(step * (1 + skew)))
        if taken and offered is not None:
            offered = next(waiting, None)
        line.append(sender.tx)
    assert received(line, step) == (sent, 0, 0)
    # Back to back: ten bits a byte.
    assert abs(len(line) - 10 * len(sent) * clocks / (1 + skew)) <= 3 + len(line) / 1e4


def test_breaks_and_framing_errors() -> None:
    step = (1 << PHASE_BITS) // 8
    bit = 8
    glitch = [1] * 20 + [0] * 3 + [1] * 100
    assert received(glitch, step) == ([], 0, 0)
    assert received([0] * (bit * 9) + [1] * 30, step) == ([0], 0, 0)
    assert received([0] * (bit * 12) + [1] * 30, step) == ([], 1, 0)
    assert received([0] * (bit * (BREAK_BITS - 1)) + [1] * 30, step) == ([], 1, 0)
    # A break is seen once, however long, and a character after it is taken.
    character = [level for value in [0, *[1] * 8, 1] for level in [value] * bit]
    assert received([0] * (bit * 100) + [1] * bit + character, step) == ([255], 1, 1)


def test_a_bit_is_the_majority_of_three_samples() -> None:
    """At eight clocks a bit: two disturbed clocks change a bit if they are two of three in its middle."""
    step, sent = (1 << PHASE_BITS) // 8, 0b01101001
    levels = [0, *(sent >> place & 1 for place in range(8)), 1]
    clean = [1] * 8 + [level for level in levels for _ in range(8)] + [1] * 8
    for bit in range(8):
        first, changing = 8 + 8 * (bit + 1), []
        for pair in combinations_with_replacement(range(-1, 9), 2):
            line = list(clean)
            for place in set(pair):
                line[first + place] ^= 1
            data, errors, breaks = received(line, step)
            assert (errors, breaks) == (0, 0) and data in ([sent], [sent ^ 1 << bit])
            changing += [pair] if data != [sent] else []
        low = changing[0][0]
        assert changing == [(low, low + 1), (low, low + 2), (low + 1, low + 2)] and low in (2, 3)
