# SPDX-License-Identifier: Apache-2.0
"""The numbers of ``vertex_unpacker`` against their model: every operation, on corners and at random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import Bench
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.vertex_program import OPERATIONS, SPENT_BITS, WIDTH, ZERO_BITS
from quadshade.golden.link.vertex_alu import GUARD, cut, div, fold, mulf, muli


@dataclass(frozen=True)
class Config:
    """``vertex_alu`` has no generics."""


@pytest.mark.parametrize("config", [Config()], ids=identifier)
def test_vertex_alu(config: Config) -> None:
    simulate("vertex_alu", config)


NAMES = ("add", "sub", "muli", "mulf", "div", "shl", "shr", "get", "take", "ones", "fold", "ldr")


NEAR_SPENT = [
    sign ^ ((1 << bit) - less)
    for bit in (1, 2, 3, *range(SPENT_BITS - 2, SPENT_BITS + 2))
    for less in (0, 1)
    for sign in (0, -1)
]
"""Factors of which as many bits are the same as ``muli`` looks at, one more, one fewer, or nearly all."""


def adds_nothing(shifter: int, steps: int) -> bool:
    """Whether all bits that ``muli`` looks at are the same behind those of so many steps."""
    ones = (1 << SPENT_BITS - 1) - 1
    return shifter >> (2 * steps - 1) & ones in (0, ones)


async def operate(bench: Bench, name: str, operand: int, steps: int, line: int = 0, shifter: int = 0) -> int:
    """
    Load an operation and take its steps, with pauses; ``line`` are the bits that come, first lowest.

    Returns the word that ``st`` would write in the place of this operation. ``shifter`` is the shift register
    before it: in every step ``spent`` says whether what is left of it adds nothing.
    """
    shifts = name in ("shl", "shr")
    dut = bench.dut
    dut.operation.value = OPERATIONS.index(name)
    dut.operand.value = operand % (1 << WIDTH)
    dut.load.value = 1
    await bench.edge()
    stored = cut(int(dut.word.value), WIDTH)
    dut.load.value = 0
    taken = 0
    while steps:
        moves = bench.chance(0.9)
        by_four = shifts and moves and steps >= 4
        dut.step.value = int(moves)
        dut.by_four.value = int(by_four)
        dut.line_bit.value = line & 1
        await bench.edge()
        spent = name == "muli" and adds_nothing(shifter, taken + 1)
        bench.check("spent", bool(dut.spent.value), spent, taken, (name, shifter))
        steps, line, taken = steps - (4 if by_four else moves), line >> moves, taken + moves
    dut.step.value = dut.by_four.value = 0
    return stored


def word(bench: Bench) -> int:
    """Any word, of few bits as often as of many, at either end; half of them are negative."""
    bits = bench.draw.choice((1, 2, ZERO_BITS, ZERO_BITS + 1, WIDTH))
    value = bench.bits(bits) << bench.draw.choice((0, WIDTH - bits))
    return cut(bench.draw.choice((value, ~value)), WIDTH)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def operations(dut: Any) -> None:
    bench = Bench(dut, Config, "operations")
    await bench.start("operation", "load", "operand", "step", "by_four", "line_bit", reset=False)
    for index in range(160):
        for name in NAMES:
            before, operand, shifter = word(bench), word(bench), word(bench)
            if name == "muli" and index < len(NEAR_SPENT):
                shifter = NEAR_SPENT[index]
            count = bench.draw.choice({"muli": (16, 18, 20, 22), "mulf": (36,)}.get(name, (1, 2, 7, 15)))
            line, steps = bench.draw.getrandbits(16), count
            wanted = before, shifter
            if name == "add":
                steps, wanted = 0, (cut(before + operand, WIDTH), shifter)
            elif name == "sub":
                steps, wanted = 0, (cut(before - operand, WIDTH), shifter)
            elif name == "muli":
                steps, wanted = count // 2, (muli(before, operand, shifter, count), None)
            elif name == "mulf":
                steps, wanted = count // 2, (mulf(before, operand, shifter, count), None)
            elif name == "div":
                wanted = div(before, operand, shifter, count)
            elif name == "shl":
                wanted = cut((before << count) % (1 << GUARD), GUARD), shifter
            elif name == "shr":
                wanted = before >> count, shifter
            elif name in ("get", "take"):
                kept = 0 if name == "take" else before << count
                came = sum((line >> index & 1) << count - 1 - index for index in range(count))
                wanted = cut((kept + came) % (1 << GUARD), GUARD), shifter
            elif name == "ones":
                wanted = count, shifter
            elif name == "ldr":
                steps, wanted = 0, (shifter, shifter)
            else:
                steps, wanted = 1, (fold(before), shifter)
            await operate(bench, "ldq", shifter, 0)
            await operate(bench, "ld", before, 0)
            behind_ld = await operate(bench, name, operand, steps, line, shifter)
            bench.check("word behind ld", behind_ld, before, None, before)
            await bench.edge()
            if name in ("add", "sub"):
                # Without a step, and while the next operand may come.
                await operate(bench, "ldq", shifter, 0)
            inputs = (name, count, before, operand, shifter)
            acc = cut(int(dut.acc.value), GUARD)
            bench.check(name, acc, wanted[0], None, inputs)
            bench.check("word", cut(int(dut.word.value), WIDTH), cut(acc, WIDTH), None, inputs)
            bench.check("zero", int(dut.is_zero.value), int(cut(acc, ZERO_BITS) == 0), None, inputs)
            if wanted[1] is not None:
                bench.check("shift register", cut(int(dut.shifter.value), WIDTH), wanted[1], None, inputs)
    bench.finish(at_least=12000)
