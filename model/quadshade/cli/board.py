# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade board``: a simulated board behind a pseudo-terminal or a TCP port."""

from __future__ import annotations

import signal
from pathlib import Path

import click

from quadshade.choices import BOARD_ENGINES
from quadshade.cli.terminal import notice
from quadshade.contract.formats import parse_generics
from quadshade.errors import QuadshadeError


@click.command(short_help="Run a simulated board, UART pins included.")
@click.option(
    "--engine",
    type=click.Choice(BOARD_ENGINES),
    envvar="QUADSHADE_ENGINE",
    help="What runs: the board's netlist in Verilator, its VHDL in GHDL, or its golden model.  "
    "[default: verilator where it and a C++ compiler are installed, else model]",
)
@click.option("--pty", type=click.Path(path_type=Path), help="Make this a link to the pseudo-terminal.")
@click.option(
    "--tcp",
    metavar="[ADDRESS:]PORT",
    help="Listen there instead, for socket://localhost:PORT; also [::1]:PORT.",
)
@click.option("--screen", metavar="WxH", help="Pixels.  [default: 160x120, or the board's]")
@click.option(
    "--board",
    "preset",
    metavar="NAME",
    help="With the generics of a real board, e.g. icebreaker or ulx3s-85f; the clock stays a simulation's.",
)
@click.option(
    "--generic",
    "generics",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a generic of the core or the board under its VHDL name (repeatable), e.g. fifo_words=2048.",
)
@click.option(
    "--monitor",
    metavar="FILE.png",
    type=click.Path(path_type=Path),
    help="Write what a monitor shows, whenever that changes; with --engine model.",
)
@click.option("--shade", is_flag=True, help="With the shade unit: a diffuse and a specular channel.")
def board(
    engine: str | None,
    pty: Path | None,
    tcp: str | None,
    screen: str | None,
    preset: str | None,
    generics: tuple[str, ...],
    monitor: Path | None,
    shade: bool,
) -> None:
    """
    Run a simulated board, UART pins included, until Ctrl-C.

    A host at the other end sees a serial port: its baud rate is followed on a pseudo-terminal, a TCP port has
    the board's own.

    \b
    quadshade board --pty ./board.tty
    quadshade board --tcp 7777 --engine model --screen 320x240
    quadshade board --pty ./board.tty --board icebreaker
    quadshade board --pty ./board.tty --engine model --generic buffers=2 --monitor shown.png
    """
    from quadshade.board.endpoints import PtyLine, TcpLine, tcp_address
    from quadshade.board.engines import board_engine, start_engine
    from quadshade.board.large_screen import large_screen_notice
    from quadshade.board.readback import BoardReader
    from quadshade.board.settings import board_settings
    from quadshade.board.simulated import SimulatedBoard
    from quadshade.files.atomic import check_writable
    from quadshade.image import write_png
    from quadshade.rendering.picture import check_png
    from quadshade.scene.key_values import parse_size

    if pty is not None and tcp is not None:
        raise QuadshadeError("--pty and --tcp are given", "give one of them")
    if monitor is not None:
        check_png(monitor)
        check_writable(monitor)
        if pty is not None and pty.absolute() == monitor.absolute():
            raise QuadshadeError(f"--pty and --monitor are both {pty}", "give two names")
    address = None if tcp is None else tcp_address(tcp)
    size = None if screen is None else parse_size(screen)
    settings = board_settings(preset, size, parse_generics(generics), shade)
    name = board_engine(engine)
    if text := large_screen_notice(settings, name):
        notice(text)
    # The line first: a path or a port that cannot be had is said before anything is compiled.
    line = PtyLine(pty, settings.baud) if address is None else TcpLine(address[1], address[0])
    try:
        shows = None if monitor is None else lambda shown: write_png(monitor, BoardReader.as_rgb(shown))
        running = start_engine(name, settings, shows)
    except BaseException:
        line.close()
        raise
    with SimulatedBoard(line, running) as simulated:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: simulated.stop())
        click.echo(
            f"a board of {settings.screen_width}x{settings.screen_height} pixels in {name}: "
            f"--port {simulated.name}"
        )
        simulated.run()
    click.echo("the board has stopped")
