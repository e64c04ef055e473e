# SPDX-License-Identifier: Apache-2.0
"""What the package uses of numba, which has no types of its own: a compiled function keeps its."""

from collections.abc import Callable
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])

def njit(
    *,
    cache: bool = ...,
    error_model: str = ...,
    fastmath: bool | set[str] = ...,
    forceinline: bool = ...,
    inline: str = ...,
) -> Callable[[_Function], _Function]: ...
