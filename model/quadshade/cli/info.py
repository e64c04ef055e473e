# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade info``: what runs here, or who is at a port and what has happened there."""

from __future__ import annotations

import click

from quadshade.cli.options import TitledCommand, add_options, is_given
from quadshade.cli.port_options import port_options
from quadshade.cli.terminal import say_trace
from quadshade.errors import QuadshadeError


@click.command(cls=TitledCommand, short_help="Say which versions run here, or what a board is.")
@add_options(port_options())
def info(
    port: str | None,
    baud: int | None,
    faults: tuple[float, int] | None,
    timeout: float | None,
    trace: bool,
) -> None:
    """
    Say which versions run here, as a report of a fault needs them.

    With --port: say what the board there is and has counted since its last reset; nothing of it changes.

    \b
    quadshade info
    quadshade info --port auto
    quadshade info --port /dev/ttyUSB0
    """
    if port is None:
        _say_environment()
        return
    from quadshade.board.describe import describe_board

    found = describe_board(port, baud, faults, timeout, say_trace if trace else None)
    click.echo(f"a Quadshade board at {found.name}, protocol {found.version}")
    for table in found.tables():
        click.echo("")
        wide = max(len(value) for _, value, _ in table)
        for name, value, text in table:
            click.echo(f"{name:20}{value:>{wide}}  {text}")


def _say_environment() -> None:
    """Versions of what runs here."""
    from quadshade.engine.environment import environment

    for name in ("baud", "faults", "timeout", "trace"):
        if is_given(name):
            raise QuadshadeError(f"--{name} without --port", "give the port of a board")
    for name, value in environment().items():
        click.echo(f"{name:20}{value}")
