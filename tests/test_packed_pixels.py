# SPDX-License-Identifier: Apache-2.0
"""Packed answers of READ: what the golden model packs the host unpacks, and nothing else passes for it."""

from __future__ import annotations

import random
from itertools import product

import numpy as np
import pytest

from quadshade.board import Board, BoardSettings
from quadshade.choices import VERIFIES
from quadshade.contract.protocol import ESCAPE_ONES, MAX_READ, LinkError
from quadshade.errors import QuadshadeError
from quadshade.golden.link.pixel_packer import code_of, pack_pixels, packed_bits, predicted
from quadshade.link.packed_pixels import unpack_pixels

EXAMPLE = bytes((10,) * 9 + (12, 15, 18, 21))
EXAMPLE_BITS = "11111 00001010 0 1 1 1 0 000 1110 10 0 1"
"""Of docs/reference/readback.md."""


def smooth(draw: random.Random, count: int, size: int, steps: tuple[int, ...]) -> bytes:
    """Bytes that are about as predicted."""
    data = bytearray()
    for index in range(count):
        data.append((predicted(bytes(data) + b"\0", index, size) + draw.choice(steps)) % 256)
    return bytes(data)


def check(data: bytes, size: int) -> int:
    """Pack and unpack; how many bytes the answer has."""
    packed = pack_pixels(data, size)
    assert len(packed) <= len(data)
    assert unpack_pixels(packed, len(data), size) == data
    return len(packed)


def test_the_pages_example() -> None:
    bits = EXAMPLE_BITS.replace(" ", "")
    assert packed_bits(EXAMPLE, 1) == bits
    assert pack_pixels(EXAMPLE, 1) == int(bits.ljust(32, "0"), 2).to_bytes(4, "big")
    assert check(EXAMPLE, 1) == 4


def test_a_byte_takes_the_more_bits_the_further_it_is_from_what_was_predicted() -> None:
    for residual in range(-4, 5):
        ones = 2 * residual - 1 if residual > 0 else -2 * residual
        code = "1" * ones + "0" if ones < ESCAPE_ONES else "1" * ESCAPE_ONES + "00010001"
        assert code_of(0x11, residual % 256) == code


@pytest.mark.parametrize("size", (1, 2, 3, 4))
def test_every_short_area_comes_back(size: int) -> None:
    """All of up to five bytes of a few values, with a run behind them so that packing saves some."""
    for count in range(1, 6):
        for row in product((0, 1, 2, 77, 254, 255), repeat=count) if count < 5 else product((0, 9), repeat=5):
            check(bytes(row), size)
            data = bytearray(row)
            for index in range(count, count + 12):
                data.append(predicted(bytes(data) + b"\0", index, size))
            check(bytes(data), size)


@pytest.mark.parametrize("size", (1, 2, 3, 4))
def test_areas_of_every_length_come_back(size: int) -> None:
    draw = random.Random(size)
    for count in (*range(1, 80), MAX_READ - 1, MAX_READ):
        for steps in ((0,), (0, 0, 0, 1, -1), (0, 1, -1, 2, -2, 3, -3, 100)):
            check(smooth(draw, count, size, steps), size)
        assert check(draw.randbytes(count), size) <= count


def test_flat_areas_take_a_few_bytes_and_noise_none_more() -> None:
    draw = random.Random(1)
    assert pack_pixels(bytes(MAX_READ), 3) == bytes((0x1F, 0xF8))
    assert check(bytes((200, 100, 50)) * 300, 3) < 10
    noise = draw.randbytes(MAX_READ)
    assert pack_pixels(noise, 3) == noise


def test_damaged_answers_are_refused_or_have_their_length() -> None:
    """The frame's CRC keeps them away; what a wrong board sends ends in one line, never in a traceback."""
    draw = random.Random(2)
    refused = 0
    for _ in range(3000):
        size, count = draw.randint(1, 4), draw.randint(1, 90)
        answer = bytearray(pack_pixels(smooth(draw, count, size, (0, 0, 0, 1, -1, 9)), size))
        kind = draw.randrange(4)
        if kind == 0:
            answer[draw.randrange(len(answer))] ^= 1 << draw.randrange(8)
        elif kind == 1:
            del answer[draw.randrange(len(answer)) :]
        elif kind == 2:
            answer += draw.randbytes(draw.randint(1, 5))
        else:
            answer[:] = draw.randbytes(draw.randint(1, count))
        try:
            assert len(unpack_pixels(bytes(answer), count, size)) == count
        except LinkError as error:
            assert "does not unpack" in str(error) and "\n" not in str(error)
            refused += 1
    assert refused > 1000


@pytest.mark.parametrize(
    ("answer", "count"),
    [
        # Cut in an escape; a one in the padding; a byte too many; bytes missing; none; more than asked for.
        (b"\xfb", 9),
        (b"\x1f\xf9", 40),
        (b"\x1f\xf8\x00", MAX_READ),
        (b"\x00", 20),
        (b"", 5),
        (bytes(6), 5),
    ],
)
def test_what_no_board_packs(answer: bytes, count: int) -> None:
    with pytest.raises(LinkError, match=f"of {len(answer)} bytes does not unpack to the {count} that"):
        unpack_pixels(answer, count, 1)


SIZE = (24, 16)


def read(packs: int, lie: bytes | None = None) -> tuple[np.ndarray, int]:
    """A picture from a board, and the bytes that came."""
    settings = BoardSettings(screen_width=SIZE[0], screen_height=SIZE[1], with_packed_read=packs)
    with Board("sim", settings=settings, engine="model") as board:
        screen = board.simulated.engine.board.drawing
        if lie is not None:
            screen.read = lambda **_: lie
        board.clear((9, 200, 30))
        before = board.statistics["bytes_received"]
        return board.read(verify=VERIFIES[0]), int(board.statistics["bytes_received"] - before)


def test_boards_that_pack_and_that_do_not() -> None:
    (whole, many), (packed, few) = read(0), read(1)
    assert np.array_equal(whole, packed) and (whole == (9, 200, 30)).all()
    assert 3 * few < many


@pytest.mark.parametrize("lie", (b"\xff", bytes(7), bytes(1012)))
def test_a_board_that_packs_rubbish_is_one_line(lie: bytes) -> None:
    with pytest.raises(QuadshadeError, match="a packed answer of .* the board fails"):
        read(1, lie)
