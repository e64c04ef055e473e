#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Damage the line to a board in RTL; writes docs/reports/faults_rtl.md and .json.

The board's netlist runs in Verilator behind a pseudo-terminal, one board for all. Pictures are sent and read
back by the host's own sessions over a line with faults, both ways: each has to be the golden model's, or the
host has to say that the link is too bad. Then noise: random bytes at the line's rate cause no answer and draw
nothing, and the next frame is accepted. Last, how much of the line's time is used while triangles stream.
Exit code 1 if anything is wrong.
"""

from __future__ import annotations

import random
import sys
import time
import zlib
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path

import click
import numpy as np

from quadshade.board.endpoints import PtyLine
from quadshade.board.engines import ProgramEngine, start_engine
from quadshade.board.settings import BoardSettings
from quadshade.board.simulated import SimulatedBoard
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import LinkError, Opcode
from quadshade.files.markdown import markdown_table
from quadshade.link.frames import Frame, FrameParser
from quadshade.link.planes import read_picture
from quadshade.link.session import Session
from quadshade.link.transport import FaultyTransport, open_transport
from quadshade.packing.frame_file import FrameFile, line_bytes, pack_frame
from quadshade.scene import load_scene, parse_camera, project
from quadshade.shading import sample
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    command_line,
    output_option,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "faults_rtl.md"
WIDTH, HEIGHT = 40, 30
SHARES = {1e-5: 5, 1e-4: 45, 1e-3: 350, 1e-2: 700}
"""Faults a byte, and what share of the faults: a low rate needs many bytes for each."""

SECONDS = 0.3
"""An answer's time-out: the simulation takes milliseconds."""

RETRIES = 100
SHORT_RATE = 5e-3
"""From this rate on pictures have a few triangles, and the board's CRC is asked for instead of pixels."""

PIECE = 4096
EFFICIENCY_WORDS = 40_000
LEAST_EFFICIENCY = 0.95


def pictures(scenes: tuple[str, ...], seed: int) -> list[FrameFile]:
    """Different pictures: meshes from several sides, on several grounds."""
    draw = random.Random(f"pictures {scenes} {seed}")
    frames = []
    for scene in scenes:
        mesh = load_scene(scene)
        for _ in range(4):
            eye = ",".join(f"{draw.uniform(-1, 1):.3f}" for _ in range(3))
            projected = project(mesh, parse_camera(f"from={eye}", mesh), WIDTH, HEIGHT)
            ground = tuple(draw.randrange(256) for _ in range(3))
            frames.append(pack_frame(sample(projected, "quadratic"), Formats(), ground)[0])
    return frames


@dataclass
class FaultRun:
    """
    Pictures over a damaged line.

    Attributes
    ----------
    rate : float
      Faults a byte, both ways.
    injected, pictures, too_bad, wrong : int
      Faults; pictures that came back right; sessions that ended with the host saying that the link is too
      bad; pictures that came back and were not the golden model's.
    resent, timeouts : int
      Frames sent again; answers that did not come.
    said : dict of int
      What the host said where it gave up.
    kinds : dict of int
      Faults by kind.
    """

    rate: float
    injected: int = 0
    pictures: int = 0
    too_bad: int = 0
    wrong: int = 0
    resent: int = 0
    timeouts: int = 0
    said: dict[str, int] = field(default_factory=dict)
    kinds: dict[str, int] = field(default_factory=dict)


def fault_run(name: str, rate: float, at_least: int, frames: list[FrameFile], seed: int) -> FaultRun:
    """
    Send and read pictures over a line of a fault rate until enough faults were injected.

    Parameters
    ----------
    name : str
      Of the simulated board.
    rate : float
    at_least : int
      Faults.
    frames : list of FrameFile
    seed : int

    Returns
    -------
    FaultRun
    """
    run, said, kinds = FaultRun(rate), Counter(), Counter()
    serial = open_transport(name)
    line = FaultyTransport(serial, rate, f"rtl {rate} {seed}")
    number = 0
    while run.injected < at_least:
        frame = frames[number % len(frames)]
        number += 1
        session = Session(line, answer_seconds=SECONDS, retries=RETRIES)
        try:
            session.connect()
            frame.send(session)
            if rate < SHORT_RATE:
                crc = zlib.crc32(read_picture(session).tobytes())
            else:
                crc = session.frame_crc()
            if crc == frame.crc:
                run.pictures += 1
            else:
                run.wrong += 1
        except LinkError as problem:
            run.too_bad += 1
            said[str(problem)] += 1
        run.injected = line.going.total + line.coming.total
        run.resent += session.statistics["resent"]
        run.timeouts += session.statistics["timeouts"]
    for injector in (line.going, line.coming):
        kinds.update(injector.injected)
    run.said, run.kinds = dict(said), dict(sorted(kinds.items()))
    serial.close()
    return run


@dataclass
class NoiseRun:
    """
    Random bytes.

    Attributes
    ----------
    noise, answers : int
      Bytes sent; bytes that came back meanwhile.
    drawn : int
      Pixels, by the board's counter.
    unchanged, accepted : bool
      The picture has the CRC that it had; the first frame behind the noise was answered.
    dropped : dict of int
      What the board counted.
    """

    noise: int
    answers: int
    drawn: int
    unchanged: bool
    accepted: bool
    dropped: dict[str, int]

    @property
    def good(self) -> bool:
        return not self.answers and not self.drawn and self.unchanged and self.accepted


def noise_run(name: str, frame: FrameFile, count: int, seed: int) -> NoiseRun:
    """
    Send random bytes, 00s among them, and then a good frame.

    Parameters
    ----------
    name : str
    frame : FrameFile
      What is on the screen meanwhile.
    count : int
      Bytes.
    seed : int
    """
    line = open_transport(name)
    session = Session(line, answer_seconds=5.0, retries=3)
    session.connect()
    frame.send(session)
    before = session.frame_crc(), session.status()
    draw, answers = random.Random(f"noise {seed}"), 0
    for _ in range(-(-count // PIECE)):
        noise = draw.randbytes(PIECE)
        # More 00s than chance has, so that many pieces are short enough to be frames.
        line.write(bytes(0 if draw.random() < 0.02 else byte for byte in noise))
        answers += len(line.read(0.0))
    # One frame of the host behind the noise, once: a leading 00 ends what was begun.
    hello, parser, accepted = Frame(Opcode.HELLO, 77), FrameParser(), False
    line.write(hello.encode())
    end = time.monotonic() + 60
    got: list[Frame] = []
    while not got and time.monotonic() < end:
        got = parser.feed(line.read(0.1))
    accepted = [(one.opcode, one.sequence) for one in got] == [(Opcode.HELLO_ANSWER, 77)]
    status = session.status()
    names = ("bad_cobs", "bad_crc", "bad_length", "refused", "duplicates", "gaps", "frames", "framing_errors")
    run = NoiseRun(
        -(-count // PIECE) * PIECE,
        answers,
        status["pixels"] - before[1]["pixels"],
        session.frame_crc() == before[0] == frame.crc,
        accepted,
        {name: status[name] - before[1][name] for name in names},
    )
    line.close()
    return run


def efficiency_run(engine: ProgramEngine, name: str, frames: list[FrameFile]) -> dict[str, float]:
    """Share of the clocks in which a byte is on its way to the board while triangles stream."""
    line = open_transport(name)
    session = Session(line, answer_seconds=20.0)
    session.connect()
    words = np.concatenate([frame.words for frame in frames])
    words = np.tile(words, -(-EFFICIENCY_WORDS // len(words)))
    session.clear(0)
    session.flush()
    pixels, begin = session.status()["pixels"], engine.counters()
    session.triangles(words)
    session.flush()
    end = engine.counters()
    spent = {key: end[key] - begin[key] for key in end}
    drawn = session.status()["pixels"] - pixels
    line.close()
    return {
        "words": len(words),
        "bytes": line_bytes(words),
        "pixels": drawn,
        "clocks": spent["clocks"],
        "sending": spent["sending"],
        "efficiency": round(spent["sending"] / spent["clocks"], 4),
    }


def table(runs: list[FaultRun]) -> str:
    """The report's table."""
    columns = ("rate", "injected", "pictures", "too_bad", "resent", "timeouts", "wrong")
    header = ("faults a byte", "faults", "pictures right", "said to be too bad", "frames sent again")
    rows = [tuple(f"{getattr(run, name):g}" for name in columns) for run in runs]
    return markdown_table((*header, "time-outs", "wrong"), rows)


@click.command(help=__doc__)
@click.option("--faults", default=1100, show_default=True, help="At least so many.")
@click.option("--noise", default=200_000, show_default=True, help="Random bytes.")
@click.option("--seed", default=1, show_default=True)
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(faults: int, noise: int, seed: int, output: Path) -> None:
    settings = BoardSettings(screen_width=WIDTH, screen_height=HEIGHT)
    frames, short = (
        pictures(("sphere:168", "torus:288", "icosphere:2"), seed),
        pictures(("icosphere:0",), seed),
    )
    engine = start_engine("verilator", settings)
    with SimulatedBoard(PtyLine(baud=settings.baud), engine).start() as board:
        shares = sum(SHARES.values())
        runs = [
            fault_run(
                board.name,
                rate,
                -(-faults * share // shares),
                frames if rate < SHORT_RATE else short,
                seed,
            )
            for rate, share in SHARES.items()
        ]
        noisy = noise_run(board.name, frames[0], noise, seed)
        efficiency = efficiency_run(engine, board.name, frames)
    total, wrong = sum(run.injected for run in runs), sum(run.wrong for run in runs)
    kinds = sum((Counter(run.kinds) for run in runs), Counter())
    answered = "answered" if noisy.accepted else "NOT ANSWERED"
    bit_clocks, share = settings.clk_frequency_hz // settings.baud, 100 * efficiency["efficiency"]
    dropped = ", ".join(f"{key} {value}" for key, value in noisy.dropped.items())
    command = command_line("link_faults_rtl", faults=faults, noise=noise, seed=seed)
    text = f"""\
{LICENCE}
# Faults on the line to a board in RTL

Written by `make faults-rtl` (`{command}`).
The netlist of `board` in Verilator, {WIDTH}x{HEIGHT}, behind a pseudo-terminal; one board for all below.
Faults both ways: {", ".join(map(" ".join, sorted((kind, str(n)) for kind, n in kinds.items())))}.

*Wrong* is a picture that the host took and that is not the golden model's. Below {SHORT_RATE:g} faults a byte
pictures have up to 180 triangles and every pixel is read back; above, a few, and FRAME_CRC is compared.

{table(runs)}

**{total} faults, {wrong} wrong pictures.**

## Noise

{noisy.noise} random bytes at the line's rate: {noisy.answers} bytes of answer, {noisy.drawn} pixels drawn,
the picture {"unchanged" if noisy.unchanged else "CHANGED"}; the first frame behind them was {answered}.
The board counted: {dropped}.

## The line's time

{efficiency["bytes"]} bytes of triangles, {efficiency["pixels"]} pixels, {bit_clocks} clocks a bit.
A byte was on its way to the board in {share:.2f} % of {efficiency["clocks"]} clocks, from before the first
byte to the last acknowledgement.
"""
    content = {"runs": [asdict(run) for run in runs], "noise": asdict(noisy), "efficiency": efficiency}
    write_report(output, text, content)
    click.echo(text, nl=False)
    if wrong or not noisy.good or efficiency["efficiency"] < LEAST_EFFICIENCY:
        sys.exit(1)


if __name__ == "__main__":
    main()
