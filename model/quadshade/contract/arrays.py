# SPDX-License-Identifier: Apache-2.0
"""
Names for the arrays of this package, by what an element is; docstrings give the shapes.

Every module with compiled loops imports it, so the stale ones among those that are kept go here, before any
is called.
"""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias, get_type_hints

import numpy as np
import numpy.typing as npt

from quadshade.stale_loops import drop_stale_loops

drop_stale_loops(Path(__file__).parents[1])

Ints: TypeAlias = npt.NDArray[np.int64]
Floats: TypeAlias = npt.NDArray[np.float64]
Int: TypeAlias = int | np.int64
"""An integer of a compiled function, where it may be an element of an array."""
Bools: TypeAlias = npt.NDArray[np.bool_]
Bytes: TypeAlias = npt.NDArray[np.uint8]
Words32: TypeAlias = npt.NDArray[np.uint32]
"""Set-up words, packed words."""
Records: TypeAlias = npt.NDArray[np.void]
"""Elements of a structured dtype: columns with names."""
Record: TypeAlias = np.void
"""One element of :data:`Records`."""


def record_dtype(columns: type) -> np.dtype[np.void]:
    """
    The structured dtype of a class that names columns.

    Functions read and write a record's columns as attributes, compiled or, with NUMBA_DISABLE_JIT=1, as plain
    Python: elements are ``np.record``. So the class also serves as the type of one record.

    Parameters
    ----------
    columns : type
      With an annotation a column: ``int`` is int64, ``float`` is float64.
    """
    kinds = {int: np.int64, float: np.float64}
    return np.dtype((np.record, [(name, kinds[kind]) for name, kind in get_type_hints(columns).items()]))
