#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Inject faults into the link's frames and count what is accepted; writes docs/reports/faults.md and .json.

Random frames of all lengths go through a damaged line into the parser. A frame that comes out and was not
sent, or comes out of its order, is wrong. Then sessions send set-up words to a model of the board, faults
both ways: words that are missing, doubled or exchanged are wrong. Exit code 1 if anything is.
"""

from __future__ import annotations

import random
import sys
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path

import click
import numpy as np

from quadshade.contract.protocol import MAX_PAYLOAD, WORD_BYTES, LinkError, Opcode
from quadshade.files.markdown import markdown_table
from quadshade.golden.board import BoardModel
from quadshade.link.faults import FaultInjector
from quadshade.link.frames import Frame, FrameParser
from quadshade.link.session import Session
from quadshade.link.transport import FaultyTransport, MemoryTransport
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "faults.md"
RATES = {1e-4: 1, 1e-3: 10, 1e-2: 40}
"""Faults a byte, and what share of the faults: a low rate needs many bytes for each."""
SESSION_SHARES = {1e-5: 1, 1e-4: 10, 1e-3: 300, 1e-2: 2000}
"""The same for sessions."""
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


@dataclass
class SessionRun:
    """
    Sessions with a model of the board over a damaged line.

    Attributes
    ----------
    rate : float
      Faults a byte, both ways.
    injected, sessions, given_up, words, wrong, resent : int
      Faults; sessions, and those that said that the link is too bad; words that had to arrive, and sessions
      in which others did; frames sent again.
    overhead : float
      Bytes sent by bytes of set-up words.
    """

    rate: float
    injected: int = 0
    sessions: int = 0
    given_up: int = 0
    words: int = 0
    wrong: int = 0
    resent: int = 0
    overhead: float = 0.0


def session_run(rate: float, at_least: int, seed: int, words: int = 20000) -> SessionRun:
    """
    Sessions over a line of a fault rate until enough faults were injected.

    Parameters
    ----------
    rate : float
    at_least : int
      Faults.
    seed : int
    words : int
      Set-up words of one session.

    Returns
    -------
    SessionRun
    """
    run, sent_bytes = SessionRun(rate), 0
    rng = np.random.default_rng([seed, round(rate * 1e6)])
    while run.injected < at_least:
        board = BoardModel(8, 8)
        line = FaultyTransport(MemoryTransport(board.feed), rate, f"{seed} {run.sessions}")
        session = Session(line, retries=200)
        sent = rng.integers(0, 1 << 32, words, dtype=np.uint32)
        run.sessions += 1
        arrived = len(sent)
        try:
            session.connect()
            session.triangles(sent)
            session.flush()
        except LinkError:
            run.given_up += 1
            arrived = len(board.drawing.words)
        run.wrong += board.drawing.words != sent[:arrived].tolist()
        run.words += arrived
        run.injected += line.going.total + line.coming.total
        run.resent += session.statistics["resent"]
        sent_bytes += session.statistics["bytes_sent"]
    run.overhead = round(sent_bytes / max(1, WORD_BYTES * run.words), 3)
    return run


def session_table(runs: list[SessionRun]) -> str:
    """The report's table."""
    header = ("faults a byte", "faults", "sessions", "words", "frames sent again")
    header += ("bytes sent by bytes of words", "said to be too bad", "wrong")
    rows = [
        (
            f"{run.rate:g}",
            f"{run.injected:,}",
            run.sessions,
            f"{run.words:,}",
            f"{run.resent:,}",
            run.overhead,
            run.given_up,
            run.wrong,
        )
        for run in runs
    ]
    return markdown_table(header, rows)


def codec_table(runs: list[CodecRun]) -> str:
    """The report's table."""
    header = ("faults a byte", "faults", "frames", "accepted", "dropped", "wrong")
    rows = [
        (
            f"{run.rate:g}",
            f"{run.injected:,}",
            f"{run.sent:,}",
            f"{run.accepted:,}",
            ", ".join(f"{name} {count:,}" for name, count in run.dropped.items()),
            run.wrong,
        )
        for run in runs
    ]
    return markdown_table(header, rows)


def report_faults(
    output: Path, title: str, command: str, about: str, table: str, runs: list[CodecRun] | list[SessionRun]
) -> bool:
    """Write a report and print its table; true if nothing was wrong."""
    total, wrong = sum(run.injected for run in runs), sum(run.wrong for run in runs)
    body = f"{about}\n\n{table}\n\n**{total:,} faults, {wrong} wrong.**\n"
    head = f"""\
{LICENCE}
# {title}

Written by `make faults` (`{command}`); the wire format is in
[protocol.md](../reference/protocol.md).

"""
    write_report(output, head + body, [asdict(run) for run in runs])
    click.echo(body, nl=False)
    return not wrong


@click.command(help=__doc__)
@click.option("--frames", default=1_020_000, show_default=True, help="Faults into frames; 0 for none.")
@click.option("--sessions", default=12_000, show_default=True, help="Faults into sessions; 0 for none.")
@click.option("--seed", default=1, show_default=True)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(frames: int, sessions: int, seed: int, output: Path) -> None:
    good = True
    if frames:
        shares = sum(RATES.values())
        runs = [codec_run(rate, frames * share // shares, seed) for rate, share in RATES.items()]
        about = f"""\
TRIANGLES frames of 12 to 1024 bytes through a line with faults ({", ".join(runs[0].kinds)})
into the host's parser. *Wrong* is a frame that comes out and is not the one that was sent, or
comes out of order or twice. Sessions: [faults_sessions.md](faults_sessions.md)."""
        command = command_line("link_faults", frames=frames, seed=seed)
        good &= report_faults(output, "Faults on the link", command, about, codec_table(runs), runs)
    if sessions:
        shares = sum(SESSION_SHARES.values())
        ran = [session_run(rate, sessions * part // shares, seed) for rate, part in SESSION_SHARES.items()]
        about = """\
Sessions that send 20,000 set-up words each to the model of the board, faults both ways.
*Wrong* is a session after which the board's words are not those sent, each once and in order."""
        command = command_line("link_faults", sessions=sessions, seed=seed)
        beside = output.with_name(f"{output.stem}_sessions.md")
        good &= report_faults(
            beside, "Faults on the link, whole sessions", command, about, session_table(ran), ran
        )
    if not good:
        sys.exit(1)


if __name__ == "__main__":
    main()
