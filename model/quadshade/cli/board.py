# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade board``: a simulated board behind a pseudo-terminal or a TCP port."""

from __future__ import annotations

import signal
import tomllib
from pathlib import Path

import click

from quadshade.cli.options import parse_generics
from quadshade.cli.scene_options import parse_size
from quadshade.errors import QuadshadeError

ENGINES = ("verilator", "ghdl", "model")


@click.command()
@click.option(
    "--engine",
    type=click.Choice(ENGINES),
    envvar="QUADSHADE_ENGINE",
    help="What runs: the board's netlist in Verilator, its VHDL in GHDL, or its golden model.  "
    "[default: verilator where it and a C++ compiler are installed, else model]",
)
@click.option("--pty", type=click.Path(path_type=Path), help="Make this a link to the pseudo-terminal.")
@click.option("--tcp", metavar="[ADDRESS:]PORT", help="Listen there instead, for socket://localhost:PORT.")
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
@click.option("--shade", is_flag=True, help="With the shade unit: a diffuse and a specular channel.")
def board(
    engine: str | None,
    pty: Path | None,
    tcp: str | None,
    screen: str | None,
    preset: str | None,
    generics: tuple[str, ...],
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
    """
    from quadshade.board.endpoints import PtyLine, TcpLine, tcp_address
    from quadshade.board.engines import board_engine, start_engine
    from quadshade.board.simulated import SimulatedBoard

    if pty is not None and tcp is not None:
        raise QuadshadeError("--pty and --tcp are given", "give one of them")
    address = None if tcp is None else tcp_address(tcp)
    settings = board_settings(preset, screen, generics, shade)
    name = board_engine(engine)
    # The line first: a path or a port that cannot be had is said before anything is compiled.
    line = PtyLine(pty, settings.baud) if address is None else TcpLine(address[1], address[0])
    try:
        running = start_engine(name, settings)
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


def board_settings(
    preset: str | None, screen: str | None, generics: tuple[str, ...], shade: bool = False
) -> BoardSettings:  # noqa: F821 - imported when it is needed
    """
    Generics of a simulated board from a real one's, a size, and settings.

    Raises
    ------
    QuadshadeError
      An unknown board, a wrong size, or generics that no board has.
    """
    from quadshade.board.settings import BoardSettings

    settings = BoardSettings()
    if preset is not None:
        settings = settings.with_generics(_preset(preset))
    if shade:
        settings = settings.with_generics({"with_shade": 1, "num_channels": 2, "num_specular": 1})
    if screen is not None:
        width, height = parse_size(screen)
        settings = settings.with_generics({"screen_width": width, "screen_height": height})
    return settings.with_generics(parse_generics(generics))


def _preset(name: str) -> dict[str, int]:
    """Generics of a real board, but for its clock."""
    from quadshade.engine.ghdl import repository_root

    folder = repository_root() / "synth" / "boards"
    known = sorted(path.stem for path in folder.glob("*.toml"))
    if name not in known:
        raise QuadshadeError(f"there is no board {name!r}", f"the boards are {', '.join(known)}")
    generics = tomllib.loads((folder / f"{name}.toml").read_text()).get("generics", {})
    return {key: value for key, value in generics.items() if key not in ("clk_frequency_hz", "baud")}
