# SPDX-License-Identifier: Apache-2.0
"""The golden model's units against something else: exact arithmetic, closed forms, first in first out."""

from __future__ import annotations

from collections import deque
from fractions import Fraction
from itertools import product
from math import floor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.golden.common.block_ram import BlockRam
from quadshade.golden.common.memory_clear import MemoryClear
from quadshade.golden.common.skid_buffer import SkidBuffer
from quadshade.golden.core.edge_dda import EdgeDda, signed
from quadshade.golden.core.edge_walker import Scanline, walk_edges
from quadshade.golden.core.lane_handshake import LaneHandshake, LaneInputs
from quadshade.golden.core.load_adder import load_adder
from quadshade.golden.core.output_clamp import output_clamp
from quadshade.golden.core.pixel_channel import PixelChannel
from quadshade.golden.core.scanline_channel import ScanlineChannel
from quadshade.golden.core.span_chain import SpanChain
from quadshade.golden.core.span_walker import walk_span
from tests.support.golden_stimuli import random_fields

SMALL = Formats(coord_bits=5, subpixel_bits=3)


@pytest.mark.parametrize("width, frac, bits", [(8, 3, 3), (9, 0, 7), (8, 5, 1), (12, 2, 8)])
def test_clamp_is_floor_then_clamp_for_every_word(width: int, frac: int, bits: int) -> None:
    for value in range(-(1 << (width - 1)), 1 << (width - 1)):
        exact = floor(Fraction(value, 1 << frac))
        expected = max(0, min(exact, (1 << bits) - 1))
        assert output_clamp(value % (1 << width), width, frac, bits) == expected, value


def test_load_adder_starts_or_steps_for_every_word() -> None:
    for value, step, carry in product(range(8), range(8), range(2)):
        assert load_adder(0, 5, value, step, 3, carry) == (value + step + carry) % 8
        assert load_adder(1, 5, value, step, 3, carry) == 5
    assert load_adder(0, 5, 7, 2, 3) == 1


@given(st.integers(0, 255), st.integers(0, 255), st.integers(0, 255), st.integers(0, 40))
def test_pixel_channel_is_a_quadratic(value: int, d_col: int, dd_col: int, pixels: int) -> None:
    channel = PixelChannel(value, d_col, dd_col, 8)
    for n in range(pixels):
        assert channel.value == (value + n * d_col + n * (n - 1) // 2 * dd_col) % 256
        channel.step()


@given(st.lists(st.integers(-1000, 1000), min_size=6, max_size=6), st.lists(st.booleans(), max_size=25))
def test_scanline_channel_follows_a_quadratic(coefficients: list[int], carries: list[bool]) -> None:
    """On the lattice of rows m and pixel steps n, along any staircase."""
    c0, cm, cn, cmm, cmn, cnn = coefficients

    def exact(m: int, n: int) -> int:
        return c0 + cm * m + cn * n + cmm * m * (m - 1) // 2 + cmn * m * n + cnn * n * (n - 1) // 2

    modulus = 1 << 40
    # d_col is the step that led to the first pixel.
    differences = [exact(0, 0), exact(1, 0) - exact(0, 0), exact(0, 0) - exact(0, -1), cmm, cmn, cnn]
    channel = ScanlineChannel([word % modulus for word in differences], 2, 40)
    n = 0
    for m, carry in enumerate([*carries, False]):
        value, step, dd_col = channel.span()
        assert value == exact(m, n) % modulus
        assert step == (exact(m, n + 1) - exact(m, n)) % modulus
        assert dd_col == cnn % modulus
        channel.step(int(carry))
        n += carry


@given(st.integers(1, 200), st.integers(-500, 500), st.integers(0, 5000), st.integers(1, 60))
def test_edge_dda_is_exact(height: int, across: int, start: int, rows: int) -> None:
    column, rest = divmod(start, height)
    step, increment = divmod(across, height)
    edge = {"column": column, "error": rest + increment - height, "step": step}
    edge |= {"increment": increment, "decrement": increment - height}
    layout = SMALL.section("edge")
    fields = {f"major_{name}": value % (1 << layout[f"major_{name}"][1]) for name, value in edge.items()}
    dda = EdgeDda(fields, "major", SMALL)
    for row in range(rows):
        assert dda.column == floor(Fraction(start + row * across, height)) % (1 << SMALL.column_bits)
        dda.step()


def test_edge_walker_counts_scanlines_and_changes_its_edge(rng: np.random.Generator) -> None:
    for _ in range(300):
        fields = random_fields(SMALL, rng)
        first = max(signed(fields["rows_first"], SMALL.column_bits) + 2, 1)
        second = max(signed(fields["rows_second"], SMALL.column_bits) + 2, 1) * fields["has_second"]
        lines = list(walk_edges(fields, SMALL))
        assert len(lines) == first + second
        assert [line.first for line in lines] == [True] + [False] * (len(lines) - 1)
        assert [line.last for line in lines] == [False] * (len(lines) - 1) + [True]
        assert [line.y for line in lines] == [(fields["y"] + row) % 32 for row in range(len(lines))]
        if fields["fractional"]:
            assert not any(line.carry for line in lines)
        for row, edge in ((0, "minor"), (first, "second")):
            if row < len(lines):
                across = signed(fields[f"{edge}_column"] - lines[row].column - 2, SMALL.column_bits)
                assert lines[row].count == across


@given(st.integers(-32, 31), st.integers(0, 63), st.booleans(), st.booleans())
def test_span_walker_covers_columns_once(count: int, column: int, mirror: bool, last: bool) -> None:
    span = Scanline(False, last, 7, column, count, 0, mirror)
    pixels = list(walk_span(span, SMALL))
    assert len(pixels) == (count + 2 if count >= -2 else count % 2)
    columns = [(column + index) % 32 for index in range(len(pixels))]
    assert [x for x, _, _ in pixels] == [31 - u if mirror else u for u in columns]
    assert [end for _, _, end in pixels] == [last and i == len(pixels) - 1 for i in range(len(pixels))]


OFFERS = st.lists(st.tuples(st.booleans(), st.booleans()), max_size=80)


@given(OFFERS)
def test_skid_buffer_is_first_in_first_out(cycles: list[tuple[bool, bool]]) -> None:
    buffer = SkidBuffer()
    held: deque[int] = deque()
    for number, (offers, ready) in enumerate(cycles):
        assert buffer.front == (held[0] if held else None)
        taken = offers and buffer.input_ready
        assert buffer.input_ready == (len(held) < 2)
        buffer.clock(number if offers else None, ready)
        if ready and held:
            held.popleft()
        if taken:
            held.append(number)


@given(st.integers(1, 5), OFFERS)
def test_span_chain_is_first_in_first_out(depth: int, cycles: list[tuple[bool, bool]]) -> None:
    chain = SpanChain(depth)
    held: deque[int] = deque()
    for number, (offers, ready) in enumerate(cycles):
        taken = offers and chain.input_ready(ready)
        assert chain.input_ready(ready) == (ready or len(held) < depth)
        if ready and chain.output is not None:
            assert held.popleft() == chain.output
        chain.clock(number if offers else None, ready)
        if taken:
            held.append(number)
        assert [stage for stage in chain.stages if stage is not None] == list(held)[::-1]


def test_memory_is_filled_on_request_when_it_is_empty() -> None:
    model, seen = MemoryClear(3), []
    for clear, emptied in (
        [(False, False)] * 4 + [(True, False), (True, False), (True, True)] + [(True, True)] * 4
    ):
        seen.append((model.address, model.draining, model.busy))
        model.clock(clear, emptied)
    waiting, idle = (None, True, True), (None, False, False)
    fill = [(address, False, True) for address in range(3)]
    assert seen == [*fill, idle, idle, waiting, waiting, *fill, idle]
    model.reset()
    assert (model.address, model.draining) == (0, False)


def test_memory_is_read_through_its_registers() -> None:
    for stages in (1, 2, 4, 5):
        model = BlockRam(stages)
        model.fill(7, 4)
        seen = []
        for clock in range(8):
            model.clock((clock, 10 + clock) if clock < 4 else None, 3 - clock if clock < 4 else 0)
            seen.append(model.read_data)
        # What is read in the clock of its writing is undefined; the first two words are read unwritten.
        late = stages - 1
        assert seen[:late] == [None] * late
        expected = [7, 7, 11, 10, 10, 10, 10, 10]
        assert seen[late:] == expected[: 8 - late], stages
        held = model.read_data
        model.clock(None, None)
        assert model.read_data == held


@pytest.mark.parametrize("stages", [1, 2, 4, 5])
def test_a_word_read_while_it_is_written_is_undefined(stages: int) -> None:
    """And no other, whatever is written: here the word is the address that is read."""
    model, seen = BlockRam(stages), []
    model.fill(7, 4)
    for write, address in [((2, 9), 2), ((0, 2), 2), (None, 0), *[(None, 1)] * stages]:
        model.clock(write, address)
        seen.append(model.read_data)
    assert seen[stages - 1 :] == [None, 9, 2, 7]


def test_a_lane_moves_when_what_is_behind_it_has_room() -> None:
    lane, full = LaneHandshake(), {"chain_full_next": True}
    stalled = {"clamped_valid": True, "emitted_valid": True}
    for inputs, moves in (
        ({"walk_span_coming": True}, "walk walked_valid advance wanted"),
        ({**full, "walk_span_coming": True, "span_valid": True}, "walked_valid advance"),
        ({**full, **stalled}, "walked_valid"),
        ({**full, "emitted_valid": True, "emitted_ready": True, "span_ending": True}, "walked_valid advance"),
        ({**full, "span_ending": True}, "walk walked_valid advance wanted"),
        ({"emitted_valid": True}, "walk advance wanted"),
        (stalled, "walk wanted"),
    ):
        lane.clock(LaneInputs(**inputs))
        assert [name for name in ("walk", "walked_valid", "advance", "wanted") if getattr(lane, name)] == (
            moves.split()
        )
        assert lane.span_taken == ("advance wanted" in moves) and lane.load == ("wanted" in moves)
