# SPDX-License-Identifier: Apache-2.0
"""Commands from the FIFO's words: the right requests, in order, none before the core is idle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSource
from cocotb_tests.support.command_recorder import READ_FIELDS, CommandRecorder
from cocotb_tests.support.link_stimuli import MOST_WORDS, good_payload
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.protocol import Opcode
from quadshade.golden.link.command_executor import begin, execute
from quadshade.golden.link.frame_fifo import FrameFifo
from quadshade.golden.link.frame_receiver import Reach

PORTS = {
    "setup": ("data",),
    "state": ("address", "data"),
    "clear": ("colour",),
    "swap": (),
    "read": READ_FIELDS,
    "frame_crc": ("plane",),
}


@dataclass(frozen=True)
class Config:
    """Generics of ``command_executor``."""

    with_swap: int = 0

    @property
    def commands(self) -> list[Opcode]:
        """What it is given."""
        return [op for op in Opcode if op.is_sequenced and (op is not Opcode.SWAP or self.with_swap)]


@pytest.mark.parametrize("config", [Config(), Config(with_swap=1)], ids=identifier)
def test_command_executor(config: Config) -> None:
    simulate("command_executor", config)


INPUTS = ("core_idle", "fifo_valid", "fifo_data", "frame_crc_done", "frame_crc_value", "result_taken")


async def start(dut: Any, test: str) -> Bench:
    """The bench after reset."""
    bench = Bench(dut, Config, test)
    await bench.start(*INPUTS, *(f"{name}_ready" for name in PORTS))
    return bench


async def run(bench: Bench, source: str, sink: str, opcodes: list[Opcode], most_words: int) -> None:
    """Commands through the unit, with the core and all else that they ask, against the model."""
    dut, draw, recorder, fifo = bench.dut, bench.draw, CommandRecorder(), FrameFifo(1 << 20)
    words, results = [], []
    for index, opcode in enumerate(opcodes):
        payload = good_payload(draw, opcode, most_words, Reach(with_packed_read=True))
        frame = bytes([opcode, index]) + len(payload).to_bytes(2, "little") + payload
        words += [int.from_bytes(frame[at : at + 4], "little") for at in range(0, len(frame), 4)]
        results += [(opcode, index)] if opcode in (Opcode.READ, Opcode.FRAME_CRC) else []
    for word in words:
        fifo.write(word)
    fifo.commit()
    while fifo.committed:
        execute(begin(fifo), fifo, recorder)
    going = StreamSource(
        dut.fifo_valid, dut.fifo_ready, [dut.fifo_data], [(word,) for word in words], SPEEDS[source](draw)
    )
    speeds = {name: SPEEDS[sink](draw) for name in PORTS}
    end = bench.cycle + 20000
    busy, crc_in, crc, got, answered, was_idle = 0, 0, 0, [], [], True
    while (len(got) < len(recorder.done) or len(answered) < len(results)) and bench.cycle < end:
        going.drive()
        ready = {name: next(go) for name, go in speeds.items()}
        for name, value in ready.items():
            getattr(dut, f"{name}_ready").value = int(value)
        taken = bench.chance(0.2)
        dut.result_taken.value = int(taken)
        idle = busy == 0
        dut.core_idle.value = int(idle)
        dut.frame_crc_done.value = int(crc_in == 1)
        dut.frame_crc_value.value = crc if crc_in == 1 else draw.getrandbits(32)
        await bench.edge()
        going.sample(bench.cycle)
        busy, crc_in = max(0, busy - 1), max(0, crc_in - 1)
        valid = [name for name in PORTS if getattr(dut, f"{name}_valid").value]
        bench.check("one request at a time", len(valid) <= 1, True, len(got), valid)
        for name in valid:
            # The core has been idle since the last set-up word was drawn.
            bench.check("core is idle", name in ("setup",) or was_idle or idle, True, len(got), name)
            if ready[name]:
                got.append((name, *(int(getattr(dut, f"{name}_{port}").value) for port in PORTS[name])))
                busy = draw.randrange(30) if name in ("setup", "clear") else 0
                if name == "frame_crc":
                    crc_in, crc = draw.randrange(1, 20), draw.getrandbits(32)
        if dut.result_due.value and taken:
            code = Opcode(int(dut.command.value))
            answered.append((code, int(dut.number.value)))
            if code is Opcode.FRAME_CRC:
                bench.check("crc", (int(dut.crc.value), crc_in), (crc, 0), len(got))
        was_idle = idle
    for _ in range(10):
        await bench.edge()
        valid = [name for name in PORTS if getattr(dut, f"{name}_valid").value]
        bench.check("nothing more is asked for", valid, [])
    bench.check_all("request", got, recorder.done)
    bench.check_all("result", answered, results)
    bench.check("all was taken", going.empty, True)


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def commands(dut: Any, source: str, sink: str) -> None:
    bench = await start(dut, f"commands {source} {sink}")
    await run(bench, source, sink, bench.draw.choices(bench.config.commands, k=80), MOST_WORDS)
    bench.finish(at_least=500)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def long_commands(dut: Any) -> None:
    """As many words as a frame has, and numbers of words of every bit."""
    bench = await start(dut, "long_commands")
    await run(bench, "full_speed", "full_speed", [Opcode.TRIANGLES, Opcode.STATE] * 5, 253)
    bench.finish(at_least=500)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def resets(dut: Any) -> None:
    bench = await start(dut, "resets")

    async def work() -> None:
        commands = bench.config.commands
        await run(bench, "throttled", "throttled", bench.draw.sample(commands, len(commands)), 3)

    asked = [name for name in PORTS if name != "swap" or bench.config.with_swap]
    taken = [(f"{name}_valid", f"{name}_ready") for name in ("fifo", *asked)]
    quiet = [*(f"{name}_valid" for name in PORTS), "result_due"]
    await reset_amid(bench, work, [*taken, "frame_crc_done", ("result_due", "result_taken")], quiet=quiet)
    bench.finish(at_least=500)
