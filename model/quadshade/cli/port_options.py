# SPDX-License-Identifier: Apache-2.0
"""What commands that talk to a board share: the port and its options, the open board, the report."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from quadshade.errors import QuadshadeError

if TYPE_CHECKING:
    from quadshade.board import Board, BoardSettings


BOARD_ONLY = ("baud", "faults", "timeout", "trace", "pack_error")
"""Options that mean nothing where an engine draws."""


class Faults(click.ParamType):
    """A rate and a seed, as (rate, seed)."""

    name = "RATE[,SEED]"

    def convert(
        self, value: object, param: click.Parameter | None, context: click.Context | None
    ) -> tuple[float, int]:
        """Faults a byte and the seed, or a usage error that says how to write them."""
        if isinstance(value, tuple):
            return value
        rate, _, seed = str(value).partition(",")
        try:
            numbers = float(rate), int(seed or 1)
        except ValueError:
            numbers = (-1.0, 1)
        if not 0 <= numbers[0] <= 1:
            self.fail(f"{value!r} is no rate of faults; write for example 1e-3 or 1e-3,7")
        return numbers


class Seconds(click.FloatRange):
    """A range of seconds, in which nan is not."""

    name = "seconds"

    def convert(self, value: object, param: click.Parameter | None, context: click.Context | None) -> float:
        """The number, or a usage error."""
        seconds = super().convert(value, param, context)
        if math.isnan(seconds):
            self.fail(f"{value!r} is not a number of seconds", param, context)
        return seconds


@dataclass(frozen=True)
class PortChoice:
    """What the options say; every attribute is the option of its name."""

    port: str | None
    baud: int | None
    faults: tuple[float, int] | None
    timeout: float | None
    trace: bool
    verify: bool = True

    @property
    def is_simulated(self) -> bool:
        """Whether the board is one's own simulation."""
        return self.port == "sim"


def port_options(own_verify: bool = True, help_text: str = "The board") -> Callable:
    """
    Add the options to a command; its function gets them as one ``port_choice``.

    Parameters
    ----------
    own_verify : bool
      False for a command that has its own ``--verify``.
    help_text : str
      Beginning of the help of ``--port``.
    """
    verify = click.option(
        "--verify/--no-verify",
        default=True,
        show_default=True,
        help="What the board shows must have the CRC that the golden model predicts.",
    )
    options = (
        click.option(
            "--port",
            envvar="QUADSHADE_PORT",
            metavar="PORT",
            help=f"{help_text}: auto (every serial port is asked), sim (a simulated one is started), "
            "/dev/ttyUSB0, socket://host:port.  [env: QUADSHADE_PORT]",
        ),
        click.option(
            "--baud",
            type=click.IntRange(1, 1 << 26),
            envvar="QUADSHADE_BAUD",
            help="Another rate than 1000000, agreed on with the board.  [env: QUADSHADE_BAUD]",
        ),
        click.option(
            "--faults",
            type=Faults(),
            help="Damage the line on purpose: faults a byte, both ways, and a seed, e.g. 1e-3,7.",
        ),
        click.option(
            "--timeout",
            type=Seconds(0.001, 1e6),
            metavar="SECONDS",
            envvar="QUADSHADE_TIMEOUT",
            help="How long an answer may take; a board simulated elsewhere may need more.  [default: 0.5; "
            "of --port sim, what its engine needs]",
        ),
        click.option("--trace", is_flag=True, help="Show every frame on stderr."),
        *([verify] if own_verify else []),
    )
    names = {field.name for field in fields(PortChoice)}

    def decorate(command: Callable) -> Callable:
        @functools.wraps(command)
        def with_choice(*arguments: Any, **given: Any) -> Any:
            own = {name: value for name, value in given.items() if name not in names}
            known = {name: value for name, value in given.items() if name in names}
            known.setdefault("verify", click.get_current_context().params.get("verify", True))
            return command(*arguments, port_choice=PortChoice(**known), **own)

        for option in reversed(options):
            with_choice = option(with_choice)
        return with_choice

    return decorate


def is_given(name: str) -> bool:
    """Whether an option stands on the command line."""
    return click.get_current_context().get_parameter_source(name) is ParameterSource.COMMANDLINE


def on_board(choice: PortChoice, engine: str | None) -> bool:
    """
    Whether a board is to draw, not an engine.

    Raises
    ------
    QuadshadeError
      Both are asked for, or what only a board has without one.
    """
    if not choice.port:
        for name in BOARD_ONLY:
            if is_given(name):
                raise QuadshadeError(f"--{name.replace('_', '-')} is for a board", "give --port as well")
    if not choice.port or choice.is_simulated:
        return bool(choice.port)
    if engine is not None and is_given("engine"):
        if is_given("port"):
            raise QuadshadeError("--engine is given, and --port: a board draws", "give one of them")
        return False
    return True


def notice(text: str) -> None:
    """Say what is not as asked."""
    click.echo(f"quadshade: notice: {text}", err=True)


def say_trace(text: str) -> None:
    """A frame, on stderr."""
    click.echo(text, err=True)


@contextmanager
def opened(
    choice: PortChoice, settings: BoardSettings | None = None, engine: str | None = None
) -> Iterator[Board]:
    """
    The board of the options, with a progress bar where stderr is a terminal, and statistics at the end.

    Parameters
    ----------
    choice : PortChoice
    settings : BoardSettings, optional
      Of a simulated board.
    engine : str, optional
      What simulates it.
    """
    from quadshade.board import Board

    with _progress_bar() as progress:
        board = Board(
            choice.port,
            choice.baud,
            settings=settings,
            engine=engine,
            faults=choice.faults,
            answer_seconds=choice.timeout,
            trace=say_trace if choice.trace else None,
            notice=notice,
            progress=progress,
        )
        with board:
            try:
                yield board
            finally:
                figures = board.statistics
    click.echo(f"quadshade: {statistics_text(figures)}", err=True)


def statistics_text(figures: dict[str, float]) -> str:
    """What :attr:`Board.statistics` says, in a line."""
    seconds = max(figures["seconds"], 1e-9)
    rates = f"{figures['seconds']:.2f} s"
    if figures["triangles"]:
        rates += f", {figures['triangles'] / seconds:.0f} triangles/s"
    return (
        f"{figures['bytes_sent']} bytes sent, {figures['bytes_received']} received, "
        f"{figures['sent']} frames, {figures['resent']} resent, {figures['timeouts']} time-outs, "
        f"{figures['reconnects']} reconnects, {figures['redraws']} redraws; {rates}"
    )


@contextmanager
def _progress_bar() -> Iterator[Callable[[str, float, float, int], None] | None]:
    """A bar with triangles or pixels, and bytes, a second; nothing where stderr is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[rate]}"))
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        tasks: dict[str, Any] = {}
        begun: dict[str, int] = {}
        units = {"drawing": "triangles/s", "reading": "pixels/s"}

        def show(what: str, done: float, total: float, sent: int) -> None:
            if what not in tasks or total != bar.tasks[tasks[what]].total:
                tasks[what] = bar.add_task(what, total=total, rate="")
                begun[what] = sent
            task = bar.tasks[tasks[what]]
            elapsed = max(task.elapsed or 0, 1e-3)
            rate = f"{done / elapsed:,.0f} {units[what]}, {(sent - begun[what]) / elapsed:,.0f} bytes/s"
            bar.update(tasks[what], completed=done, rate=rate)

        yield show
