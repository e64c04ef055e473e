# SPDX-License-Identifier: Apache-2.0
"""What surrounds the board's end of the link in its tests: the line, and units that do what commands ask."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from itertools import repeat

from cocotb_tests.support.bench import SPEEDS, Bench
from cocotb_tests.support.command_recorder import READ_FIELDS, CommandRecorder
from quadshade.contract.protocol import PACKED, Opcode, unpack_payload
from quadshade.link.frames import Frame, FrameParser

CLOCKS = ("clocks_busy", "clocks_idle")
BLOCK_CYCLES = 350
"""An answer's first block of up to 254 bytes without a zero is gathered before any of it is sent."""

GATES = ("setup", "state", "clear", "swap", "read", "frame_crc")
INPUTS = (
    *("line_valid", "line_data", "line_error", "break_seen", "send_ready", "send_busy", "core_idle"),
    *("pixel_done", "primitive_done", "read_data_valid", "read_data", "frame_crc_done", "frame_crc_value"),
    "read_bytes",
    *(f"{name}_ready" for name in GATES),
)


def pattern(**fields: int) -> bytes:
    """What a READ finds: bytes that follow from its fields, fewer than asked for if they may be packed."""
    seed = repr(sorted(fields.items())).encode()
    count = fields["count"] if fields["plane"] < PACKED else 1 + fields["count"] // 3
    return bytes(zlib.crc32(seed + bytes([index % 256])) & 0xFF for index in range(count))


class Effects(CommandRecorder):
    """A board whose pixels and CRCs tell one command from another."""

    def read(self, **fields: int) -> bytes:
        super().read(**fields)
        return pattern(**fields)

    def frame_crc(self, plane: int) -> int:
        super().frame_crc(plane)
        return zlib.crc32(bytes([plane, sum(entry[0] == "frame_crc" for entry in self.done) % 256]))


class Board:
    """
    The unit with all that is attached to it, cycle by cycle.

    Attributes
    ----------
    door : bool
      While it is set no answer is taken from the unit; one that is begun is (``at_door`` if one waits).
    stalled : bool
      While it is set nothing that commands ask for is done.
    idle : bool or None
      What the core says; by what it was given if None.
    line_busy : bool
      What the transmitter says, beside that.
    char_cycles : sequence of int
      In how many cycles after a character the transmitter takes no other one, and is busy.
    clocks : dict of str to int
      Those in which the core said busy, idle, since reset.
    rates : list of (phase_step, bool)
      Every change of rate, and whether the line was quiet.
    lights : list of int
      How often frame_seen and fault_seen were high.
    """

    def __init__(self, bench: Bench, speed: str = "full_speed", char_cycles: Sequence[int] = (0,)) -> None:
        self.bench, self.dut, draw = bench, bench.dut, bench.draw
        self.effects, self.parser, self.answers = Effects(), FrameParser(), []
        self.go = {name: SPEEDS[speed](draw) for name in (*GATES, "data")}
        self.send_go: Iterator[bool] = SPEEDS[speed](draw)
        self.busy, self.reading, self.crc = 0, b"", None
        self.quiet = 0
        self.door = self.at_door = self.within = self.stalled = False
        self.idle: bool | None = None
        self.char_cycles, self.char, self.line_busy = char_cycles, 0, False
        self.clocks = dict.fromkeys(CLOCKS, 0)
        self.rates: list[tuple[int, bool]] = []
        self.rate = bench.config.default_phase_step
        self.lights = [0, 0]

    async def start(self) -> None:
        """Reset, with everything ready."""
        await self.bench.start(*INPUTS)

    async def step(self, byte: int | None = None, error: bool = False) -> None:
        """One cycle, with a byte from the line or none."""
        dut, draw = self.dut, self.bench.draw
        dut.line_valid.value, dut.line_error.value = int(byte is not None), int(error)
        if byte is not None:
            dut.line_data.value = byte
        ready = {name: next(go) and not self.stalled for name, go in self.go.items()}
        # The bytes of a read are taken before the next one begins.
        ready["read"] = ready["read"] and not self.reading
        ready["frame_crc"] = ready["frame_crc"] and not self.reading
        ready["data"] = ready["data"] or self.stalled
        for name in GATES:
            getattr(dut, f"{name}_ready").value = int(ready[name])
        idle = self.busy == 0 if self.idle is None else self.idle
        dut.core_idle.value = int(idle)
        sends = next(self.send_go) and not self.char and not (self.door and not self.within)
        dut.send_ready.value, dut.send_busy.value = int(sends), int(self.line_busy or self.char > 0)
        offers = bool(self.reading) and ready["data"]
        dut.read_data_valid.value = int(offers)
        dut.read_data.value = self.reading[0] if offers else 0
        dut.frame_crc_done.value = int(self.crc is not None)
        dut.frame_crc_value.value = self.crc or 0
        self.crc = None
        await self.bench.edge()
        self.busy = max(0, self.busy - 1)
        self.char = max(0, self.char - 1)
        self.quiet += 1
        self.clocks[CLOCKS[idle]] += 1
        self.lights[0] += int(dut.frame_seen.value)
        self.lights[1] += int(dut.fault_seen.value)
        if int(dut.phase_step.value) != self.rate:
            self.rate = int(dut.phase_step.value)
            self.rates.append((self.rate, not self.within and not self.char))
        if dut.core_reset.value:
            self.effects.reset()
            self.reading, self.within = b"", False
            self.clocks = dict.fromkeys(CLOCKS, 0)
        if offers and dut.read_data_ready.value:
            self.reading = self.reading[1:]
        valid = bool(dut.send_valid.value)
        self.at_door = valid and not self.within
        if valid and sends:
            byte = int(dut.send_data.value)
            self.answers += self.parser.feed(bytes([byte]))
            self.within = not self.within or byte != 0
            self.at_door = False
            self.char = draw.choice(self.char_cycles)
            self.quiet = 0
        self.requests(ready)

    def requests(self, ready: dict[str, bool]) -> None:
        """What the unit asks for in this cycle."""
        dut, effects = self.dut, self.effects
        if dut.setup_valid.value and ready["setup"]:
            effects.triangles([int(dut.setup_data.value)])
            self.busy = self.bench.draw.randrange(1, 12)
        elif dut.state_valid.value and ready["state"]:
            effects.state(int(dut.state_address.value), int(dut.state_data.value))
        elif dut.clear_valid.value and ready["clear"]:
            effects.clear(int(dut.clear_colour.value))
            self.busy = 20
        elif dut.swap_valid.value and ready["swap"]:
            effects.swap()
        elif dut.read_valid.value and ready["read"]:
            fields = {name: int(getattr(dut, f"read_{name}").value) for name in READ_FIELDS}
            fields["plane"] += PACKED * fields.pop("packed")
            self.reading = effects.read(**fields)
            dut.read_bytes.value = len(self.reading)
        elif dut.frame_crc_valid.value and ready["frame_crc"]:
            self.crc = effects.frame_crc(int(dut.frame_crc_plane.value))
        else:
            return
        self.quiet = 0

    async def send(self, line: bytes, gaps: Iterator[bool] | None = None) -> None:
        """Bytes of the line."""
        for byte in line:
            for go in gaps or repeat(True):
                await self.step(byte if go else None)
                if go:
                    break

    async def wait(self, cycles: int) -> None:
        """Some cycles without anything from the line."""
        for _ in range(cycles):
            await self.step()

    async def quiet_for(self, cycles: int) -> None:
        """Until nothing has happened for so long."""
        self.quiet, most = 0, 20000
        while self.quiet < cycles and most:
            most -= 1
            await self.step()
        self.bench.check("the unit comes to rest", most > 0, True)

    async def let_one_out(self, most: int = 30000) -> None:
        """The answer that waits at the door, to its end."""
        self.door = False
        while not self.within and most:
            most -= 1
            await self.step()
        self.door = True
        while (self.within or self.char) and most:
            most -= 1
            await self.step()

    async def settle(self) -> list[Frame]:
        """Wait until nothing happens any more; the answers since the last time."""
        await self.quiet_for(BLOCK_CYCLES)
        answers, self.answers = self.answers, []
        return answers


def told(answers: list[Frame]) -> list[tuple]:
    """Answers without what depends on time: room, clocks, and ACKs that say nothing new."""
    found: list[tuple] = []
    for frame in answers:
        fields, data = unpack_payload(frame.opcode, frame.payload)
        for name in ("free", *CLOCKS):
            fields.pop(name, None)
        entry = (frame.opcode.name, frame.sequence, tuple(fields.items()), data)
        if frame.opcode is not Opcode.ACK or not found or found[-1] != entry:
            found.append(entry)
    return found
