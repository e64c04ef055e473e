# SPDX-License-Identifier: Apache-2.0
"""The output's two registers, cycle by cycle (``rtl/common/skid_buffer.vhd``)."""

from __future__ import annotations

from typing import Any


class SkidBuffer:
    """A front register that the consumer sees, a spare one that makes the producer's ready a register."""

    def __init__(self) -> None:
        self.front: Any = None
        self.spare: Any = None

    @property
    def input_ready(self) -> bool:
        """True if the buffer takes what is offered in this cycle."""
        return self.spare is None

    def clock(self, offered: Any, output_ready: bool) -> None:
        """One clock edge with ``offered`` (or None) at the input."""
        taken = offered if self.input_ready else None
        if self.front is None or output_ready:
            self.front = taken if self.spare is None else self.spare
            self.spare = None
        elif taken is not None:
            self.spare = taken
