# SPDX-License-Identifier: Apache-2.0
"""The unit that unpacks vertices against its model: real triangles, runs of packed words, and nonsense."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, fields
from typing import Any

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.golden.link.vertex_unpacker import VertexUnpacker
from quadshade.golden.unpacker_clocks import unpacking_clocks, unpacking_of
from quadshade.packing.pack_vertices import choose_vertices
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.vertex_stimuli import KINDS, Echo, damaged, most_clocks


@dataclass(frozen=True)
class Config:
    """Generics of ``vertex_unpacker``."""

    num_channels: int = 3
    max_order: int = 2
    with_depth: int = 1
    word_width: int = 32
    frac_bits: int = 22
    depth_bits: int = 16
    subpixel_bits: int = 8
    coord_bits: int = 12

    @property
    def formats(self) -> Formats:
        """The formats with these generics."""
        return Formats(**asdict(self))


QUIET = 3000
"""Cycles without a word after which none will come: more than a packet's ratios and products take."""

STREAMS = int(os.environ.get("QUADSHADE_FUZZ") or len(KINDS))

CONFIGS = [
    Config(),
    Config(
        num_channels=1, max_order=1, with_depth=0, depth_bits=1, word_width=24, frac_bits=12, coord_bits=9
    ),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_vertex_unpacker(config: Config) -> None:
    simulate("vertex_unpacker", config)


def strip(bench: Bench, count: int) -> ScreenTriangles:
    """Triangles side by side, small and large, of any orders; some of them neighbours of others."""
    formats, rng = bench.config.formats, bench.rng
    pixel, size = 1 << formats.subpixel_bits, 200
    channels, top = formats.num_channels, 2.0**formats.value_bits - 1
    places = np.rint(rng.uniform(8, size - 8, (count + 2, 2)) * pixel).astype(np.int64)
    places[1::3, 1] = places[::3, 1][: len(places[1::3])]
    corners = np.arange(count)[:, None] + np.arange(3)
    corners[rng.random(count) < 0.3] = rng.integers(0, count + 2, 3)
    colours = rng.uniform(0.2, 0.8, (count + 2, channels)) * top
    of = np.swapaxes(colours[corners], 1, 2)
    middles = (of[:, :, (0, 0, 1)] + of[:, :, (1, 2, 2)]) / 2 + rng.uniform(-0.01, 0.01) * top
    depth = rng.uniform(0, 2.0**formats.depth_bits - 1, count + 2)
    orders = np.minimum(rng.integers(1, 3, (count, 1)).repeat(channels, axis=1), formats.max_order)
    return ScreenTriangles(
        size,
        size,
        places[corners],
        np.concatenate([of, middles], axis=2),
        orders,
        depth[corners] if formats.with_depth else None,
        tuple(f"c{index}" for index in range(channels)),
    )


def packets(bench: Bench, count: int, runs: int = 0) -> tuple[np.ndarray, list[int], VertexUnpacker]:
    """Words, some of them in runs of packed ones; the set-up words that come; the model after them."""
    formats = bench.config.formats
    chosen = None
    while chosen is None or not chosen.sent.any():
        triangles = strip(bench, count)
        primitives = setup_triangles(triangles, formats, limit=None)
        if len(primitives) <= runs:
            continue
        # Those are never sent as vertices.
        primitives.undefined[bench.draw.sample(range(len(primitives)), runs)] = True
        chosen = choose_vertices(primitives, triangles, formats, 0.25)
    ends = np.cumsum([bench.draw.randint(1, 4) for _ in range(len(chosen.sent))])
    words = chosen.words(np.array([bench.bits(32) | 1 for _ in range(ends[-1])], np.uint32), ends)
    model = VertexUnpacker(formats)
    model.plain = Echo()
    expected = [int(word) for _, _, given in model.packets(words) for word in given]
    return words, expected, model


async def unpack(
    bench: Bench, words: np.ndarray, expected: list[int], source: str, sink: str, what: object = None
) -> list[int]:
    """Send words; compare the set-up words that come until none has for a while; in which cycles they do."""
    dut = bench.dut
    offered = StreamSource(
        dut.line_valid,
        dut.line_ready,
        [dut.line_data],
        [(int(word),) for word in words],
        SPEEDS[source](bench.draw),
    )
    taken = StreamSink(bench, dut.setup_valid, dut.setup_ready, [dut.setup_data], SPEEDS[sink](bench.draw))
    echoes: list[int] = []
    quiet, seen, owed, waits = 0, 0, 0, None
    while quiet < QUIET:
        # The other unpacker: a word in, the same out, later; nothing comes of zeros, but it asks for some.
        room = len(echoes) < 2 and bench.draw.random() < 0.7
        dut.packed_ready.value = int(room)
        dut.unpacked_valid.value = int(bool(echoes))
        dut.unpacked_data.value = echoes[0] if echoes else 0
        dut.unpacking.value = int(bool(echoes) or owed > 0)
        offered.drive()
        taken.drive()
        await bench.edge()
        if echoes and dut.unpacked_ready.value:
            echoes.pop(0)
        word = int(dut.packed_data.value) if dut.packed_valid.value else None
        if waits is not None:
            bench.check("packed word that waits", word, waits, None, what)
        waits = None if room else word
        if room and word is not None:
            echoes += [word] if word else []
            owed = bench.draw.randrange(4) if word else max(owed - 1, 0)
        offered.sample(bench.cycle)
        taken.sample(bench.cycle)
        for (word,), wanted in zip(taken.words[seen:], expected[seen:], strict=False):
            bench.check("set-up word", word, wanted, seen, what)
        quiet = quiet + 1 if offered.empty and len(taken.words) == seen else 0
        seen = len(taken.words)
    bench.check("number of set-up words", seen, len(expected), None, what)
    return taken.taken_at


INPUTS = (
    *("line_valid", "line_data", "packed_ready", "unpacking"),
    *("unpacked_valid", "unpacked_data", "setup_ready"),
)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(speed=list(SPEEDS))
async def triangles(dut: Any, speed: str) -> None:
    bench = Bench(dut, Config, f"triangles {speed}")
    await bench.start(*INPUTS)
    words, expected, _ = packets(bench, 4, runs=1)
    await unpack(bench, words, expected, speed, speed)
    bench.check("busy at the end", int(dut.busy.value), 0)
    bench.finish(at_least=30)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def clocks(dut: Any) -> None:
    """As many cycles as the model counts, where nothing waits."""
    bench = Bench(dut, Config, "clocks")
    await bench.start(*INPUTS)
    words, expected, _ = packets(bench, 3)
    counted = unpacking_clocks(unpacking_of(words, bench.config.formats, True))
    begin = bench.cycle
    taken_at = await unpack(bench, words, expected, "full_speed", "full_speed")
    dut._log.info("%d cycles for %d words, %d set-up words", counted, len(words), len(expected))
    # Behind the last set-up word the program comes back to its start, and the line's zeros are skipped.
    behind = begin + counted - taken_at[-1]
    bench.check("cycles behind the last set-up word", 0 < behind < 40, True, None, behind)
    bench.finish(at_least=2)


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def junk(dut: Any) -> None:
    """Words that mean nothing end each packet all the same, with the model's words; zeros do with none."""
    bench = Bench(dut, Config, "junk")
    await bench.start(*INPUTS)
    parameters, _, _ = packets(bench, 1)
    for kind in range(3):
        count = 14
        words = np.array([bench.bits(32) for _ in range(count)], np.uint32)
        words &= np.array((0xFFFFFFFF, 0x11111111, 0)[kind], np.uint32)
        # Packets of triangles: parameters and runs would be rare guesses.
        words = np.concatenate([parameters[:2], words])
        model = VertexUnpacker(bench.config.formats)
        model.plain = Echo()
        given = [int(word) for _, _, some in model.packets(words) for word in some]
        await unpack(bench, words, given + model.begun, "full_speed", "full_speed", kind)
        bench.check("busy", bool(dut.busy.value), model.within)
        await bench.reset()
    words, expected, _ = packets(bench, 2)
    await unpack(bench, words, expected, "full_speed", "full_speed", "after junk")
    bench.finish(at_least=10)


@cocotb.test(timeout_time=2 * STREAMS, timeout_unit="ms")
async def damage(dut: Any) -> None:
    """
    Packets that are damaged, spliced, cut short or random: the model's words, in no more clocks than it says.

    ``QUADSHADE_FUZZ`` streams, one of each kind in turn; `make fuzz-vertices` has many.
    """
    bench = Bench(dut, Config, "damage")
    await bench.start(*INPUTS)
    for index in range(STREAMS):
        kind = KINDS[index % len(KINDS)]
        whole, _, _ = packets(bench, 3, runs=index % 2)
        words = damaged(bench.draw, kind, whole, 12 if STREAMS <= len(KINDS) else 60)
        model = VertexUnpacker(bench.config.formats)
        model.plain = Echo()
        given = [int(word) for _, _, some in model.packets(words) for word in some]
        begin = bench.cycle
        sped = "full_speed" if index % 3 else "throttled"
        taken_at = await unpack(bench, words, given + model.begun, sped, sped, (index, kind))
        bench.check("busy", bool(dut.busy.value), model.within, None, (index, kind))
        if kind == "zeros":
            bench.check("words of zeros", len(taken_at), 0)
        elif sped == "full_speed" and taken_at:
            # The one that is begun may take as long as any.
            most = model.clocks + most_clocks(bench.config.formats) + 2 * len(given)
            bench.check("cycles at most", taken_at[-1] - begin <= most, True, None, (index, kind))
        await bench.reset()
    bench.finish(at_least=STREAMS)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def resets(dut: Any) -> None:
    """A reset at every stage of a packet: parameters and all that was begun are forgotten."""
    bench = Bench(dut, Config, "resets")
    await bench.start(*INPUTS)
    words, expected, _ = packets(bench, 2, runs=1)

    async def work() -> None:
        await unpack(bench, words, expected, "full_speed", "full_speed")

    events = (("line_valid", "line_ready"), ("setup_valid", "setup_ready"), ("packed_valid", "packed_ready"))
    await reset_amid(bench, work, events, rounds=3, quiet=("setup_valid",))
    bench.finish(at_least=10)


def test_configurations_are_the_units_generics() -> None:
    assert {field.name for field in fields(Config)} < set(Formats().generics())
