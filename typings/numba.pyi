# SPDX-License-Identifier: Apache-2.0
from collections.abc import Callable
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])

def njit(
    *, cache: bool = ..., error_model: str = ..., nogil: bool = ..., parallel: bool = ...
) -> Callable[[_Function], _Function]: ...
