# SPDX-License-Identifier: Apache-2.0
"""Options of commands that talk to a board, and which of them count."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from quadshade.choices import parse_faults, parse_ports, simulated_board
from quadshade.cli.options import Decorator, Parsed, is_given, option
from quadshade.cli.terminal import say_trace
from quadshade.errors import QuadshadeError

if TYPE_CHECKING:
    from quadshade.board.tile_store import TileStore

TITLE = "Engine or board"
BOARD_ONLY = ("baud", "faults", "timeout", "trace", "pack_error")
"""Options that mean nothing where an engine draws."""


class Seconds(click.FloatRange):
    """A range of seconds, in which nan is not."""

    name = "seconds"

    def convert(self, value: Any, param: click.Parameter | None, context: click.Context | None) -> Any:
        """The number, or a usage error."""
        seconds = super().convert(value, param, context)
        if math.isnan(seconds):
            self.fail(f"{value!r} is not a number of seconds", param, context)
        return seconds


def _named(_: click.Context, __: click.Parameter, given: str | tuple[str, ...] | None) -> Any:
    """No port, the one that is given, or all of them; an empty variable of the environment is none."""
    ports = (given,) if isinstance(given, str) else given or ()
    if not all(port.strip() for port in ports):
        raise QuadshadeError("--port is empty", "give sim, auto or a port's name, or leave it out")
    if len(ports) > 1:
        parse_ports(ports)
    return list(ports) if len(ports) > 1 else ports[0] if ports else None


def port_options(help_text: str = "The board", several: bool = False) -> list[Decorator]:
    """
    The port, and what the line is like.

    Parameters
    ----------
    help_text : str
      Beginning of the help of ``--port``.
    several : bool
      Whether several boards may share the work.
    """
    more = " Repeatable: boards share the work; sim:4 is four simulated ones." if several else ""
    return [
        option(
            TITLE,
            "--port",
            envvar="QUADSHADE_PORT",
            metavar="PORT",
            help=f"{help_text}: auto (every serial port is asked), sim (a simulated one is started; "
            "sim:icebreaker has that board's generics), "
            f"/dev/ttyUSB0, socket://host:port.{more}  [env: QUADSHADE_PORT]",
            multiple=several,
            callback=_named,
        ),
        option(
            TITLE,
            "--baud",
            type=click.IntRange(1, 1 << 26),
            envvar="QUADSHADE_BAUD",
            help="Another rate than 1000000, agreed on with the board.  [env: QUADSHADE_BAUD]",
        ),
        option(
            TITLE,
            "--faults",
            type=Parsed("RATE[,SEED]", parse_faults),
            help="Damage the line on purpose: faults a byte, both ways, and a seed, e.g. 1e-3,7.",
        ),
        option(
            TITLE,
            "--timeout",
            type=Seconds(0.001, 1e6),
            metavar="SECONDS",
            envvar="QUADSHADE_TIMEOUT",
            help="How long an answer may take; a board simulated elsewhere may need more.  [default: 0.5; "
            "of --port sim, what its engine needs]",
        ),
        option(TITLE, "--trace", is_flag=True, help="Show every frame on stderr."),
    ]


resume_option = option(
    TITLE,
    "--resume",
    is_flag=True,
    help="Go on with a picture in tiles that was broken off: draw only the tiles that are missing.",
)


def tile_store(output: Path, resume: bool, drawn_by: Any = "a board") -> TileStore | None:
    """
    Where tiles of a picture are kept until it is whole, beside it; without ``--resume`` they are drawn anew.

    Nothing is kept where ``drawn_by``, ports or workers, is None.

    Raises
    ------
    QuadshadeError
      Something else is there, or ``--resume`` where nothing is kept.
    """
    if drawn_by is None:
        if resume:
            raise QuadshadeError("--resume is for a board", "give --port as well")
        return None
    from quadshade.board.tile_store import TileStore

    return TileStore(output.with_name(f".{output.name}.tiles"), is_new=not resume)


def with_board(options: dict[str, Any]) -> dict[str, Any]:
    """
    The options, without a board's where an engine is to draw.

    The environment may name a port and an engine at once: the one that stands on the command line draws.

    Raises
    ------
    QuadshadeError
      An engine and a port on the command line, or what only a board has without one.
    """
    changed = options | {"port": options["port"] or None, "trace": say_trace if options["trace"] else None}
    port = changed["port"]
    if (
        port is not None
        and all(simulated_board(one) is None for one in parse_ports(port))
        and options.get("engine") is not None
        and is_given("engine")
    ):
        if is_given("port"):
            raise QuadshadeError("--engine is given, and --port: a board draws", "give one of them")
        changed["port"] = None
    if changed["port"] is None:
        for name in BOARD_ONLY:
            if name in changed and not is_given(name):
                changed[name] = None
    return changed
