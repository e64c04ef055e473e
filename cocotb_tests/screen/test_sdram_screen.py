# SPDX-License-Identifier: Apache-2.0
"""
The screen in an SDRAM against its model, as the screen in block RAM, with a chip at its pins.

The chip raises where a command comes too early or too late; what is in it in the end is compared, word by
word. With a monitor: the words of 640 x 480 while something is drawn, cleared and read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.screen.test_screen import AREA, INPUTS, Driver, drawn_and_read, overlapping
from cocotb_tests.screen.test_screen_video import TIMING, Monitor
from cocotb_tests.support.bench import PERIOD_NS, SPEEDS, Bench
from cocotb_tests.support.link_stimuli import good_area
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.sdram import CHIP, at_pins, words_of, write_words
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.common.sdram_chip import CHIPS, SdramChip
from quadshade.golden.common.sdram_controller import SdramGenerics
from quadshade.golden.link.frame_receiver import Reach
from quadshade.golden.screen.framebuffer import HALF_STEP, kept_colours
from quadshade.golden.screen.sdram_depth_test import SdramDepthTest
from quadshade.golden.screen.sdram_screen import SdramScreen, colour_words


@dataclass(frozen=True)
class Config:
    """Generics of ``sdram_screen``; a short rest after power-up."""

    width: int = 16
    height: int = 5
    coord_bits: int = 5
    num_channels: int = 3
    colour_bits: int = 5
    depth_bits: int = 15
    with_video: int = 0
    clocks_per_pixel: int = 4
    crc_cycles: int = 1
    row_bits: int = 13
    column_bits: int = 9
    run_words: int = 8
    refresh_clocks: int = 150
    power_up_refreshes: int = 2

    buffers = 2

    @property
    def pixel_ns(self) -> float:
        """A pixel, in the simulation's time."""
        return self.clocks_per_pixel * PERIOD_NS

    def model(self) -> SdramScreen:
        """The golden model."""
        return SdramScreen(self.width, self.height, self.num_channels, self.depth_bits, self.colour_bits)

    def reach(self) -> Reach:
        """What can be read."""
        return Reach(self.width, self.height, (self.num_channels, -(-self.depth_bits // 8), 0, 0))

    def memory(self) -> SdramGenerics:
        """Of the controller."""
        return SdramGenerics(
            row_bits=self.row_bits,
            column_bits=self.column_bits,
            run_words=self.run_words,
            refresh_clocks=self.refresh_clocks,
            power_up_refreshes=self.power_up_refreshes,
        )


CONFIGS = [
    Config(),
    Config(width=12, height=3, num_channels=4, colour_bits=4, depth_bits=8, crc_cycles=4, run_words=4),
]
VIDEO = Config(64, 48, 7, with_video=1, clocks_per_pixel=1, run_words=32, refresh_clocks=400)
LINES = range(42, 56)
"""Of the monitor, that are compared, of 640 x 480; before them the memory is filled."""


@pytest.mark.parametrize("config", [*CONFIGS, VIDEO], ids=identifier)
def test_sdram_screen(config: Config) -> None:
    simulate("sdram_screen", config)


class SdramDriver(Driver):
    """The device under test beside its model, with a chip at its pins."""

    def __init__(self, bench: Bench, speed: str) -> None:
        super().__init__(bench, speed)
        self.chip = SdramChip(CHIPS[CHIP], 100e6, 0)

    async def begin(self) -> None:
        cocotb.start_soon(at_pins(self.bench, self.chip))
        await super().begin()

    def compare(self) -> None:
        """Every word of the memory."""
        config = self.bench.config
        layout = SdramDepthTest(config.width, config.height)
        words = self.model.memory()
        places = [layout.address(*place) for place in np.ndindex(*words.shape)]
        self.bench.check_all("word", words_of(self.chip, config.memory(), places), words.ravel().tolist())


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def pictures(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"pictures {speed}")
    if bench.config == VIDEO or (speed != "full_speed" and not bench.default):
        return
    driver = SdramDriver(bench, speed)
    await drawn_and_read(driver, 9)
    driver.compare()
    bench.check("refreshes came", driver.chip.refreshes > bench.cycle // bench.config.refresh_clocks, True)
    bench.finish(at_least=100)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_ends_a_read(dut: Any) -> None:
    """A read that is reset gives no byte more, and the picture stays."""
    bench = Bench(dut, Config, "reset_ends_a_read")
    if not bench.default:
        return
    driver = SdramDriver(bench, "full_speed")
    reach = bench.config.reach()
    await driver.begin()
    driver.offer([pixel for pixels in list(overlapping(bench))[::8] for pixel in pixels])
    await driver.settle()
    for index in range(12):
        area = good_area(bench.draw, reach, 40)
        await driver.read(area, bench.draw.randrange(area["count"]))
        for _ in range(bench.draw.randrange(20)):
            await driver.cycle()
        dut.read_reset.value = 1
        await driver.cycle()
        dut.read_reset.value = 0
        await driver.cycle()
        while not dut.idle.value:
            bench.check("a byte after the reset", bool(dut.read_data_valid.value), False, index)
            await driver.cycle()
        plane = index % 2
        bench.check("CRC of a plane", await driver.frame_crc(plane), driver.model.frame_crc(plane), index)
    bench.finish(at_least=24)


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """A reset amid pixels, a clear, a read or a CRC: both pictures are black, nothing else is left."""
    bench = Bench(dut, Config, "resets")
    if bench.config == VIDEO:
        return
    await bench.start(*INPUTS)
    chip = SdramChip(CHIPS[CHIP], 100e6, 0)
    watched = cocotb.start_soon(at_pins(bench, chip))
    reach = bench.config.reach()
    batches = list(overlapping(bench))

    async def work() -> None:
        driver = SdramDriver(bench, "throttled")
        driver.chip = chip
        await bench.edge()
        # Pixels that come during the fill are drawn behind it.
        driver.offer(bench.draw.choice(batches))
        await driver.settle()
        area = good_area(bench.draw, reach, 20)
        expected = driver.model.read(**{name: area[name] for name in AREA})
        bench.check("bytes of an area", await driver.read(area), expected, None, area)
        await driver.settle()
        crc = await driver.frame_crc(1)
        bench.check("CRC of a plane", crc, driver.model.frame_crc(1))
        await driver.settle()
        driver.compare()
        await driver.swap()
        await driver.clear(bench.bits(32))
        await driver.settle()
        driver.compare()

    events = (
        ("pixel_valid", "pixel_ready"),
        ("read_valid", "read_ready"),
        "read_data_valid",
        ("clear_valid", "clear_ready"),
        ("swap_valid", "swap_ready"),
    )
    await reset_amid(bench, work, events, 6, quiet=("read_data_valid", "frame_crc_done", "idle"))
    watched.cancel()
    bench.finish(at_least=40)


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def what_is_in_the_other_picture_is_shown(dut: Any) -> None:
    """Whatever is drawn, cleared and read meanwhile, no scanline comes too late."""
    bench = Bench(dut, Config, "what_is_in_the_other_picture_is_shown")
    if bench.config != VIDEO:
        return
    driver, config = SdramDriver(bench, "full_speed"), bench.config
    monitor = Monitor(bench)
    cocotb.start_soon(monitor.watch())
    await driver.begin()
    layout, shape = SdramDepthTest(config.width, config.height), (config.height, config.width)
    any_picture = bench.rng.integers(0, 256, (*shape, config.num_channels))
    picture = kept_colours(any_picture, HALF_STEP, config.colour_bits).astype(np.uint8)
    places = [layout.address(1, *place) for place in np.ndindex(*shape)]
    write_words(
        driver.chip, config.memory(), places, colour_words(picture, config.colour_bits).ravel().tolist()
    )
    begin = LINES[0] // (TIMING.lines // config.height) * (TIMING.lines // config.height)
    bench.check("filled in time", monitor.place() < (begin - 11) * TIMING.all_columns, True, monitor.place())
    await driver.clear(bench.bits(32))
    pixels = list(overlapping(bench))
    dut.swap_valid.value = 1
    while monitor.place() < (LINES.stop + 1) * TIMING.all_columns:
        driver.offer(bench.draw.choice(pixels))
        await driver.settle()
        bench.check("no swap amid a picture", bool(dut.swap_ready.value), False)
        area = good_area(bench.draw, config.reach(), 300)
        expected = driver.model.read(**{name: area[name] for name in AREA})
        bench.check("bytes of an area", await driver.read(area), expected, None, area)
    dut.swap_valid.value = 0
    monitor.compare(picture, LINES.start, LINES.stop)
    driver.model.shown[:] = picture
    await driver.settle()
    driver.compare()
    bench.finish(at_least=len(LINES))
