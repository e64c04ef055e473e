# SPDX-License-Identifier: Apache-2.0
"""The unpacker against its model and the packets themselves: real triangles, and words that mean nothing."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import Formats
from quadshade.contract.packed_format import size_of
from quadshade.contract.triangles import ScreenTriangles
from quadshade.golden.link.word_unpacker import WordUnpacker
from quadshade.packing.pack import pack_primitives
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles


@dataclass(frozen=True)
class Config:
    """Generics of ``word_unpacker``."""

    num_channels: int = 3
    max_order: int = 2
    with_depth: int = 1
    word_width: int = 32
    subpixel_bits: int = 8
    coord_bits: int = 12
    with_shade: int = 0
    num_specular: int = 1

    @property
    def formats(self) -> Formats:
        """The formats with these generics, and a fraction that fits."""
        return Formats(**asdict(self), frac_bits=min(22, self.word_width - 10))


CONFIGS = [
    Config(),
    Config(num_channels=2, with_shade=1),
    Config(num_channels=1, max_order=0, with_depth=0, word_width=20, subpixel_bits=0, coord_bits=5),
    Config(num_channels=8, word_width=40, with_shade=1, num_specular=4, coord_bits=13),
    Config(num_channels=2, max_order=1, word_width=24, subpixel_bits=4, coord_bits=9),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_word_unpacker(config: Config) -> None:
    simulate("word_unpacker", config)


def triangles_of(bench: Bench, count: int) -> ScreenTriangles:
    """Triangles small and large, of any orders; some of them cross the screen's border."""
    formats, rng = bench.config.formats, bench.rng
    size, pixel = 1 << formats.coord_bits, 1 << formats.subpixel_bits
    middle = rng.uniform(0, size, (count, 1, 2))
    spread = rng.choice([3.0, 12.0, size / 3], (count, 1, 1))
    vertices = np.rint((middle + rng.uniform(-1, 1, (count, 3, 2)) * spread) * pixel).astype(np.int64)
    channels = formats.num_channels
    tops = 2.0**formats.value_bits - 1
    samples = rng.uniform(0, tops, (count, channels, 1)) + rng.uniform(-1, 1, (count, channels, 6)) * tops / 9
    return ScreenTriangles(
        size,
        size,
        np.clip(vertices, *formats.guard_band),
        np.clip(samples, 0, tops),
        rng.integers(0, formats.max_order + 1, (count, channels)),
        rng.uniform(0, 2.0**formats.depth_bits - 1, (count, 3)) if formats.with_depth else None,
        tuple(f"c{index}" for index in range(channels)),
    )


async def unpack(
    bench: Bench, words: np.ndarray, expected: list[int], source: str, sink: str, what: object = None
) -> list[int]:
    """Send words; compare the set-up words that come until none has for a while; in which cycles they do."""
    dut = bench.dut
    offered = StreamSource(
        dut.packed_valid,
        dut.packed_ready,
        [dut.packed_data],
        ((int(word),) for word in words),
        SPEEDS[source](bench.draw),
    )
    taken = StreamSink(bench, dut.setup_valid, dut.setup_ready, [dut.setup_data], SPEEDS[sink](bench.draw))
    quiet, seen = 0, 0
    while quiet < 120:
        offered.drive()
        taken.drive()
        await bench.edge()
        offered.sample(bench.cycle)
        taken.sample(bench.cycle)
        for (word,), wanted in zip(taken.words[seen:], expected[seen:], strict=False):
            bench.check("set-up word", word, wanted, seen, what)
        quiet = quiet + 1 if offered.empty and len(taken.words) == seen else 0
        seen = len(taken.words)
    bench.check("number of set-up words", seen, len(expected), None, what)
    return taken.taken_at


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def packets(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"packets {source} {sink}")
    await bench.start("packed_valid", "packed_data", "setup_ready")
    formats = bench.config.formats
    primitives = setup_triangles(triangles_of(bench, 6), formats, limit=None)
    batches = [pack_primitives(primitives, formats, error) for error in (0.25, 0.0)]
    words = np.concatenate([batch.words for batch in batches])
    expected = np.concatenate([pack(batch.primitives, formats) for batch in batches])
    await unpack(bench, words, expected.tolist(), source, sink)
    bench.check("busy at the end", int(dut.busy.value), 0)
    bench.finish(at_least=40)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def junk(dut: Any) -> None:
    """Words that mean nothing end each packet all the same, and after reset the next one is read as ever."""
    bench = Bench(dut, Config, "junk")
    await bench.start("packed_valid", "packed_data", "setup_ready")
    formats = bench.config.formats
    model = WordUnpacker(formats)
    for kind in range(6):
        count = 40
        words = np.array([bench.bits(32) for _ in range(count)], np.uint32)
        words &= np.array((0xFFFFFFFF, 0xFFFFFFFF, 0x11111111, 0x00000F0F)[kind % 4], np.uint32)
        words |= np.array((0, 0xF0F0F0F0)[kind == 5], np.uint32)
        whole = model.feed(words).tolist()
        await unpack(bench, words, whole + model.begun, "full_speed", "throttled")
        bench.check("busy", bool(dut.busy.value), model.within)
        model.reset()
        await bench.reset()
    primitives = setup_triangles(triangles_of(bench, 4), formats, limit=None)
    batch = pack_primitives(primitives, formats)
    expected = pack(batch.primitives, formats).tolist()
    await unpack(bench, batch.words, expected, "full_speed", "full_speed", "after junk")
    bench.finish(at_least=100)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def every_begin_and_a_full_list(dut: Any) -> None:
    """A packet begins at each bit of a word, and one changes a width as often as there are addresses."""
    bench = Bench(dut, Config, "every_begin_and_a_full_list")
    await bench.start("packed_valid", "packed_data", "setup_ready")
    formats = bench.config.formats
    model = WordUnpacker(formats)
    address_bits = size_of("width_address_bits", formats)
    list_bits = (1 + address_bits + size_of("width_bits", formats)) << address_bits
    # The bit behind the first one ends the list of changes; ones are a start and a list of the last address.
    begins = [[(1 << at | bench.bits(32) << at + 2) & 0xFFFFFFFF] for at in range(32)]
    for index, first in enumerate([*begins, [0xFFFFFFFF] * (1 + list_bits // 32)]):
        words = np.array([*first, *(bench.bits(32) for _ in range(4))], np.uint32)
        whole = model.feed(words).tolist()
        await unpack(bench, words, whole + model.begun, "throttled", "full_speed", index)
        bench.check("busy", bool(dut.busy.value), model.within, index)
        model.reset()
        await bench.reset()
    bench.finish(at_least=33)


def packet_of(bench: Bench, changes: list[tuple[int, int]]) -> np.ndarray:
    """(m,) uint32: a packet that changes the widths of addresses, with any bits behind its list."""
    formats = bench.config.formats
    address_bits, width_bits = size_of("width_address_bits", formats), size_of("width_bits", formats)
    bits, place = 1, 1
    for address, width in changes:
        bits |= (1 | address << 1 | width << 1 + address_bits) << place
        place += 1 + address_bits + width_bits
    # The zero that ends the list, and more than any packet has.
    bits |= bench.draw.getrandbits(32 * 70) << place + 1
    count = (place >> 5) + 70
    return np.array([bits >> 32 * at & 0xFFFFFFFF for at in range(count)], np.uint32)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def every_width_is_changed(dut: Any) -> None:
    """A packet changes the width of every address, in any order; another one that of a single address."""
    bench = Bench(dut, Config, "every_width_is_changed")
    await bench.start("packed_valid", "packed_data", "setup_ready")
    formats, draw = bench.config.formats, bench.draw
    addresses = range(1 << size_of("width_address_bits", formats))
    most = 1 << size_of("width_bits", formats)
    for some in (len(addresses), len(addresses), 1):
        changes = [(address, draw.randrange(most)) for address in draw.sample(addresses, some)]
        words = packet_of(bench, changes)
        model = WordUnpacker(formats)
        whole = model.feed(words).tolist()
        await unpack(bench, words, whole + model.begun, "full_speed", "full_speed")
        bench.check("busy", bool(dut.busy.value), model.within)
        await bench.reset()
    bench.finish(at_least=30)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """A reset at every stage of a packet: widths and orders are forgotten, the next packet is whole."""
    bench = Bench(dut, Config, "resets")
    await bench.start("packed_valid", "packed_data", "setup_ready")
    formats = bench.config.formats
    batch = pack_primitives(setup_triangles(triangles_of(bench, 1), formats, limit=None), formats)
    expected = pack(batch.primitives, formats).tolist()

    async def work() -> None:
        await unpack(bench, batch.words, expected, "throttled", "throttled")

    events = (("packed_valid", "packed_ready"), ("setup_valid", "setup_ready"), "busy")
    await reset_amid(bench, work, events, rounds=12, quiet=("setup_valid",))
    bench.finish(at_least=30)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def clocks(dut: Any) -> None:
    """A set-up word takes 32 cycles for its bits and a few for the fields that begin in it."""
    bench = Bench(dut, Config, "clocks")
    await bench.start("packed_valid", "packed_data", "setup_ready")
    formats = bench.config.formats
    batch = pack_primitives(setup_triangles(triangles_of(bench, 6), formats, limit=None), formats)
    begin = bench.cycle
    expected = pack(batch.primitives, formats).tolist()
    taken_at = await unpack(bench, batch.words, expected, "full_speed", "full_speed")
    cycles = (taken_at[-1] - begin) / len(expected)
    dut._log.info(
        "%.1f cycles a set-up word, %.1f a packed word", cycles, cycles * len(expected) / len(batch.words)
    )
    bench.check("about 32 cycles and a few for the fields", 32 <= cycles < 48, True)
    bench.finish(at_least=2)


def test_configurations_are_the_units_generics() -> None:
    assert {field.name for field in fields(Config)} < set(Formats().generics())
