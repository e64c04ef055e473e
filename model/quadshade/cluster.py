# SPDX-License-Identifier: Apache-2.0
"""Work for other machines: a Dask scheduler and its workers, which need the same version of Quadshade."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from itertools import islice
from typing import Any, NamedTuple

from quadshade.contract.protocol import definition_hash
from quadshade.errors import QuadshadeError
from quadshade.files.code_digest import code_digest

CONNECT_SECONDS = 10
CLOSE_SECONDS = 10
HINT = "start one by `dask scheduler`, and workers by `dask worker ADDRESS`"

LOGGERS = ("distributed.batched", "distributed.client", "distributed.core")
"""Dask's own words, with tracebacks, about a line that broke, of which an error here says it in one line."""

BOARD = "board"
"""Resource of workers that have a board: ``dask worker ADDRESS --resources board=1 --nthreads 1``."""

AHEAD = 3
"""Tasks for each worker that are begun or wait: what has been drawn and not been fetched is no more."""

ALONE_SECONDS = 30.0
"""So long no worker may be there before it is an error: one that is restarted comes back."""

POLL_SECONDS = 0.02


class Failed(NamedTuple):
    """What a task gives in place of a result where its worker cannot do it."""

    worker: str
    reason: str


def connect(address: str) -> Any:
    """
    A connection to a scheduler that has workers of this version.

    Parameters
    ----------
    address : str
      For example ``tcp://host:8786``.

    Returns
    -------
    distributed.Client

    Raises
    ------
    QuadshadeError
      Dask is not installed, no scheduler answers, it has no workers, or one of another version.
    """
    try:
        from distributed import Client
    except ImportError:
        raise QuadshadeError("Dask is not installed", "run `pip install quadshade[dask]`") from None
    for name in LOGGERS:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    # Made before it connects, so that one that cannot is closed here. Left alone it closes itself when it is
    # collected, in whatever thread that is: in its own, or in another client's, it would wait for ever.
    client = Client.__new__(Client)
    try:
        Client.__init__(client, address, timeout=CONNECT_SECONDS)
    # The first bytes of what is no scheduler are taken for a length, which no memory holds.
    except (OSError, ValueError, TypeError, MemoryError):
        with suppress(OSError, ValueError, TypeError, AttributeError):
            client.close(timeout=CLOSE_SECONDS)
        raise QuadshadeError(f"no Dask scheduler answers at {address}", HINT) from None
    try:
        if not workers_of(client):
            raise QuadshadeError(f"the Dask scheduler at {address} has no workers", HINT)
        _check_versions(client)
    except BaseException:
        client.close()
        raise
    return client


def workers_of(client: Any, needs_board: bool = False) -> list[str]:
    """Addresses of the workers, of those only that have a board where one is needed."""
    workers: dict[str, dict[str, Any]] = client.scheduler_info(n_workers=-1)["workers"]
    return [one for one, about in workers.items() if not needs_board or about["resources"].get(BOARD)]


def _version() -> str:
    """What has to be the same everywhere: the protocol, and the host's own code."""
    return f"{definition_hash():08x} {code_digest()}"


def _check_versions(client: Any) -> None:
    """Refuse workers that would draw something else."""
    hint = "install the same version there, and start the workers anew"
    try:
        versions: dict[str, str] = client.run(_version)
    except Exception as problem:  # noqa: BLE001 - whatever a worker raises that has no Quadshade
        raise QuadshadeError(f"a worker has no such Quadshade: {type(problem).__name__}", hint) from None
    for worker, version in versions.items():
        if version != _version():
            raise QuadshadeError(f"the worker {worker} has another version of Quadshade", hint)


def _here(function: Callable[[Any], Any], job: Any) -> Any:
    """Do a job on a worker; what that cannot do another one may."""
    from distributed import get_worker

    try:
        return function(job)
    except QuadshadeError as error:
        return Failed(get_worker().address, error.message)


def stream(
    client: Any,
    function: Callable[[Any], Any],
    jobs: Iterable[Any],
    what: str,
    lose: Callable[[str, str], None],
    needs_board: bool = False,
) -> Iterator[tuple[Any, Any]]:
    """
    Have jobs done by workers; few are begun ahead, so that memory does not grow with their number.

    Parameters
    ----------
    client : distributed.Client
    function : callable
      Does a job on a worker; pickled. Where it raises :class:`QuadshadeError`, that worker is lost, and
      another one does the job.
    jobs : iterable
    what : str
      What they are called.
    lose : callable
      Called with the address of a worker that is lost, and why.
    needs_board : bool
      Only workers that have a board, which does one job at a time.

    Yields
    ------
    job, result
      As they get ready.

    Raises
    ------
    QuadshadeError
      No worker is left, or no scheduler: how many jobs are missing.
    """
    from distributed import KilledWorker, as_completed
    from distributed.client import FutureCancelledError

    given, waiting = iter(jobs), deque[Any]()
    lost: set[str] = set()
    running: dict[Any, Any] = {}
    ready = as_completed()
    shared = client.scatter(function, broadcast=True, hash=False)
    options = {"resources": {BOARD: 1}} if needs_board else {}
    since = time.monotonic()
    reason = "there was none"
    try:
        while True:
            able = [one for one in workers_of(client, needs_board) if one not in lost]
            since = time.monotonic() if able else since
            if not able and (lost or time.monotonic() > since + ALONE_SECONDS):
                missing = len(waiting) + len(running) + sum(1 for _ in given)
                raise QuadshadeError(f"{missing} {what} are missing, as no worker is left: {reason}", HINT)
            while able and len(running) < AHEAD * len(able):
                waiting.extend(islice(given, not waiting))
                if not waiting:
                    break
                job = waiting.popleft()
                # Not said where nobody is lost: a worker that comes later may do it too.
                chosen = options | ({"workers": able} if lost else {})
                future = client.submit(_here, shared, job, pure=False, **chosen)
                running[future] = job
                ready.add(future)
            if not running and able:
                return
            finished = ready.next_batch(block=False)
            if not finished:
                time.sleep(POLL_SECONDS)
            for one in finished:
                job = running.pop(one)
                try:
                    result = one.result()
                except FutureCancelledError:
                    # The function was on workers that are gone.
                    shared = client.scatter(function, broadcast=True, hash=False)
                    waiting.append(job)
                    continue
                except KilledWorker as problem:
                    raise QuadshadeError(f"workers die of one of the {what}: {problem}", HINT) from None
                one.release()
                if not isinstance(result, Failed):
                    yield job, result
                    continue
                waiting.append(job)
                if result.worker not in lost:
                    lost.add(result.worker)
                    reason = result.reason
                    lose(result.worker, reason)
    except QuadshadeError:
        raise
    except Exception as problem:
        # Whatever Dask raises where its line is gone: it has tried to reach the scheduler again by then.
        if client.status == "running":
            raise
        missing = len(waiting) + len(running) + sum(1 for _ in given)
        raise QuadshadeError(
            f"{missing} {what} are missing, as the Dask scheduler is lost: {problem}", HINT
        ) from None
    finally:
        if client.status == "running":
            for one in running:
                one.cancel()
