# SPDX-License-Identifier: Apache-2.0
"""Where a sweep's points are measured: the cores of this machine, or a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import joblib

from quadshade.errors import QuadshadeError

CONNECT_SECONDS = 10
Results = Iterator[Any]


@contextmanager
def workers(jobs: int, dask: str | None) -> Iterator[Callable[[Iterable[Any]], Results]]:
    """
    A function that runs joblib's delayed calls and gives their results as they come.

    Parameters
    ----------
    jobs : int
      Processes on this machine, -1 for as many as there are cores.
    dask : str or None
      Address of a Dask scheduler, for example ``tcp://host:8786``; its workers then do the work, and need the
      same version of Quadshade installed.

    Raises
    ------
    QuadshadeError
      Dask is not installed, or no scheduler answers at the address.
    """
    if dask is None:
        yield joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", max_nbytes=None)
        return
    with _client(dask), joblib.parallel_config(backend="dask"):
        yield joblib.Parallel(return_as="generator_unordered")


def _client(address: str) -> Any:
    """A connection to a scheduler that has workers."""
    try:
        from distributed import Client
    except ImportError:
        raise QuadshadeError("Dask is not installed", "run `pip install quadshade[dask]`") from None
    hint = "start one by `dask scheduler`, and workers by `dask worker ADDRESS`"
    try:
        client = Client(address, timeout=CONNECT_SECONDS)
    except (OSError, ValueError, TimeoutError, MemoryError):
        # The first bytes of what is no scheduler are taken for a length.
        raise QuadshadeError(f"no Dask scheduler answers at {address}", hint) from None
    if not client.scheduler_info()["workers"]:
        client.close()
        raise QuadshadeError(f"the Dask scheduler at {address} has no workers", hint)
    return client
