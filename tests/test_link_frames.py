# SPDX-License-Identifier: Apache-2.0
"""The link's frames: every opcode there and back, noise, faults, and what the definition hash covers."""

from __future__ import annotations

import zlib

import pytest
from cobs import cobs
from hypothesis import given
from hypothesis import strategies as st

from quadshade.contract import formats, protocol
from quadshade.contract.protocol import (
    MAX_BODY,
    MAX_PAYLOAD,
    PAYLOADS,
    WORD_BYTES,
    LinkError,
    Opcode,
    pack_payload,
    phase_step,
    unpack_payload,
)
from quadshade.errors import QuadshadeError
from quadshade.link.faults import FaultInjector
from quadshade.link.frames import MAX_ENCODED, Frame, FrameParser, enclosed, sealed


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    """Any frame that there can be."""
    opcode = draw(st.sampled_from(list(PAYLOADS)))
    payload = PAYLOADS[opcode]
    values = {
        name: draw(st.integers(0, (1 << 8 * size) - 1))
        for name, size, _ in payload.fields
        if name != "padding"
    }
    step = 1 if opcode is Opcode.READ_ANSWER else WORD_BYTES
    tail = draw(st.integers(payload.least // step, min(payload.most, 300) // step)) * step
    filler = draw(st.sampled_from([b"\0", b"\1", b"\xff", bytes(range(256))]))
    return Frame(opcode, draw(st.integers(0, 255)), pack_payload(opcode, values, (filler * 300)[:tail]))


@given(st.lists(frames(), max_size=4), st.data())
def test_frames_arrive_in_pieces(sent: list[Frame], data: st.DataObject) -> None:
    wire = b"".join(frame.encode() for frame in sent)
    parser, got, at = FrameParser(), [], 0
    while at < len(wire):
        size = data.draw(st.integers(1, len(wire)))
        got += parser.feed(wire[at : at + size])
        at += size
    assert got == sent
    assert not parser.dropped


@given(frames())
def test_fields_there_and_back(frame: Frame) -> None:
    values, tail = unpack_payload(frame.opcode, frame.payload)
    assert pack_payload(frame.opcode, values, tail) == frame.payload


@given(st.lists(st.binary(max_size=1500), max_size=5), frames())
def test_noise_is_no_frame_and_a_good_one_follows(noise: list[bytes], frame: Frame) -> None:
    parser = FrameParser()
    for piece in noise:
        # 2**-32 of a chance that noise is a frame.
        assert parser.feed(piece) == []
    assert parser.feed(frame.encode()) == [frame]


@given(frames(), st.data())
def test_one_damaged_byte_is_no_other_frame(frame: Frame, data: st.DataObject) -> None:
    wire = bytearray(frame.encode())
    wire[data.draw(st.integers(1, len(wire) - 2))] ^= data.draw(st.integers(1, 255))
    assert FrameParser().feed(bytes(wire)) == []


@given(st.binary(max_size=2 * MAX_BODY))
def test_any_body_is_a_frame_or_is_counted(content: bytes) -> None:
    parser = FrameParser()
    got = parser.feed(enclosed(sealed(content)))
    assert len(got) + parser.dropped.total() == 1


def test_wire_format_is_the_documented_one() -> None:
    # By hand: the CRC is zlib's, little endian, over header and payload; the rest is COBS between 00s.
    body = bytes([0x03, 0x07, 4, 0, 0x78, 0x56, 0x34, 0x12])
    body += zlib.crc32(body).to_bytes(4, "little")
    payload = pack_payload(Opcode.RESET, {"session": 0x12345678})
    assert Frame(Opcode.RESET, 7, payload).encode() == b"\0" + cobs.encode(body) + b"\0"


def test_a_piece_of_any_length_is_bounded() -> None:
    parser = FrameParser()
    for _ in range(100):
        assert parser.feed(b"\1" * MAX_ENCODED) == []
        assert len(parser._partial) <= MAX_ENCODED
    frame = Frame(Opcode.HELLO, 0)
    assert parser.feed(frame.encode()) == [frame]
    assert parser.dropped == {"bad_length": 1}


def test_longest_frame_fits() -> None:
    frame = Frame(Opcode.TRIANGLES, 255, b"\1" * MAX_PAYLOAD)
    assert len(frame.body()) == MAX_BODY
    assert len(frame.encode()) == MAX_ENCODED + 2
    assert FrameParser().feed(frame.encode()) == [frame]
    with pytest.raises(LinkError, match="1020 bytes"):
        Frame(Opcode.TRIANGLES, 0, b"\1" * (MAX_PAYLOAD + WORD_BYTES)).encode()


@pytest.mark.parametrize(
    ("opcode", "content", "reason"),
    [
        (0x12, b"", "bad_length"),
        (0x12, b"123", "bad_length"),
        (0x01, b"1234", "bad_length"),
        (0x13, b"12345678", "bad_length"),
        (0x00, b"", "refused"),
        (0x7F, b"1234", "refused"),
    ],
)
def test_right_crc_and_wrong_content(opcode: int, content: bytes, reason: str) -> None:
    parser = FrameParser()
    body = sealed(bytes([opcode, 1]) + len(content).to_bytes(2, "little") + content)
    assert parser.feed(enclosed(body)) == []
    assert parser.dropped == {reason: 1}


def test_length_field_must_be_the_length() -> None:
    parser = FrameParser()
    assert parser.feed(enclosed(sealed(bytes([0x12, 1, 8, 0]) + b"1234"))) == []
    assert parser.dropped == {"bad_length": 1}


def test_values_out_of_range_are_named() -> None:
    with pytest.raises(LinkError, match="CLEAR: colour is 4294967296; give 0 to 4294967295"):
        pack_payload(Opcode.CLEAR, {"colour": 1 << 32})
    with pytest.raises(LinkError, match="sequence number 256"):
        Frame(Opcode.HELLO, 256).encode()
    with pytest.raises(LinkError, match="ACK of 3 bytes"):
        unpack_payload(Opcode.ACK, b"123")
    with pytest.raises(LinkError, match="3000001 baud"):
        phase_step(3_000_001, 12_000_000)
    with pytest.raises(QuadshadeError, match="fault rate 2"):
        FaultInjector(2)


def test_phase_steps_are_near_enough() -> None:
    for clock in (12_000_000, 25_000_000, 60_000_000, 100_000_000):
        for baud in (115_200, 921_600, 1_000_000, 2_000_000, 3_000_000):
            got = phase_step(baud, clock) * clock / (1 << protocol.PHASE_BITS)
            assert abs(got / baud - 1) < 1e-4


def test_definition_hash_covers_formats_and_protocol(monkeypatch: pytest.MonkeyPatch) -> None:
    hashes = {protocol.definition_hash()}
    for module, name, value in (
        (formats, "DIFFERENCES", formats.DIFFERENCES[::-1]),
        (formats, "SECTIONS", (("edge", formats.SECTIONS[0][1][1:]), formats.SECTIONS[1])),
        (formats, "DERIVED", (("column_bits", "coord_bits + 2", ""), *formats.DERIVED[1:])),
        (protocol, "COUNTERS", protocol.COUNTERS[1:]),
        (protocol, "MAX_BODY", 512),
        (protocol, "PAYLOADS", {**PAYLOADS, Opcode.HELLO: PAYLOADS[Opcode.BAUD]}),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            hashes.add(protocol.definition_hash())
    assert len(hashes) == 7
    prose = tuple((name, bits, "other words") for name, bits, _ in protocol.COUNTERS)
    monkeypatch.setattr(protocol, "COUNTERS", prose)
    assert protocol.definition_hash() in hashes


def test_what_is_sequenced_and_what_answers() -> None:
    sequenced = {"CLEAR", "STATE", "TRIANGLES", "READ", "FRAME_CRC", "SWAP"}
    assert {opcode.name for opcode in Opcode if opcode.is_sequenced} == sequenced
    others = {"HELLO", "STATUS", "RESET", "BAUD"}
    assert {opcode.name for opcode in Opcode if not opcode.is_answer} == sequenced | others
    assert len(Opcode) == 18 and protocol.MAGIC.to_bytes(4, "little") == b"QSHD"


def test_every_fault_happens() -> None:
    injector = FaultInjector(0.01, "every")
    data = bytes(range(256)) * 400
    assert injector.damage(data) != data
    assert set(injector.injected) == set(FaultInjector.KINDS)
    assert 800 < injector.total < 1200
    assert FaultInjector(0).damage(data) == data


def test_faults_are_the_same_for_a_seed_in_any_pieces(seed: int) -> None:
    data = bytes(range(256)) * 20
    whole, pieces = FaultInjector(0.05, seed), FaultInjector(0.05, seed)
    assert whole.damage(data) == b"".join(pieces.damage(data[at : at + 7]) for at in range(0, len(data), 7))
    assert whole.injected == pieces.injected
