# SPDX-License-Identifier: Apache-2.0
"""Where a sweep's points are measured: the cores of this machine, or a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import joblib

from quadshade.cluster import connect

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
      As :func:`quadshade.cluster.connect`.
    """
    if dask is None:
        yield joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", max_nbytes=None)
        return
    with connect(dask), joblib.parallel_config(backend="dask"):
        yield joblib.Parallel(return_as="generator_unordered")
