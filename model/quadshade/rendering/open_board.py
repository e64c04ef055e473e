# SPDX-License-Identifier: Apache-2.0
"""Boards at the ports that are chosen, and a screen of them for a picture of any size."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from quadshade.board import Board, BoardSettings
from quadshade.board.engines import board_engine
from quadshade.board.pool import BoardPool, wait_until_free
from quadshade.board.tile_store import TileStore
from quadshade.board.tiled_screen import TiledScreen
from quadshade.board.worker_boards import Place, WorkerPool
from quadshade.choices import SIM, parse_faults, simulated_board
from quadshade.cluster import connect
from quadshade.contract.protocol import PortError
from quadshade.errors import QuadshadeError
from quadshade.rendering.groups import EngineChoice, PortChoice
from quadshade.rendering.settings import Reports
from quadshade.rendering.simulated import settings_of


@contextmanager
def opened(
    port: PortChoice, settings: BoardSettings | None, engine: EngineChoice, reports: Reports
) -> Iterator[BoardPool]:
    """
    The boards at the ports, closed at the end; those that are open already stay so.

    Parameters
    ----------
    port : PortChoice
    settings : BoardSettings or None
      Of simulated boards.
    engine : EngineChoice
      What simulates them.
    reports : Reports

    Raises
    ------
    QuadshadeError
      A port that cannot be opened, or no board that answers. Of several, those that do not answer, or are of
      another version, are left out with a notice.
    """
    # A name that no board has is wrong, not a board that does not answer.
    built = [settings_of(name, settings) for name in port.ports]
    if any(simulated_board(name) is not None for name in port.ports):
        reports.step(f"starting a simulated board in {board_engine(engine.engine)}")
    with ExitStack() as stack:
        boards: dict[int, Board] = {}
        problem: QuadshadeError | None = None
        # A port that is not there is said before a simulation is compiled.
        for number in sorted(
            range(len(port.ports)), key=lambda at: simulated_board(port.ports[at]) is not None
        ):
            try:
                given = port.ports[number]
                is_open = isinstance(given, Board)
                if is_open:
                    wait_until_free(given)
                boards[number] = (
                    given
                    if is_open
                    else stack.enter_context(_open(port, number, built[number], engine, reports))
                )
            except PortError:
                raise
            except QuadshadeError as error:
                if len(port.ports) == 1:
                    raise
                problem = error
                reports.notice(f"the board at {port.ports[number]} is left out: {error.message}")
        if not boards and problem is not None:
            raise problem
        yield BoardPool([boards[number] for number in sorted(boards)], reports.notice)


def _open(
    port: PortChoice, number: int, settings: BoardSettings | None, engine: EngineChoice, reports: Reports
) -> Board:
    """The board at one of the ports."""
    name, is_simulated = port.ports[number], simulated_board(port.ports[number]) is not None
    rate, seed = (0.0, 0) if port.faults is None else parse_faults(port.faults)
    alone = len(port.ports) == 1
    return Board(
        SIM if is_simulated else name,
        port.baud,
        settings=settings if is_simulated else None,
        engine=engine.engine if is_simulated else None,
        # Every line is damaged in another way.
        faults=None if port.faults is None else (rate, seed + number),
        answer_seconds=port.timeout,
        trace=port.trace,
        notice=reports.notice,
        progress=reports.progress if alone else None,
    )


@contextmanager
def workers_screen(
    port: PortChoice, place: Place, size: tuple[int, int] | None, reports: Reports
) -> Iterator[TiledScreen]:
    """
    A screen whose tiles the workers of a Dask scheduler draw.

    Parameters
    ----------
    port : PortChoice
      With the scheduler's address.
    place : Place
      What workers draw with.
    size : tuple of int or None
      Of the picture; None: of a board's screen.
    reports : Reports

    Raises
    ------
    QuadshadeError
      No scheduler, no workers, workers of another version, or none with a board.
    """
    reports.step(f"asking the Dask scheduler at {port.dask}")
    with connect(str(port.dask)) as client:
        pool = WorkerPool(client, place, reports.notice)
        width, height = size or (pool.boards[0].width, pool.boards[0].height)
        screen = TiledScreen(pool, width, height, reports.notice, reports.progress, tile_store(port))
        yield screen
        screen.forget_tiles()


def tile_store(port: PortChoice) -> TileStore | None:
    """Where tiles are kept until a picture is whole."""
    given = port.resume
    return given if given is None or isinstance(given, TileStore) else TileStore(Path(given))


def drawn_at(port: PortChoice, board: Board | TiledScreen) -> str:
    """The ports that a picture comes from: as they were given, without those of boards that are left out."""
    if port.dask is not None:
        return port.name
    if not isinstance(board, TiledScreen):
        return port.name if len(port.ports) < 2 else str(board.session.name)
    return port.name if len(port.ports) == len(board.drawers) else board.name


def screen_of(
    pool: BoardPool, size: tuple[int, int] | None, reports: Reports, store: TileStore | None = None
) -> Board | TiledScreen:
    """
    What draws a picture: the one board that has its size, or several, or one in tiles.

    Parameters
    ----------
    pool : BoardPool
    size : tuple of int or None
      Width and height of the picture; None: of the first board's screen.
    reports : Reports
    store : TileStore, optional
      Where tiles are kept until the picture is whole.

    Returns
    -------
    Board or TiledScreen
    """
    first = pool.boards[0]
    width, height = size or (first.width, first.height)
    if len(pool.boards) == 1 and width <= first.width and height <= first.height:
        return first
    first.progress = None
    return TiledScreen(pool, width, height, reports.notice, reports.progress, store)
