# SPDX-License-Identifier: Apache-2.0
"""The SDRAM's chip refuses what its data sheet does, and its controller gives it nothing of that kind."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from quadshade.golden.common.sdram_chip import (
    ALL_BANKS,
    CHIPS,
    IDLE_PINS,
    POWER_UP_NS,
    Command,
    Pins,
    SdramChip,
    SdramFault,
)
from quadshade.golden.common.sdram_controller import Run, SdramController, SdramGenerics
from quadshade.golden.screen.framebuffer import HALF_STEP, draw_pixels, kept_colours, thresholds
from quadshade.golden.screen.screen import Screen
from quadshade.golden.screen.sdram_depth_test import DEPTH_PLANE, Pixel, SdramDepthTest
from quadshade.golden.screen.sdram_line_fetch import line_runs, most_line_clocks
from quadshade.golden.screen.sdram_read_out import area_runs
from quadshade.golden.screen.sdram_screen import SdramScreen, colour_words

MHZ_100 = 100e6
MODE = 0x30
"""A CAS latency of three."""
Step = tuple[int, Pins]
"""Clocks since the step before, and what is on the pins."""


def step(clocks: int, command: Command, bank: int = 0, address: int = 0, data: int | None = None) -> Step:
    """A command so many clocks after the last."""
    return clocks, Pins(command, bank, address, False, data is not None, data or 0)


CLOSE, REFRESH = step(1, Command.PRECHARGE, address=ALL_BANKS), step(7, Command.REFRESH)
BEGIN = [CLOSE, step(3, Command.REFRESH), REFRESH, step(7, Command.MODE, address=MODE)]
OPEN = [*BEGIN, step(2, Command.ACTIVE, 1, 5)]
"""With the times of AS4C16M16SA-7 at 100 MHz: rows of 21 ns are three clocks, of 63 ns seven."""


def run(steps: Iterable[Step], power_up: int = 0, **timing: float) -> SdramChip:
    """The chip after some steps."""
    chip = SdramChip(replace(CHIPS["AS4C16M16SA-7"], **timing), MHZ_100, power_up * 10)
    for clocks, pins in steps:
        for _ in range(clocks - 1):
            chip.clock(IDLE_PINS._replace(mask=False))
        chip.clock(pins)
    return chip


def test_words_are_read_where_they_were_written() -> None:
    chip = run([*OPEN, step(3, Command.WRITE, 1, 7, 0xBEEF), step(1, Command.WRITE, 1, 8, 0xCAFE)])
    chip.clock(Pins(Command.READ, 1, 7, False))
    seen = []
    for _ in range(4):
        seen.append(chip.data)
        chip.clock(IDLE_PINS._replace(mask=False))
    # Before the third edge behind that of the command, and no longer.
    assert seen == [None, None, 0xBEEF, None]
    chip.clock(Pins(Command.READ, 1, 7, False))
    chip.clock(IDLE_PINS._replace(mask=True))
    for _ in range(3):
        chip.clock(IDLE_PINS._replace(mask=False))
        assert chip.data is None, "masked two clocks before"
    chip.clock(Pins(Command.WRITE, 1, 7, True, True, 0xDEAD))
    assert chip.words == {(1, 5, 7): 0xBEEF, (1, 5, 8): 0xCAFE} and (chip.reads, chip.writes) == (2, 3)


def test_the_shortest_times_are_allowed() -> None:
    again = [step(2, Command.PRECHARGE, 1), step(3, Command.ACTIVE, 1, 6), step(2, Command.ACTIVE, 2, 6)]
    chip = run([*OPEN, step(3, Command.READ, 1, 0), *again])
    assert chip.open_rows == {1: 6, 2: 6}
    run(
        [
            *OPEN,
            step(3, Command.WRITE, 1, 0, 1),
            step(2, Command.PRECHARGE, 1),
            step(3, Command.REFRESH),
            REFRESH,
        ]
    )


REFUSED: dict[str, list[Step]] = {
    "MODE before the banks were closed": [step(1, Command.MODE, address=MODE)],
    "REFRESH before the banks were closed": [REFRESH],
    "MODE after 1 refreshes": [CLOSE, step(3, Command.REFRESH), step(7, Command.MODE, address=MODE)],
    "ACTIVE before MODE": [CLOSE, step(3, Command.ACTIVE)],
    "REFRESH after PRECHARGE: 2 clocks, t_rp is 3": [CLOSE, step(2, Command.REFRESH)],
    "REFRESH after REFRESH: 6 clocks, t_rfc is 7": [*BEGIN[:2], step(6, Command.REFRESH)],
    "MODE after REFRESH: 6 clocks": [*BEGIN[:3], step(6, Command.MODE, address=MODE)],
    "a mode of 0x33": [*BEGIN[:3], step(7, Command.MODE, address=0x33)],
    "a mode of 0x10": [*BEGIN[:3], step(7, Command.MODE, address=0x10)],
    "ACTIVE after MODE: 1 clocks, t_mrd is 2": [*BEGIN, step(1, Command.ACTIVE)],
    "row 8192 of 8192": [*BEGIN, step(2, Command.ACTIVE, 0, 8192)],
    "READ in bank 0, which is not open": [*OPEN, step(3, Command.READ)],
    "WRITE in bank 2, which is not open": [*OPEN, step(3, Command.WRITE, 2, 0, 1)],
    "READ after ACTIVE: 2 clocks, t_rcd is 3": [*OPEN, step(2, Command.READ, 1)],
    "WRITE after ACTIVE: 2 clocks, t_rcd is 3": [*OPEN, step(2, Command.WRITE, 1, 0, 1)],
    "READ that closes its row": [*OPEN, step(3, Command.READ, 1, ALL_BANKS)],
    "column 512 of 512": [*OPEN, step(3, Command.READ, 1, 512)],
    "READ with a word": [*OPEN, step(3, Command.READ, 1, 0, 1)],
    "WRITE without a word": [*OPEN, step(3, Command.WRITE, 1, 0)],
    "READ while the mask is set": [*OPEN, (3, Pins(Command.READ, 1))],
    "ACTIVE while bank 1 is open": [*OPEN, step(9, Command.ACTIVE, 1, 6)],
    "ACTIVE after ACTIVE of another bank: 1 clocks, t_rrd is 2": [*OPEN, step(1, Command.ACTIVE, 2)],
    "PRECHARGE after ACTIVE: 4 clocks, t_ras is 5": [*OPEN, step(4, Command.PRECHARGE, 1)],
    "PRECHARGE after WRITE: 1 clocks, t_wr is 2": [
        *OPEN,
        step(6, Command.WRITE, 1, 0, 1),
        step(1, Command.PRECHARGE, 1),
    ],
    "ACTIVE after PRECHARGE: 2 clocks": [*OPEN, step(5, Command.PRECHARGE, 1), step(2, Command.ACTIVE, 1)],
    "REFRESH while bank 1 is open": [*OPEN, step(7, Command.REFRESH)],
    "MODE while bank 1 is open": [*OPEN, step(7, Command.MODE, address=MODE)],
    "bank 1 is open for more than 12000 clocks": [*OPEN, step(12002, Command.NOTHING)],
    "driven while a word is read": [*OPEN, step(3, Command.READ, 1), step(3, Command.WRITE, 1, 0, 1)],
    "or in the clock after it": [*OPEN, step(3, Command.READ, 1), step(4, Command.WRITE, 1, 0, 1)],
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_the_data_sheet_forbids_is_refused(message: str) -> None:
    run(REFUSED[message][:-1])
    with pytest.raises(SdramFault, match=message):
        run(REFUSED[message])


CLOCKS = {
    "MT48LC16M16A2-75": (7.5, (3, 3, 6, 9, 9, 2, 2, 2)),
    "AS4C16M16SA-7": (7.0, (3, 3, 6, 9, 9, 2, 2, 2)),
}
"""Shortest clock in nanoseconds, and t_rcd, t_rp, t_ras, t_rc, t_rfc, t_rrd, t_wr, t_mrd in clocks then."""


@pytest.mark.parametrize("name", CLOCKS)
def test_times_in_clocks_at_the_shortest(name: str) -> None:
    period, clocks = CLOCKS[name]
    names = ("t_rcd", "t_rp", "t_ras", "t_rc", "t_rfc", "t_rrd", "t_wr", "t_mrd")
    timing = CHIPS[name]
    assert tuple(timing.clocks(one, 1e9 / period) for one in names) == clocks
    # A nanosecond more of what fills its clocks is a clock more; a clock at least, and two after a mode.
    filled = [one for one, count in zip(names, clocks, strict=True) if getattr(timing, one) == count * period]
    assert filled
    for one in filled:
        longer = replace(timing, **{one: getattr(timing, one) + 1})
        assert longer.clocks(one, 1e9 / period) == timing.clocks(one, 1e9 / period) + 1
    assert [timing.clocks(one, 1e6) for one in names] == [1] * 7 + [2]


def test_pins_that_are_not_given_are_low_and_masked() -> None:
    assert Pins(Command.READ) == (Command.READ, 0, 0, True, False, 0)


def test_other_times_that_a_data_sheet_may_have() -> None:
    with pytest.raises(SdramFault, match="t_rc is 9"):
        run([*OPEN, step(5, Command.PRECHARGE, 1), step(3, Command.ACTIVE, 1)], t_rc=81)
    with pytest.raises(SdramFault, match="a CAS latency of 2"):
        run([*BEGIN[:3], step(7, Command.MODE, address=0x20)], t_ck2=10.5)
    with pytest.raises(SdramFault, match="PRECHARGE 50 clocks after power-up, not 100"):
        run([step(51, Command.PRECHARGE, address=ALL_BANKS)], power_up=100)
    run([step(101, Command.PRECHARGE, address=ALL_BANKS)], power_up=100)


def test_every_row_is_refreshed_in_time() -> None:
    """Four rows in 40 clocks: the oldest of the last four refreshes is not older than that."""
    regular = [*BEGIN, *[REFRESH] * 4, *[step(10, Command.REFRESH)] * 8]
    run(regular, rows=4, t_ref=400)
    with pytest.raises(SdramFault, match="a row was not refreshed for 40 clocks"):
        run([*regular, step(11, Command.REFRESH)], rows=4, t_ref=400)
    with pytest.raises(SdramFault, match="a row was not refreshed"):
        run([*BEGIN, step(50, Command.NOTHING)], rows=4, t_ref=400)


def traffic(generics: SdramGenerics, chip: SdramChip, cycles: int, seed: int = 1) -> int:
    """Random runs between a controller and a chip: how many words were read, each as it was written."""
    draw, controller = random.Random(seed), SdramController(generics)
    words: dict[int, int] = {}
    wanted: list[Run | None] = [None, None]
    places: deque[int] = deque()
    unread: tuple[deque[int | None], ...] = (deque(), deque())
    compared = 0
    for _ in range(cycles):
        for port in range(2):
            if wanted[port] is None and draw.random() < (0.02, 0.9)[port]:
                page = draw.randrange(8) << generics.column_bits
                column = draw.randrange(0, 2 * generics.run_words, generics.run_words)
                more = draw.randrange(generics.run_words)
                wanted[port] = Run(page + column, more, port == 1 and draw.random() < 0.5)
        word, given = draw.getrandbits(16), chip.data
        port = controller.coming[0]
        if port is not None:
            expected = unread[port].popleft()
            assert expected is None or expected == controller.read_data
            compared += expected is not None
        if controller.write_next:
            words[places.popleft()] = word
        begins, (first, second) = controller.free, wanted
        chip.clock(controller.pins)
        controller.clock(first, second, word, given)
        accepted = first or second
        if begins and accepted is not None:
            run_places = range(accepted.address, accepted.address + accepted.more + 1)
            if accepted.write:
                places.extend(run_places)
            else:
                unread[first is None].extend(words.get(place) for place in run_places)
            wanted[first is None] = None
    return compared


@pytest.mark.parametrize("name", CHIPS)
def test_controller_keeps_the_times_of_every_chip(name: str) -> None:
    """From power-up on, with the unit's own generics."""
    generics, chip = SdramGenerics(), SdramChip(CHIPS[name], MHZ_100)
    assert generics.power_up_refreshes * generics.refresh_clocks * 10 >= POWER_UP_NS
    assert traffic(generics, chip, 32_000) > 1000
    assert chip.refreshes >= 8 + 32_000 // generics.refresh_clocks - generics.power_up_refreshes - 1
    late = generics.run_clocks(generics.run_words, True) + generics.rfc_clocks
    assert generics.refresh_clocks * chip.timing.rows + late <= chip.timing.t_ref / 10


SHORT = SdramGenerics(run_words=4, refresh_clocks=60, power_up_refreshes=3)


@pytest.mark.parametrize("name", ["rcd", "rp", "ras", "rfc", "mrd", "wr"])
def test_a_clock_less_is_refused(name: str) -> None:
    """The chip sees whether a generic is too small; as it is here, it is not."""

    # A row stays open for long enough even if the last word is not waited for; so it takes longer here.
    timing = replace(CHIPS["AS4C16M16SA-7"], t_wr=24)
    generics = replace(SHORT, wr_clocks=3)
    traffic(generics, SdramChip(timing, MHZ_100, 1000), 3000)
    less = replace(generics, **{f"{name}_clocks": getattr(generics, f"{name}_clocks") - 1})
    with pytest.raises(SdramFault, match=f"t_{name} is"):
        traffic(less, SdramChip(timing, MHZ_100, 1000), 3000)


def test_pixels_are_kept_as_the_z_buffer_keeps_them(rng: np.random.Generator) -> None:
    width, height, count = 12, 5, 800
    x, y, value = (rng.integers(0, most, count) for most in (width + 2, height + 1, 1 << 16))
    depth = rng.integers(0, 8, count)
    model = SdramDepthTest(width, height, depth_bits=3, data_bits=16, run_words=4)
    for plane, ground in ((0, 5), (1, 6)):
        model.plane = plane
        model.clear(ground)
        for pixel in zip(x.tolist(), y.tolist(), value.tolist(), depth.tolist(), strict=True):
            model.draw(Pixel(*pixel))
        expected = draw_pixels(x, y, value[:, None], depth, width, height, 3, (ground,))[:, :, 0]
        got = [[model.words[plane, row, column] for column in range(width)] for row in range(height)]
        assert np.array_equal(got, expected)
    assert model.words[0, 0, 0] in (5, *value.tolist()), "the other plane stays"
    places = {model.address(*place) for place in model.words}
    assert len(places) == len(model.words) == 3 * width * height


def test_spans_end_at_a_run_and_where_no_neighbour_follows() -> None:
    model = SdramDepthTest(8, 2, run_words=4)
    pixels = [
        Pixel(x, y, 0, 0) for x, y in [(2, 0), (3, 0), (1, 0), (0, 0), (4, 0), (5, 0), (5, 1), (9, 1), (7, 1)]
    ]
    assert [[pixel.x for pixel in span] for span in model.spans(pixels)] == [[2, 3, 1, 0], [4, 5], [5], [7]]


def test_too_few_refreshes_are_refused() -> None:
    timing = replace(CHIPS["AS4C16M16SA-7"], rows=16, t_ref=16 * 60 * 10 + 300)
    assert traffic(replace(SHORT, row_bits=11), SdramChip(timing, MHZ_100, 1000), 3000) > 100
    with pytest.raises(SdramFault, match="a row was not refreshed"):
        traffic(replace(SHORT, refresh_clocks=64), SdramChip(timing, MHZ_100, 1000), 3000)


def test_a_picture_in_sdram_is_the_one_in_block_ram(rng: np.random.Generator) -> None:
    """Word by word through the z-buffer's model, which keeps what the units write; with a swap."""
    width, height, count, bits = 12, 5, 400, 5
    screen = SdramScreen(width, height, colour_bits=bits)
    memory = SdramDepthTest(width, height, run_words=4)
    other = Screen(width, height, 3, 15, False, bits)
    for plane in (1, 0):
        memory.plane = plane
        memory.clear(0)
    for ground in (0x0A6432, 0xFFC800):
        for one in (screen, other):
            one.clear(ground)
        value = np.array(list(ground.to_bytes(3, "little")))
        memory.clear(int(colour_words(kept_colours(value, HALF_STEP, bits), bits)))
        x, y = (rng.integers(0, most, count) for most in (width + 2, height + 1))
        value, depth = rng.integers(0, 256, (count, 3)), rng.integers(0, 1 << 15, count)
        for one in (screen, other):
            one.draw(x, y, value, depth)
        words = colour_words(kept_colours(value, thresholds(x, y), bits), bits)
        for pixel in zip(x.tolist(), y.tolist(), words.tolist(), depth.tolist(), strict=True):
            memory.draw(Pixel(*pixel))
        got = screen.memory()
        assert {place: got[place] for place in memory.words} == memory.words
        assert [screen.frame_crc(plane) for plane in (0, 1)] == [other.frame_crc(plane) for plane in (0, 1)]
        for one in (screen, other):
            one.swap()
        memory.plane = 1 - memory.plane
    assert got[DEPTH_PLANE].max() == (1 << 16) - 1, "some places were not drawn"


def test_runs_of_scanlines_and_areas() -> None:
    assert line_runs(1, 2, 12, 5, 4) == [Run(1 << 7 | 2 << 4 | x, 3) for x in (0, 4, 8)]
    found = list(area_runs(2, 3, 3, 6, 12, 5, 4))
    places = [run.address + index for run in found for index in range(run.more + 1)]
    assert places == [2 << 7 | y << 4 | x for y in (3, 4) for x in range(3, 9)]
    assert [run.more + 1 for run in found] == [1, 4, 1] * 2
    assert most_line_clocks(640, SdramGenerics()) == 862
