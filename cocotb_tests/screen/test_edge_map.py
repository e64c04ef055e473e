# SPDX-License-Identifier: Apache-2.0
"""The edge map against its model: frames of all shapes back to back, both variants, every pace."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import cocotb
import numpy as np
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSink, StreamSource, full_speed
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.golden.screen.edge_map import DIAGONAL, EIGHT, edge_map_scalar, edge_pixel

FRAME = ("frame_width", "frame_height", "frame_variant")
INPUTS = ("frame_valid", *FRAME, "pixel_valid", "pixel_normal", "pixel_depth", "edge_ready")
LATENCY = 10
"""Clocks from a pixel's acceptance to its upper left neighbour at the output."""


@dataclass(frozen=True)
class Config:
    """Generics of ``edge_map``."""

    max_width: int = 24
    coord_bits: int = 6
    depth_bits: int = 8


CONFIGS = [Config(), Config(max_width=3, coord_bits=2, depth_bits=16), Config(max_width=64, depth_bits=11)]


class Frame(NamedTuple):
    """Size, variant, and pixels of (nx, ny, nz, depth) in scanline order."""

    width: int
    height: int
    variant: int
    pixels: list[tuple[int, int, int, int]]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_edge_map(config: Config) -> None:
    simulate("edge_map", config)


def frame(bench: Bench, width: int, height: int, smooth: bool = False) -> Frame:
    """Any pixels, corners of the formats often; or smooth with a step, as a G-buffer is."""
    count = width * height
    if smooth:
        pixels = [(128 + p % 3, 130, 250, 20 + p % width + 90 * (p % width > 4)) for p in range(count)]
    else:
        bits = bench.config.depth_bits
        pixels = [(*(bench.bits(8) for _ in range(3)), bench.bits(bits)) for _ in range(count)]
    return Frame(width, height, bench.draw.choice((DIAGONAL, EIGHT)), pixels)


def sharpened(bench: Bench, frame: Frame) -> Frame:
    """
    A frame of which every pixel but the last column's and scanline's stands where its edge just changes.

    Its lower right neighbour, the last one to come, is chosen so: a step less or more in any term is seen.
    """
    width, height, variant, pixels = frame
    bits, pixels = bench.config.depth_bits, list(pixels)
    for y in range(1, height):
        for x in range(1, width):
            rows = [
                [pixels[max(v, 0) * width + max(u, 0)] for u in (x - 2, x - 1, x)] for v in (y - 2, y - 1, y)
            ]
            *others, _ = [pixel for row in rows for pixel in row]
            a, c, middle, f = (others[place] for place in (0, 2, 4, 6))
            # Half a step of the intensity of normals is 255 in their products' sum.
            normals = bench.rng.integers(0, 256, (500, 3))
            rest = sum((2 * v - 255) * (2 * w - 255) for v, w in zip(c[:3], f[:3], strict=True))
            dots = rest + (2 * normals - 255) @ (2 * np.array(a[:3]) - 255)
            normal = normals[np.argmin(np.abs(dots % 510 - 255) + (dots < 0) * 510)].tolist()
            # From the depth that it is compared with, up or down: the edge changes in one direction.
            begin = (middle if variant == EIGHT else a)[3]
            sign = 1 if bench.draw.randrange(1 << bits) > begin else -1
            least = bench.draw.randint(0, ((1 << bits) - 1 - begin) if sign > 0 else begin)
            depths = range(begin + sign * least, (1 << bits) if sign > 0 else -1, sign)

            def jump(depth: int, others: Sequence[Any] = others, normal: list[int] = normal) -> int:
                return edge_pixel([*others, (*normal, depth)], bits, variant)[1]

            first = jump(depths[0])
            change = bisect_right(depths, 0, key=lambda depth: abs(jump(depth) - first))
            at = max(0, min(change, len(depths) - 1) - bench.draw.randint(0, 1))
            pixels[y * width + x] = (*normal, depths[at])
    return frame._replace(pixels=pixels)


def frames(bench: Bench) -> list[Frame]:
    """The narrowest, the widest, single scanlines, the tallest, and some between."""
    widest = bench.config.max_width
    tallest = min(9, 1 << bench.config.coord_bits)
    sizes = [(3, 1), (widest, 3), (3, 3), (widest, 1), (3, 2), (widest, tallest)]
    sizes += [(bench.draw.randint(3, widest), bench.draw.randint(1, tallest)) for _ in range(6)]
    # As many scanlines as can be said.
    sizes.append((3, (2 << bench.config.coord_bits) - 1))
    drawn = [frame(bench, *size, smooth=index % 3 == 0) for index, size in enumerate(sizes)]
    sharp = [frame(bench, widest, tallest) for _ in range(2 * max(1, 12 // widest))]
    variants = (DIAGONAL, EIGHT) * len(sharp)
    return drawn + [
        sharpened(bench, one._replace(variant=chosen)) for one, chosen in zip(sharp, variants, strict=False)
    ]


def words(frame: Frame) -> list[tuple[int, int]]:
    """A frame's pixels as they stand at the ports."""
    return [(x | y << 8 | z << 16, depth) for x, y, z, depth in frame.pixels]


async def draw(
    bench: Bench, asked: list[Frame], source: str, sink: str
) -> tuple[list[StreamSource], StreamSink]:
    """Frames through the unit, every edge pixel compared; the streams of frames and pixels, and what came."""
    dut, begin = bench.dut, bench.cycle
    pixels = [word for frame in asked for word in words(frame)]
    sources = [
        StreamSource(
            dut.frame_valid,
            dut.frame_ready,
            [getattr(dut, name) for name in FRAME],
            [frame[:3] for frame in asked],
            full_speed(bench.draw),
        ),
        StreamSource(
            dut.pixel_valid,
            dut.pixel_ready,
            [dut.pixel_normal, dut.pixel_depth],
            pixels,
            SPEEDS[source](bench.draw),
        ),
    ]
    outputs = [dut.edge_normal, dut.edge_depth, dut.edge_last]
    taker = StreamSink(bench, dut.edge_valid, dut.edge_ready, outputs, SPEEDS[sink](bench.draw))
    expected = []
    for one in asked:
        edges = edge_map_scalar(one.pixels, one.width, one.height, bench.config.depth_bits, one.variant)
        expected += [(*edge, int(index == len(edges) - 1)) for index, edge in enumerate(edges)]
    for stream in (*sources, taker):
        stream.drive()
    checked, quiet = 0, 0
    while quiet < 3 * LATENCY and bench.cycle - begin < 40_000:
        await bench.edge()
        for stream in (*sources, taker):
            stream.sample(bench.cycle)
        if len(taker.words) > checked:
            word = expected[checked] if checked < len(expected) else None
            bench.check("edge pixel", taker.words[checked], word, checked)
            checked += 1
        if checked >= len(expected):
            taker.go, quiet = full_speed(bench.draw), quiet + 1
        for stream in (*sources, taker):
            stream.drive()
    bench.check("number of edge pixels", checked, len(expected))
    return sources, taker


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_frame(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"every_frame {source} {sink}")
    await bench.start(*INPUTS)
    asked = frames(bench)
    sources, taker = await draw(bench, asked, source, sink)
    if source == sink == "full_speed":
        begin = 0
        for index, frame in enumerate(asked):
            times = sources[1].accepted_at[begin : begin + len(frame.pixels)]
            shown = taker.taken_at[begin : begin + len(frame.pixels)]
            for what, some in (("accepted", times), ("shown", shown)):
                bench.check(f"clocks between {what}", {b - a for a, b in pairwise(some)} <= {1}, True, index)
            delay = frame.width + 1 + LATENCY
            bench.check("latency", shown[0] - times[0], delay, index, frame[:3])
            begin += len(frame.pixels)
        starts = sources[0].accepted_at
        spans = [b - a for a, b in pairwise(starts)]
        bench.check("clocks of a frame", spans, [f.width * (f.height + 1) + 2 for f in asked[:-1]])
    bench.finish(at_least=50)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def frames_of_other_sizes_are_refused(dut: Any) -> None:
    bench = Bench(dut, Config, "frames_of_other_sizes_are_refused")
    await bench.start(*INPUTS)
    widest = bench.config.max_width
    most = (2 << bench.config.coord_bits) - 1
    sizes = [(0, 1), (1, 5), (2, 2), (widest + 1, 3), (most, 1), (most, most), (widest, 0), (3, 1)]
    for size in sizes:
        dut.frame_valid.value = 1
        dut.frame_width.value, dut.frame_height.value = size
        await bench.edge()
        dut.frame_valid.value = 0
        await bench.edge()
        bench.check("refused", bool(dut.refused.value), size != (3, 1), None, size)
        bench.check("frame_ready", bool(dut.frame_ready.value), size != (3, 1), None, size)
    bench.finish(at_least=16)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def resets(dut: Any, source: str, sink: str) -> None:
    """Amid a frame's pixels, its repeated scanline and column, and the cycle in which one is refused."""
    bench = Bench(dut, Config, f"resets {source} {sink}")
    await bench.start(*INPUTS)

    async def work() -> None:
        dut.frame_valid.value, dut.frame_width.value = 1, 0
        await bench.edge()
        dut.frame_valid.value = 0
        await bench.edge()
        bench.check("refused", bool(dut.refused.value), True)
        asked = [frame(bench, bench.draw.randint(3, min(bench.config.max_width, 6)), rows) for rows in (2, 1)]
        await draw(bench, asked, source, sink)

    events = ("refused", ("pixel_valid", "pixel_ready"), "edge_valid", ("edge_valid", "edge_last"))
    await reset_amid(bench, work, events, 20, quiet=("edge_valid", "refused", "pixel_ready"))
    bench.finish(at_least=200)
