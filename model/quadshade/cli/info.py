# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade info``: what runs here, or who is at a port and what has happened there."""

from __future__ import annotations

import click

from quadshade.cli.port_options import PortChoice, is_given, port_options, say_trace
from quadshade.contract.formats import GENERIC_HELP
from quadshade.contract.protocol import BOARD_FIELDS, COUNTERS, FEATURES, PHASE_BITS
from quadshade.contract.releases import release_of
from quadshade.errors import QuadshadeError


@click.command()
@port_options()
def info(port_choice: PortChoice) -> None:
    """
    Say which versions run here, as a report of a fault needs them.

    With --port: say what the board there is and has counted since its last reset; nothing of it changes.

    \b
    quadshade info
    quadshade info --port auto
    quadshade info --port /dev/ttyUSB0
    """
    if port_choice.port is None:
        _say_environment(port_choice)
        return
    from quadshade.board.ports import Port
    from quadshade.link.session import Session
    from quadshade.link.transport import FaultyTransport

    port = Port(port_choice.port, port_choice.baud)
    try:
        line = port.open()
        try:
            if port_choice.faults is not None:
                line = FaultyTransport(line, *port_choice.faults)
            trace = say_trace if port_choice.trace else None
            session = Session(line, port_choice.timeout or port.answer_seconds, trace=trace)
            identity = session.connect(reset=False)
            counters = session.status()
        finally:
            line.close()
    finally:
        port.close()
    features = [name for bit, name in enumerate(FEATURES) if identity["features"] >> bit & 1]
    clock, step = identity["clk_frequency_hz"], identity["default_phase_step"]
    click.echo(f"a Quadshade board at {line.name}, protocol {identity['version']}")
    _table(
        [
            ("definition", f"{identity['definition']:08x}", f"of {release_of(identity['definition'])}"),
            ("session", f"{identity['session']:08x}", "number of the last host's, 0 after power-up"),
            ("baud", str(round(step * clock / (1 << PHASE_BITS))), "rate after power-up"),
            ("has", ", ".join(features) or "nothing more", "features"),
            *((name, str(identity[name]), text) for name, _, text in BOARD_FIELDS if name != "features"),
        ]
    )
    _table([(name, str(identity[name]), text) for name, text in GENERIC_HELP.items() if name in identity])
    _table([(name, str(counters[name]), text) for name, _, text in COUNTERS])


def _say_environment(port_choice: PortChoice) -> None:
    """Versions of what runs here."""
    from quadshade.engine.environment import environment

    for name in ("baud", "faults", "timeout", "trace"):
        if getattr(port_choice, name) and is_given(name):
            raise QuadshadeError(f"--{name} without --port", "give the port of a board")
    for name, value in environment().items():
        click.echo(f"{name:20}{value}")


def _table(rows: list[tuple[str, str, str]]) -> None:
    """Name, value and meaning, in columns."""
    click.echo("")
    wide = max(len(value) for _, value, _ in rows)
    for name, value, text in rows:
        click.echo(f"{name:20}{value:>{wide}}  {text}")
