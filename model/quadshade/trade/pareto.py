# SPDX-License-Identifier: Apache-2.0
"""Which points of a sweep no other point beats."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from quadshade.choices import COSTS

ERROR = "rms"


def pareto_front(cost: npt.ArrayLike, error: npt.ArrayLike) -> np.ndarray:
    """
    Points that no other point beats: none costs no more and errs no more, and less in one of both.

    Parameters
    ----------
    cost, error : (n,) float
      Less is better.

    Returns
    -------
    (n,) bool
      Equal points are on the front together.
    """
    costs, errors = np.asarray(cost, dtype=np.float64), np.asarray(error, dtype=np.float64)
    front = np.zeros(len(costs), dtype=bool)
    least, same_cost = np.inf, np.nan
    for index in np.lexsort((errors, costs)):
        # In the order of cost, then error: a point is on the front if it errs less than all before it.
        if errors[index] < least or (errors[index] == least and costs[index] == same_cost):
            front[index] = True
            least, same_cost = errors[index], costs[index]
    return front


def mark_pareto(records: list[dict[str, Any]]) -> None:
    """
    Write into every record on which fronts it is: ``pareto``, a list of ``COSTS``.

    Parameters
    ----------
    records : list of dict
      Points that were refused (their error is None) and costs that were not counted are left out.
    """
    for record in records:
        record["pareto"] = []
    for cost in COSTS:
        known = [record for record in records if record.get(cost) is not None and record[ERROR] is not None]
        front = pareto_front([record[cost] for record in known], [record[ERROR] for record in known])
        for record, best in zip(known, front, strict=True):
            if best:
                record["pareto"].append(cost)
