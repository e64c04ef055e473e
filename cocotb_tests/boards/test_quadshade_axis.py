# SPDX-License-Identifier: Apache-2.0
"""The core behind AXI, with the streams and the master of cocotbext-axi as an independent other side."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge, with_timeout
from cocotbext.axi import (
    AxiLiteBus,
    AxiLiteMaster,
    AxiResp,
    AxiStreamBus,
    AxiStreamFrame,
    AxiStreamSink,
    AxiStreamSource,
)

from cocotb_tests.support.bench import PERIOD_NS, SPEEDS, UNKNOWN, Bench
from cocotb_tests.support.core_run import stimulus
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.axis import GENERICS_FIRST, REGISTERS, REGISTERS_FIRST, pixel_data_bytes
from quadshade.contract.formats import STATE_REGISTERS, Formats
from quadshade.golden.core.setup_loader import packet_beats
from quadshade.golden.quadshade_axis import QuadshadeAxis
from tests.support.golden_stimuli import triangle_words
from tests.support.shade_stimuli import random_state

RESET_CYCLES = 64 if UNKNOWN else 2
QUIET_CYCLES = 40


@dataclass(frozen=True)
class Config(Formats):
    """Generics of the core."""


CONFIGS = [
    Config(),
    Config(num_channels=2, with_shade=1, coord_bits=7),
    Config(
        num_channels=1, max_order=1, with_depth=0, depth_bits=1, value_bits=4, coord_bits=6, stream_width=64
    ),
    Config(num_channels=4, value_bits=9, frac_bits=18, depth_bits=20, coord_bits=8, stream_width=128),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_quadshade_axis(config: Config) -> None:
    generics = dataclasses.asdict(config) | {"pixel_width": 8 * pixel_data_bytes(config)}
    simulate("quadshade_axis", config, generics)


class Axis:
    """
    The unit between a stream source, a stream sink and a master, and its model.

    The source gives ``tlast`` with the last beat of what it sends, or with ``tlast`` false never.
    """

    def __init__(self, dut: Any, test: str, tlast: bool = True) -> None:
        self.dut = dut
        self.bench = Bench(dut, Config, test)
        self.model = QuadshadeAxis(self.bench.config)
        dut.aresetn.value = 0
        Clock(dut.aclk, PERIOD_NS, "ns").start(start_high=False)
        sides = {"reset_active_level": False}
        self.tlast = tlast
        setup = AxiStreamBus.from_prefix(dut, "s_axis_setup")
        if not tlast:
            dut.s_axis_setup_tlast.value = 0
            del setup.tlast
        self.source = AxiStreamSource(setup, dut.aclk, dut.aresetn, **sides)
        self.sink = AxiStreamSink(
            AxiStreamBus.from_prefix(dut, "m_axis_pixel"), dut.aclk, dut.aresetn, **sides
        )
        self.master = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.aclk, dut.aresetn, **sides)

    async def cycles(self, count: int) -> None:
        for _ in range(count):
            await RisingEdge(self.dut.aclk)

    async def reset(self) -> None:
        self.dut.aresetn.value = 0
        await self.cycles(RESET_CYCLES)
        self.dut.aresetn.value = 1
        self.model.reset()
        await self.cycles(2)

    def pace(self, side: Any, speed: str) -> None:
        """Let a side pause as a speed says."""
        side.set_pause_generator(not on for on in SPEEDS[speed](self.bench.draw))

    async def load(self) -> None:
        """Give the shade unit a random state, through the registers."""
        if self.bench.config.with_shade:
            for address, data in random_state(self.bench.config, self.bench.rng).writes().tolist():
                self.model.write(4 * address, data)
                await self.master.write_dword(4 * address, data)

    async def send(self, words: np.ndarray) -> None:
        """Offer a stream of set-up words."""
        await self.source.send(AxiStreamFrame(words.astype("<u4").tobytes()))

    def cut_frames(self) -> list[np.ndarray]:
        """What :meth:`words` gives in frames of a few packets, some of which break off, not the last one."""
        words, frames, draw = self.words(), [], self.bench.draw
        width = self.bench.config.beat_words
        while len(words):
            size = 0
            for _ in range(draw.randint(1, 3)):
                packet = 0
                if size < len(words):
                    packet = packet_beats(int(words[size]), self.bench.config) * width
                size += packet
            breaks = size < len(words) and draw.random() < 0.6
            kept = draw.randrange(1, size // width) * width if breaks else size
            frames.append(words[:kept])
            words = words[size:]
        return frames

    def words(self) -> np.ndarray:
        """Random triangles, packets of nonsense, and a whole triangle behind them, which ends with tlast."""
        last = triangle_words(self.bench.config, self.bench.rng, 7)
        return np.concatenate([stimulus(self.bench, 7), last])

    async def draw(self, frames: list[np.ndarray] | None = None) -> None:
        """Frames of set-up words, and every pixel compared, with its tuser and tlast."""
        sent = [self.words()] if frames is None else frames
        lasts: list[bool] = []
        for words in sent:
            beats = len(words) // self.bench.config.beat_words
            lasts += [False] * (beats - 1) + [self.tlast]
        expected = self.model.draw(np.concatenate(sent).tolist(), lasts)
        for words in sent:
            await self.send(words)
        for frame in expected:
            got = await with_timeout(self.sink.recv(compact=False), 1, "ms")
            size = len(frame[0])
            width = len(self.dut.m_axis_pixel_tkeep)
            data = bytes(got.tdata)
            beats = [data[at : at + width] for at in range(0, len(data), width)]
            self.bench.check_all("pixel", [beat[:size] for beat in beats], frame, [])
            self.bench.check("zeros above", {beat[size:] for beat in beats}, {bytes(width - size)})
            keep = [1] * size + [0] * (width - size)
            self.bench.check("tkeep", list(got.tkeep), keep * len(frame))
            firsts = [got.tuser[at * width] for at in range(len(beats))]
            self.bench.check("tuser", firsts, [1] + [0] * (len(frame) - 1))
        await self.cycles(QUIET_CYCLES)
        self.bench.check("nothing left over", self.sink.empty(), True)
        self.bench.check("idle", int(self.dut.idle.value), 1)

    async def compare_registers(self) -> None:
        """Every register against the model's, and that there are no others beside them."""
        beside = [20, GENERICS_FIRST - 4, REGISTERS[-1].offset + 4, REGISTERS_FIRST - 4]
        for offset in [*(register.offset for register in REGISTERS), *beside]:
            value, known = self.model.read(REGISTERS_FIRST + offset)
            got = await self.master.read(REGISTERS_FIRST + offset, 4)
            self.bench.check(f"register {offset} is there", got.resp == AxiResp.OKAY, known)
            self.bench.check(f"register {offset}", int.from_bytes(got.data, "little"), value)

    async def compare_counters(self) -> None:
        """The counters alone."""
        for register in REGISTERS[2:5]:
            got = await self.master.read_dword(REGISTERS_FIRST + register.offset)
            self.bench.check(register.name, got, self.model.counters[register.name])


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def pixels(dut: Any, speed: str) -> None:
    axis = Axis(dut, f"pixels {speed}")
    await axis.reset()
    axis.pace(axis.source, speed)
    axis.pace(axis.sink, speed)
    await axis.load()
    await axis.draw()
    await axis.compare_registers()
    await axis.draw()
    axis.bench.finish(at_least=60)


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def cut_packets(dut: Any, speed: str) -> None:
    """A tlast amid a packet: it draws nothing and is counted, and what follows is drawn as without it."""
    axis = Axis(dut, f"cut_packets {speed}")
    await axis.reset()
    axis.pace(axis.source, speed)
    axis.pace(axis.sink, speed)
    await axis.load()
    while axis.model.counters["cut_packets"] < 5:
        await axis.draw(axis.cut_frames())
        await axis.compare_counters()
    axis.bench.finish(at_least=60)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def no_tlast(dut: Any) -> None:
    """Tied low, tlast changes nothing: packets say themselves how long they are."""
    axis = Axis(dut, "no_tlast", tlast=False)
    await axis.reset()
    await axis.load()
    for _ in range(2):
        await axis.draw([axis.words(), axis.words()])
        await axis.compare_counters()
    axis.bench.finish(at_least=60)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def refused_writes(dut: Any) -> None:
    """What is no word of the shade unit is answered with an error, and changes no pixel."""
    axis = Axis(dut, "refused_writes")
    await axis.reset()
    await axis.load()
    top = REGISTERS_FIRST + REGISTERS[2].offset
    for address, data in (
        (REGISTERS_FIRST, b"\1\2\3\4"),
        (top, b"\0\0\0\0"),
        (4 * STATE_REGISTERS, b"\1"),
        (5, b"\7\7"),
    ):
        got = await axis.master.write(address, data)
        axis.bench.check(f"write to {address:#x}", got.resp, AxiResp.SLVERR)
    # The state cannot be read, also not where a register has the same lower bits.
    for address in (4 * STATE_REGISTERS, *(register.offset for register in REGISTERS)):
        got = await axis.master.read(address, 4)
        axis.bench.check(f"{address:#x} is read", (got.resp, bytes(got.data)), (AxiResp.SLVERR, bytes(4)))
    if not axis.bench.config.with_shade:
        got = await axis.master.write(4 * STATE_REGISTERS, b"\1\2\3\4")
        axis.bench.check("a core without shade", got.resp, AxiResp.SLVERR)
    await axis.draw()
    axis.bench.finish(at_least=40)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def state_waits_for_a_drawing(dut: Any) -> None:
    """A write amid a drawing is answered behind its last pixel, and counts for the next one only."""
    axis = Axis(dut, "state_waits_for_a_drawing")
    await axis.reset()
    await axis.load()
    if axis.bench.config.with_shade:
        drawing = cocotb.start_soon(axis.draw())
        while dut.idle.value:
            await axis.cycles(1)
        state = random_state(axis.bench.config, axis.bench.rng).writes().tolist()
        address, data = state[-1]
        await axis.master.write_dword(4 * address, data)
        axis.bench.check("idle when it is answered", int(dut.idle.value), 1)
        await drawing
        axis.model.write(4 * address, data)
    await axis.draw()
    axis.bench.finish(at_least=40)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """A reset amid a drawing: its pixels are gone, and counters and the first pixel begin again."""
    axis = Axis(dut, "resets")
    await axis.reset()
    await axis.load()
    for _ in range(5):
        await axis.send(axis.words())
        await axis.cycles(axis.bench.draw.randint(1, 400))
        dut.aresetn.value = 0
        await axis.cycles(2)
        axis.source.clear()
        await axis.reset()
        axis.sink.clear()
        await axis.compare_counters()
        await axis.draw()
        await axis.compare_counters()
    axis.bench.finish(at_least=60)
