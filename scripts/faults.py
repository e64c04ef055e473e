#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Inject faults into the link's frames and count what is accepted; writes docs/reports/faults.md and .json.

Random frames of all lengths go through a damaged line into the parser. A frame that comes out and was not
sent, or comes out of its order, is wrong: exit code 1 if there is one.
"""

from __future__ import annotations

import json
import random
import sys
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path

import click

from quadshade.link.faults import FaultInjector
from quadshade.link.frames import Frame, FrameParser
from quadshade.link.protocol import MAX_PAYLOAD, WORD_BYTES, Opcode

REPORT = Path(__file__).resolve().parents[1] / "docs" / "reports" / "faults.md"
RATES = {1e-4: 1, 1e-3: 10, 1e-2: 40}
"""Faults a byte, and what share of the faults: a low rate needs many bytes for each."""
BATCH = 64


@dataclass
class CodecRun:
    """
    Frames through one damaged line.

    Attributes
    ----------
    rate : float
      Faults a byte.
    injected, sent, accepted, wrong : int
      Faults; frames sent; frames that came out; of these, those that were not the next one of those sent.
    kinds, dropped : dict of int
      Faults by kind; pieces between 00s that were no frames, by reason.
    """

    rate: float
    injected: int = 0
    sent: int = 0
    accepted: int = 0
    wrong: int = 0
    kinds: dict[str, int] = field(default_factory=dict)
    dropped: dict[str, int] = field(default_factory=dict)


def random_frame(draw: random.Random, number: int) -> Frame:
    """A batch of triangles, short ones more often, some of them full of zeros; numbered in its first word."""
    most = draw.choice((16, 64, 256, MAX_PAYLOAD))
    words = draw.randint(1, most // WORD_BYTES)
    content = (
        bytes((words - 1) * WORD_BYTES) if draw.random() < 0.2 else draw.randbytes((words - 1) * WORD_BYTES)
    )
    return Frame(Opcode.TRIANGLES, number % 256, number.to_bytes(WORD_BYTES, "little") + content)


def codec_run(rate: float, at_least: int, seed: int) -> CodecRun:
    """
    Send frames through a line of a fault rate until enough faults were injected.

    Parameters
    ----------
    rate : float
    at_least : int
      Faults.
    seed : int

    Returns
    -------
    CodecRun
    """
    draw = random.Random(f"codec {rate} {seed}")
    injector, parser, run = FaultInjector(rate, f"codec {rate} {seed}"), FrameParser(), CodecRun(rate)
    oldest, sent = 0, {}
    while injector.total < at_least:
        for _ in range(BATCH):
            frame = random_frame(draw, run.sent)
            sent[run.sent] = frame
            run.sent += 1
            for got in parser.feed(injector.damage(frame.encode())):
                number = int.from_bytes(got.payload[:WORD_BYTES], "little")
                run.accepted += 1
                # A doubled 00 or a lost one changes nothing, so a frame may come once at most, in its order.
                if sent.get(number) != got or number < oldest:
                    run.wrong += 1
                else:
                    oldest = number + 1
        sent = {number: frame for number, frame in sent.items() if number >= run.sent - BATCH}
    run.injected, run.kinds = injector.total, dict(sorted(injector.injected.items()))
    run.dropped = dict(sorted(Counter(parser.dropped).items()))
    return run


def codec_table(runs: list[CodecRun]) -> list[str]:
    """Rows of the report."""
    head = [
        "| faults a byte | faults | frames | accepted | dropped | wrong |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    rows = [
        f"| {run.rate:g} | {run.injected:,} | {run.sent:,} | {run.accepted:,} "
        f"| {', '.join(f'{name} {count:,}' for name, count in run.dropped.items())} | {run.wrong} |"
        for run in runs
    ]
    return [*head, *rows]


@click.command(help=__doc__)
@click.option("--faults", default=1_020_000, show_default=True, help="Faults at all rates together.")
@click.option("--seed", default=1, show_default=True)
def main(faults: int, seed: int) -> None:
    shares = sum(RATES.values())
    runs = [codec_run(rate, faults * share // shares, seed) for rate, share in RATES.items()]
    total, wrong = sum(run.injected for run in runs), sum(run.wrong for run in runs)
    kinds = ", ".join(runs[0].kinds)
    lines = [
        "<!-- SPDX-License-Identifier: Apache-2.0 -->",
        "# Faults on the link",
        "",
        f"Written by `make faults` (`scripts/faults.py --faults {faults} --seed {seed}`); the wire format is",
        "in [protocol.md](../protocol.md).",
        "",
        f"TRIANGLES frames of 12 to 1024 bytes through a line with faults ({kinds}) into the host's parser.",
        "*Wrong* is a frame that comes out and is not the one that was sent, or comes out of order or twice.",
        "",
        *codec_table(runs),
        "",
        f"**{total:,} faults, {wrong} wrong frames.**",
    ]
    REPORT.write_text("\n".join(lines) + "\n")
    REPORT.with_suffix(".json").write_text(
        json.dumps({"codec": [asdict(run) for run in runs]}, indent=2) + "\n"
    )
    click.echo("\n".join(lines[8:]))
    if wrong:
        sys.exit(1)


if __name__ == "__main__":
    main()
