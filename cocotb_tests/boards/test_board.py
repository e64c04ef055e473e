# SPDX-License-Identifier: Apache-2.0
"""The whole board through its two pins: scenes by the host's own code, every plane, RESET, lights."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from typing import Any

import cocotb
import numpy as np
import pytest
from cocotb.task import bridge
from cocotb.triggers import Timer

from cocotb_tests.support.bench import PERIOD_NS, Bench
from cocotb_tests.support.link_stimuli import body_of, good_area
from cocotb_tests.support.pins import PinsTransport
from cocotb_tests.support.sdram import CHIP, at_pins
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import FACTOR_BITS, STATE_REGISTERS, Formats
from quadshade.contract.identity import colour_bits, knows, plane_bytes
from quadshade.contract.protocol import ANSWER_BIT, LinkError, Opcode, pack_payload, phase_step
from quadshade.contract.shade_state import colour_state
from quadshade.golden.board import BoardModel
from quadshade.golden.common.sdram_chip import CHIPS, SdramChip
from quadshade.golden.compiled import draw_fast
from quadshade.golden.link.frame_receiver import Reach
from quadshade.link.frames import Frame, FrameParser, enclosed
from quadshade.link.planes import read_picture
from quadshade.link.session import Session
from quadshade.packing.frame_file import set_up_words
from quadshade.packing.pack import pack_primitives
from quadshade.packing.pack_vertices import pack_vertices
from quadshade.setup.triangle_setup import setup_triangles
from tests.support.golden_stimuli import triangles_of


@dataclass(frozen=True)
class Config:
    """Generics of ``board``; those of the core that are left out have their defaults."""

    num_channels: int = 3
    with_depth: int = 1
    word_width: int = 32
    frac_bits: int = 22
    depth_bits: int = 16
    coord_bits: int = 12
    span_depth: int = 2
    clk_frequency_hz: int = 64_000
    baud: int = 16_000
    fifo_words: int = 512
    screen_width: int = 9
    screen_height: int = 6
    with_shade: int = 0
    with_edge_map: int = 1
    single_port_memory: int = 0
    most_counter_bits: int = 32
    single_buffer: int = 0
    crc_cycles: int = 1
    with_video: int = 0
    buffers: int = 1
    colour_bits: int = 8
    with_packed_read: int = 1
    with_vertices: int = 0
    with_sdram: int = 0
    sdram_refresh_clocks: int = 780

    @property
    def formats(self) -> Formats:
        """Those of the core."""
        names = [name for name in asdict(self) if name in Formats().generics()]
        return Formats(**{name: getattr(self, name) for name in names})

    def model(self) -> BoardModel:
        """The golden model."""
        return BoardModel(
            self.screen_width,
            self.screen_height,
            self.formats,
            self.clk_frequency_hz,
            self.baud,
            self.fifo_words,
            bool(self.with_edge_map),
            bool(self.with_video),
            self.most_counter_bits,
            self.buffers,
            self.colour_bits,
            bool(self.with_packed_read),
            bool(self.with_vertices),
            bool(self.single_buffer),
        )

    @property
    def picture_memory(self) -> tuple[int, int]:
        """Buffers, and bits of a colour."""
        return self.buffers, self.colour_bits

    @property
    def bit_ns(self) -> float:
        """A bit of the line, in the simulation's time."""
        return PERIOD_NS * self.clk_frequency_hz / self.baud


CONFIGS = [
    Config(),
    Config(
        num_channels=1,
        with_depth=0,
        word_width=20,
        frac_bits=10,
        coord_bits=9,
        span_depth=1,
        fifo_words=256,
        with_edge_map=0,
        single_port_memory=1,
        most_counter_bits=16,
        single_buffer=1,
        crc_cycles=4,
        with_packed_read=0,
        # Its phase step is rounded down.
        baud=15_001,
    ),
    # The step is rounded up.
    Config(num_channels=2, with_shade=1, coord_bits=6, with_edge_map=0, baud=15_005),
    Config(coord_bits=6, screen_width=8, with_edge_map=0, with_video=1),
    Config(coord_bits=6, buffers=2, colour_bits=4, with_vertices=1),
    Config(num_channels=1, with_depth=0, coord_bits=6, with_edge_map=0, buffers=2, colour_bits=6),
    Config(
        depth_bits=15,
        coord_bits=8,
        screen_width=128,
        screen_height=2,
        with_edge_map=0,
        buffers=2,
        colour_bits=5,
        with_sdram=1,
        sdram_refresh_clocks=150,
    ),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_board(config: Config) -> None:
    simulate("board", config)


async def begin(dut: Any, test: str) -> tuple[Bench, PinsTransport, BoardModel]:
    """A board after power-up, its line, its model."""
    bench = Bench(dut, Config, test)
    dut.rx.value = 1
    if bench.config.with_sdram:
        cocotb.start_soon(at_pins(bench, SdramChip(CHIPS[CHIP], 100e6, 0)))
    await bench.start()
    return bench, PinsTransport(dut, bench.config.bit_ns), bench.config.model()


def scene_words(bench: Bench, count: int) -> np.ndarray:
    """(m,) uint32: triangles of every kind over each other, in packets."""
    config = bench.config
    triangles = triangles_of(config.formats, bench.rng, count, config.screen_height + 2)
    primitives = setup_triangles(triangles, config.formats)
    if config.with_vertices:
        return pack_vertices(primitives, triangles, config.formats).words
    return pack_primitives(primitives, config.formats).words


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def scenes(dut: Any) -> None:
    bench, line, model = await begin(dut, "scenes")
    drawing, drawn = model.drawing, Counter()

    def host() -> None:
        session = Session(line)
        identity = session.connect()
        wanted = {name: value for name, value in model.identity.items() if name in identity}
        bench.check("what HELLO says", identity, identity | wanted)
        planes = [number for number, size in enumerate(plane_bytes(identity)) if size]
        size = (identity["screen_width"], identity["screen_height"], plane_bytes(identity))
        swaps = knows(identity, Opcode.SWAP)
        bench.check("buffers and colours", (swaps + 1, colour_bits(identity)), bench.config.picture_memory)
        # A triangle is set up from its vertices in thousands of clocks.
        for index, count in enumerate((2, 1) if bench.config.with_vertices else (4, 2)):
            colour = bench.bits(32)
            words = scene_words(bench, count)
            session.clear(colour)
            drawing.clear(colour)
            if bench.config.with_shade:
                registers = bench.rng.integers(0, 1 << FACTOR_BITS, 3).tolist()
                session.state(STATE_REGISTERS, registers)
                for offset, value in enumerate(registers):
                    drawing.state(STATE_REGISTERS + offset, value)
            session.triangles(words)
            drawing.triangles(words.tolist())
            given = set_up_words(words, bench.config.formats, bool(bench.config.with_vertices))
            pixels = draw_fast(given, bench.config.formats)
            drawn.update(pixels=len(pixels.x), primitives=len(np.unique(pixels.packet)))
            if index == 0:
                picture = read_picture(session)
                bench.check("picture", picture.tobytes(), drawing.plane(0).tobytes())
            for plane in planes:
                got = session.ask(Opcode.FRAME_CRC, [{"reserved": 0, "plane": plane}])
                crc = int.from_bytes(got[0], "little")
                bench.check("CRC of a plane", crc, drawing.frame_crc(plane), index, plane)
            reach = Reach(*size, with_packed_read=bool(bench.config.with_packed_read))
            areas = [good_area(bench.draw, reach, 30) for _ in range(4)]
            found = session.ask(Opcode.READ, areas)
            for at, area in enumerate(areas):
                bench.check("bytes of an area", found.get(at), drawing.read(**area), at, area)
            if swaps:
                # What was cleared at power-up, or drawn before the last swap, is there again.
                session.swap()
                drawing.swap()
                bench.check("CRC of the other buffer", session.frame_crc(), drawing.frame_crc(0), index)
        status = session.status()
        for name in ("bad_cobs", "bad_crc", "framing_errors", "overruns", "duplicates", "gaps", "refused"):
            bench.check(name, status[name], 0)
        for name, value in drawn.items():
            bench.check(name, status[name], value)
        bench.check("frames that were sent again", session.statistics["resent"], 0)
        for fields in ({"x": 1, "y": 0, "width": size[0]}, {"x": 0, "y": size[1], "width": 1}):
            area = {**fields, "count": 1, "pixels": 1, "plane": 0}
            with pytest.raises(LinkError, match="bad field"):
                session.ask(Opcode.READ, [area])
            session.connect()

    await bridge(host)()
    bench.check("stop bits that are missing", line.framing_errors, 0)
    bench.finish(at_least=20)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def reset_amid_everything(dut: Any) -> None:
    """RESET amid a packet, amid a read, amid a frame: the next session is as the first one."""
    bench, line, model = await begin(dut, "reset_amid_everything")
    if bench.config.with_sdram:
        # The link is that of the other boards, and sdram_screen's own bench resets it.
        return
    words = scene_words(bench, 3)

    async def raw(opcode: Opcode, number: int, payload: bytes) -> None:
        await line.send(enclosed(body_of(opcode, number, payload)))

    cut = words[: len(words) // 2 + 1].astype("<u4").tobytes()
    width = bench.config.screen_width
    area = {
        "x": 0,
        "y": 0,
        "width": width,
        "count": 3 * width,
        "pixels": 3 * width // bench.config.formats.emitted_channels,
        "plane": 0,
    }
    for index in range(3):
        await raw(Opcode.RESET, 0, bytes(4))
        if index == 0:
            await raw(Opcode.TRIANGLES, 0, cut)
            await raw(Opcode.READ, 1, pack_payload(Opcode.READ, area))
        else:
            await raw(Opcode.READ, 0, pack_payload(Opcode.READ, area))
            await line.send(bytes(1) + bench.draw.randbytes(bench.draw.randrange(1, 9)))

    def host() -> None:
        session = Session(line)
        session.connect()
        session.clear(0)
        if bench.config.with_shade:
            # A reset keeps what an earlier session wrote.
            for address, value in colour_state(bench.config.formats).writes().tolist():
                session.state(address, [value])
        session.triangles(words)
        model.drawing.triangles(words.tolist())
        bench.check("CRC of the picture", session.frame_crc(), model.drawing.frame_crc(0))

    await bridge(host)()
    bench.finish(at_least=1)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def requests_overlap(dut: Any) -> None:
    """Results wait in a row, STATUS comes amid them; then BAUD to rates that round up and down; a break."""
    bench, line, model = await begin(dut, "requests_overlap")
    if bench.config.num_channels > 1:
        # The smallest board is enough: the link is the same.
        return
    parser, own, frames = FrameParser(), FrameParser(), []
    size = (bench.config.screen_width, bench.config.screen_height)
    reach = Reach(*size, plane_bytes(model.identity))
    clear = [pack_payload(Opcode.CLEAR, {"colour": bench.draw.getrandbits(32)}) for _ in range(2)]
    crc = pack_payload(Opcode.FRAME_CRC, {"reserved": 0, "plane": 0})
    area = pack_payload(Opcode.READ, good_area(bench.draw, reach, 12))
    swap = [(Opcode.SWAP, b"")] if bench.config.buffers == 2 else []
    asked = (
        *((Opcode.CLEAR, clear[0]), (Opcode.FRAME_CRC, crc), *swap, (Opcode.CLEAR, clear[1])),
        *((Opcode.FRAME_CRC, crc), *swap, (Opcode.READ, area), (Opcode.STATUS, b"")),
    )
    wanted = []
    for number, (opcode, payload) in enumerate(asked):
        sent = enclosed(body_of(opcode, number, payload))
        wanted += own.feed(model.feed(sent))
        await line.send(sent)
    results = (Opcode.READ_ANSWER, Opcode.FRAME_CRC_ANSWER)
    named = (*results, Opcode.STATUS_ANSWER)
    while sum(frame.opcode in named for frame in frames) < 4 and (data := await line.arrived()):
        frames += parser.feed(data)
    bench.check("STATUS", [frame.opcode for frame in frames].count(Opcode.STATUS_ANSWER), 1)
    got, expected = (
        [(frame.opcode.name, frame.sequence, frame.payload[4:]) for frame in found if frame.opcode in results]
        for found in (frames, wanted)
    )
    bench.check_all("result", got, expected)

    async def ask(opcode: Opcode, payload: bytes = b"") -> None:
        await line.send(enclosed(body_of(opcode, 0, payload)))
        answers: list[Frame] = []
        while not answers and (data := await line.arrived()):
            answers = parser.feed(data)
        bench.check("answer", [frame.opcode for frame in answers], [opcode | ANSWER_BIT], inputs=line.bit_ns)
        # The last stop bit is out, and a little more.
        await Timer(round(2000 * line.bit_ns), "ps")

    clock = bench.config.clk_frequency_hz
    for rate in (13_005, 12_001):
        payload = pack_payload(Opcode.BAUD, {"phase_step": phase_step(rate, clock)})
        await ask(Opcode.BAUD, payload)
        line.bit_ns = PERIOD_NS * clock / rate
        await ask(Opcode.HELLO)
    await line.low(30)
    line.bit_ns = bench.config.bit_ns
    await ask(Opcode.HELLO)
    bench.check("stop bits that are missing", line.framing_errors, 0)
    bench.finish(at_least=9)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def lights(dut: Any) -> None:
    """A light is on for a sixteenth of a second after what it shows; at 64 kHz that is 4001 clocks."""
    bench, line, _ = await begin(dut, "lights")
    if bench.config.num_channels > 1:
        # The smallest boards are enough: lights know of the link alone.
        return
    tick = bench.config.clk_frequency_hz // 16 + 1
    parser, words = FrameParser(), scene_words(bench, 1)

    async def after(data: bytes) -> int:
        """What is lit at one of two moments: at one at least, wherever the sixteenths begin."""
        await line.send(data)
        await Timer(PERIOD_NS * (3 * tick // 4), "ns")
        early = int(dut.led.value)
        await Timer(PERIOD_NS * (3 * tick // 4), "ns")
        return early | int(dut.led.value)

    await bench.edge()
    bench.check("nothing yet", int(dut.led.value), 0)
    bench.check("noise", await after(bytes([0, 1, 2, 3, 4, 5, 6, 0])), 0b0100)
    bench.check("a good frame", await after(enclosed(body_of(Opcode.HELLO, 0, b""))), 0b1001)
    payload = words.astype("<u4").tobytes()
    bench.check("triangles", await after(enclosed(body_of(Opcode.TRIANGLES, 0, payload))), 0b1011)
    bench.check("silence", await after(b""), 0)
    frames = parser.feed(await line.arrived())
    bench.check("answers", [frame.opcode for frame in frames], [Opcode.HELLO_ANSWER, Opcode.ACK])
    bench.finish(at_least=6)
