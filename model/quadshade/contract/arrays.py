# SPDX-License-Identifier: Apache-2.0
"""Names for the arrays of this package, by what an element is; docstrings give the shapes."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Ints: TypeAlias = npt.NDArray[np.int64]
Floats: TypeAlias = npt.NDArray[np.float64]
Bools: TypeAlias = npt.NDArray[np.bool_]
Bytes: TypeAlias = npt.NDArray[np.uint8]
Words32: TypeAlias = npt.NDArray[np.uint32]
"""Set-up words, packed words."""
Records: TypeAlias = npt.NDArray[np.void]
"""Elements of a structured dtype: columns with names."""
Record: TypeAlias = np.void
"""One element of :data:`Records`."""
