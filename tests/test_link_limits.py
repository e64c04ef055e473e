# SPDX-License-Identifier: Apache-2.0
"""The frames with which the link's benches stand at every limit: none is left out, each has two sides."""

from __future__ import annotations

import pytest

from cocotb_tests.support.link_limits import REQUESTS, Case, limits
from cocotb_tests.support.simulation import ROOT
from quadshade.contract.protocol import (
    COUNTERS,
    MAX_BODY,
    PAYLOADS,
    WORD_BYTES,
    Opcode,
    Reason,
    is_length_of,
    pack_payload,
    unpack_payload,
)
from quadshade.golden.link.frame_receiver import FrameReceiver, Reach, Verdict

REACHES = (Reach(with_swap=True), Reach(64, 32, (1, 0, 2, 2)), Reach(9, 6, (4, 2, 0, 0)))


def verdict_of(case: Case, reach: Reach, overflow: bool = False) -> Verdict:
    """What a receiver that expects number 5 says."""
    receiver = FrameReceiver(reach)
    receiver.expected = 5
    return receiver.judge(case.body(5), overflow=overflow)


@pytest.mark.parametrize("reach", REACHES, ids=str)
def test_every_refusal_has_a_frame(reach: Reach) -> None:
    verdicts = [verdict_of(case, reach) for case in limits(reach)]
    verdicts += [verdict_of(case, reach, overflow=True) for case in limits(reach) if case.name == "number"]
    assert {verdict.reason for verdict in verdicts} == set(Reason)
    drawn = {"primitives", "pixels", "clocks_busy", "clocks_idle"}
    # Those two are of the line: the benches damage it.
    counted = {name for name, _, _ in COUNTERS} - drawn - {"bad_cobs", "framing_errors"}
    assert {verdict.counter for verdict in verdicts} - {""} == counted


def accepts(opcode: Opcode, fields: dict[str, int], tail: bytes, reach: Reach) -> bool:
    """Whether a frame with these fields is accepted."""
    return not verdict_of(Case("", opcode, pack_payload(opcode, fields, tail)), reach).reason


@pytest.mark.parametrize("reach", REACHES, ids=str)
def test_every_limit_of_a_field_is_sent_from_both_sides(reach: Reach) -> None:
    """Two frames that differ by one in that field alone: one is accepted, and one is not."""
    accepted: dict[tuple, bool] = {}
    limited, sent = set(), set()
    for case in limits(reach):
        plain = case == Case(case.name, case.opcode, case.payload)
        if (
            not plain
            or case.opcode not in REQUESTS
            or not is_length_of(Opcode(case.opcode), len(case.payload))
        ):
            continue
        opcode = Opcode(case.opcode)
        fields, tail = unpack_payload(opcode, case.payload)
        good = accepted[opcode, *fields.values(), tail] = accepts(opcode, fields, tail, reach)
        for name, size, _ in PAYLOADS[opcode].fields if good else ():
            for side, value in (("low", 0), ("high", (1 << 8 * size) - 1)):
                if not accepts(opcode, fields | {name: value}, tail, reach):
                    limited.add((opcode, name, side))
    for (opcode, *values, tail), good in accepted.items():
        for place, (name, _, _) in enumerate(PAYLOADS[opcode].fields):
            above = (opcode, *values[:place], values[place] + 1, *values[place + 1 :], tail)
            if good != accepted.get(above, good):
                sent.add((opcode, name, "high" if good else "low"))
    assert limited - sent == set()
    assert {name for _, name, _ in limited} == {"x", "y", "width", "count", "pixels", "plane", "phase_step"}


def test_every_length_is_sent_from_both_sides() -> None:
    sent = {(case.opcode, len(case.payload)) for case in limits(Reach()) if case.said is None}
    for opcode in REQUESTS:
        low, high = PAYLOADS[opcode].lengths
        wanted = {low, high, *range(low + 1, low + WORD_BYTES), high + 1, high + WORD_BYTES}
        wanted |= {low - WORD_BYTES} if low >= WORD_BYTES else set()
        assert wanted <= {length for code, length in sent if code == opcode}, opcode
    sizes = {len(case.body(0)) for case in limits(Reach())}
    assert {4, 5, 6, 7, 8, MAX_BODY, MAX_BODY + 1} <= sizes


def test_every_opcode_is_sent() -> None:
    assert {case.opcode for case in limits(Reach())} == set(range(256))


@pytest.mark.parametrize("unit", ["frame_receiver", "command_decoder"])
def test_the_benches_send_them(unit: str) -> None:
    text = (ROOT / f"cocotb_tests/link/test_{unit}.py").read_text()
    assert "link_limits import limits" in text
    # No frame alone has no room: one bench says so at a port, the other one fills the FIFO.
    assert {"frame_receiver": "Reason.NO_ROOM not in", "command_decoder": "Reason.NO_ROOM)"}[unit] in text
