# SPDX-License-Identifier: Apache-2.0
"""Set-up words to packets against the model: fields, channel words, how many beats, and which are cut."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cocotb
import pytest

from cocotb_tests.support.bench import SPEEDS, Bench, StreamSource
from cocotb_tests.support.resets import reset_amid
from cocotb_tests.support.simulation import identifier, simulate
from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.golden.core.setup_loader import load_packets, packet_beats, sent_packets, whole_packets
from tests.support.golden_stimuli import malformed_packet, triangle_words

PACKETS = 40


@dataclass(frozen=True)
class Config(Formats):
    """Generics of the core: the loader's follow from them, and whether it looks at ``setup_last``."""

    with_last: int = 0


CONFIGS = [
    Config(),
    Config(stream_width=64),
    Config(stream_width=128),
    Config(word_width=40, frac_bits=28),
    Config(word_width=40, frac_bits=28, stream_width=128),
    Config(num_channels=2, max_order=0),
    # Depth, of order 1, shares its beats with the last of these channels.
    Config(num_channels=3, max_order=0, stream_width=128),
    Config(num_channels=1, max_order=1, with_depth=0, stream_width=64),
    # A whole edge section in a single beat.
    Config(num_channels=4, max_order=0, subpixel_bits=0, coord_bits=3, stream_width=128),
    Config(with_last=1),
    Config(word_width=40, frac_bits=28, stream_width=64, with_last=1),
    Config(num_channels=4, max_order=0, subpixel_bits=0, coord_bits=3, stream_width=128, with_last=1),
]


@pytest.mark.parametrize("config", CONFIGS, ids=identifier)
def test_setup_loader(config: Config) -> None:
    names = ("num_channels", "max_order", "with_depth", "word_width", "stream_width", "with_last")
    generics = {name: getattr(config, name) for name in names}
    generics["edge_section_bits"] = config.section_bits("edge")
    generics["second_section_bits"] = config.section_bits("second")
    generics["orders_low"] = config.section("edge")["orders"][0]
    simulate("setup_loader", config, generics)


@dataclass
class Expected:
    """A packet as it stands at the loader's ports."""

    fields: dict[str, int]
    beats: int
    edge_data: int
    second_data: int
    words: int


def expected_packets(words: list[int], formats: Formats) -> list[Expected]:
    """Every packet of a stream of set-up words, from the model."""
    layouts = [formats.section("edge"), formats.section("second")]
    width = formats.word_width
    packets = []
    for packet in load_packets(words, formats):
        sections = [
            sum(packet.fields[name] << offset for name, (offset, _) in layout.items()) for layout in layouts
        ]
        flat = [word for channel in packet.words for word in channel]
        bits = sum(word << (index * width) for index, word in enumerate(flat))
        packets.append(Expected(packet.fields, packet.beats, *sections, bits))
    return packets


class Taker:
    """Takes packets as the edge walker does: the words are copied some cycles after the packet was taken."""

    def __init__(self, bench: Bench, packets: list[Expected], throttle: bool) -> None:
        self.bench, self.packets, self.throttle = bench, packets, throttle
        self.taken = 0
        self.pending = 0
        self.copy: Expected | None = None
        self.taken_at: list[int] = []
        self.taking = False

    def drive(self) -> None:
        """Say whether words are still to be copied in this cycle."""
        self.bench.dut.words_pending.value = int(self.pending > 0)

    def sample(self) -> None:
        """Look at the packet, and at the words that are to be copied now."""
        bench, dut = self.bench, self.bench.dut
        if self.copy is not None and self.pending == 0:
            words = int(dut.words.value)
            bench.check("words", words, self.copy.words, self.taken - 1, self.copy.fields)
            self.copy = None
        if self.pending:
            self.pending -= 1
        if self.taking:
            self.check_packet()

    def check_packet(self) -> None:
        """The packet's fields, in the cycle in which it is taken."""
        bench, dut, packet = self.bench, self.bench.dut, self.packets[self.taken]
        got = int(dut.edge_data.value)
        bench.check("edge_data", got, packet.edge_data, self.taken, packet.fields)
        if packet.fields["has_second"]:
            got = int(dut.second_data.value)
            bench.check("second_data", got, packet.second_data, self.taken, packet.fields)
        self.copy = packet
        self.pending = 1 + (bench.draw.choice((0, 0, 1, 5)) if self.throttle else 0)
        self.taken += 1
        self.taken_at.append(bench.cycle)


def beats_of(words: list[int], formats: Formats) -> list[tuple[int]]:
    """Beats of a stream of set-up words."""
    count = formats.beat_words
    rows = [words[at : at + count] for at in range(0, len(words), count)]
    return [(sum(int(word) << (SETUP_WORD_BITS * index) for index, word in enumerate(row)),) for row in rows]


INPUTS = ("setup_valid", "setup_data", "setup_last", "packet_taken", "words_pending")


def stream_of(bench: Bench, packets: list[list[int]]) -> tuple[list[int], list[bool]]:
    """
    Words and ``setup_last`` of a stream of packets.

    With ``with_last`` the first packet and some others break off, not the last one, and some end with it;
    without, it is noise.
    """
    formats, draw = bench.config, bench.draw
    words: list[int] = []
    lasts: list[bool] = []
    for index, packet in enumerate(packets):
        beats = len(packet) // formats.beat_words
        if not formats.with_last:
            lasts += [draw.random() < 0.3 for _ in range(beats)]
        else:
            breaks = index + 1 < len(packets) and (index == 0 or draw.random() < 0.4)
            beats = draw.randrange(1, beats) if breaks else beats
            lasts += [False] * (beats - 1) + [breaks or draw.random() < 0.5]
        words += packet[: beats * formats.beat_words]
    return words, lasts


def triangle_packets(bench: Bench, count: int) -> list[list[int]]:
    """Packets of triangles, each by itself."""
    formats = bench.config
    words, packets = triangle_words(formats, bench.rng, count).tolist(), []
    while words:
        size = packet_beats(words[0], formats) * formats.beat_words
        packets.append(words[:size])
        words = words[size:]
    return packets


async def take(bench: Bench, packets_sent: list[list[int]], source: str, sink: str) -> None:
    """Packets through the loader, every flag in every cycle."""
    dut, formats = bench.dut, bench.config
    words, lasts = stream_of(bench, packets_sent)
    looked_at = lasts if formats.with_last else [False] * len(lasts)
    sent = list(sent_packets(words, looked_at, formats))
    packets = expected_packets(whole_packets(words, looked_at, formats), formats)
    beats = [(*beat, int(last)) for beat, last in zip(beats_of(words, formats), lasts, strict=True)]
    stream = StreamSource(
        dut.setup_valid,
        dut.setup_ready,
        [dut.setup_data, dut.setup_last],
        beats,
        SPEEDS[source](bench.draw),
    )
    wants = SPEEDS[sink](bench.draw)
    taker = Taker(bench, packets, sink == "throttled")
    # By the beats accepted: a packet is whole, or cut.
    ends = {packet.start + packet.beats: packet.whole for packet in sent}
    full = begun = cut = False
    while taker.taken < len(packets) or taker.copy:
        stream.drive()
        taker.drive()
        taker.taking = full and next(wants)
        dut.packet_taken.value = int(taker.taking)
        await bench.edge()
        accepted = len(stream.accepted_at)
        inputs = f"beat {accepted}, full {full}, cut {cut}, pending {taker.pending}"
        bench.check("packet_valid", bool(dut.packet_valid.value), full, taker.taken, inputs)
        bench.check("busy", bool(dut.busy.value), full or begun or cut, taker.taken, inputs)
        bench.check("setup_cut", bool(dut.setup_cut.value), cut, accepted, inputs)
        if full or cut:
            bench.check(
                "setup_ready with a packet waiting or cut", bool(dut.setup_ready.value), False, accepted
            )
        full = full and not taker.taking
        cut = False
        taker.sample()
        if stream.sample(bench.cycle):
            ended = ends.get(len(stream.accepted_at))
            full, cut, begun = ended is True, ended is False, ended is None
    bench.check("beats accepted", len(stream.accepted_at), len(beats))
    if source == sink == "full_speed":
        # A beat a cycle, the cycle in which a packet is taken, and one more while its words are copied where
        # the next packet's words come at once; and the cycle in which one that was cut is dropped.
        one_beat = formats.section_beats("edge") == 1
        pauses = (len(packets) - 1) * (2 if one_beat else 1) + len(sent) - len(packets)
        cycles = stream.accepted_at[-1] - stream.accepted_at[0] + 1
        bench.check("cycles for all beats", cycles, len(beats) + pauses)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source=list(SPEEDS), sink=list(SPEEDS))
async def every_packet(dut: Any, source: str, sink: str) -> None:
    bench = Bench(dut, Config, f"every_packet {source} {sink}")
    await bench.start(*INPUTS)
    packets = triangle_packets(bench, 6)
    packets += [malformed_packet(bench.config, bench.rng) for _ in range(PACKETS)]
    await take(bench, packets, source, sink)
    bench.finish(at_least=2 * PACKETS)


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(sink=list(SPEEDS))
async def resets(dut: Any, sink: str) -> None:
    """Amid a packet, with one waiting, while its words are copied."""
    bench = Bench(dut, Config, f"resets {sink}")
    await bench.start(*INPUTS)

    async def work() -> None:
        packets = [malformed_packet(bench.config, bench.rng) for _ in range(2)]
        await take(bench, packets, "full_speed", sink)

    events = [("setup_valid", "setup_ready"), "packet_valid", "packet_taken", "words_pending"]
    events += ["setup_cut"] * bench.config.with_last
    await reset_amid(bench, work, events, 24, quiet=("busy", "packet_valid", "setup_cut"))
    bench.finish(at_least=200)
