# SPDX-License-Identifier: Apache-2.0
"""The elastic chain of spans, cycle by cycle (``rtl/core/span_chain.vhd``)."""

from __future__ import annotations

from typing import Any


class SpanChain:
    """
    A row of registers; each moves on when the one ahead is empty or moves.

    Parameters
    ----------
    depth : int
      Number of registers.
    """

    def __init__(self, depth: int) -> None:
        self.stages: list[Any] = [None] * depth

    def input_ready(self, output_ready: bool) -> bool:
        """True if the first stage takes what is offered in this cycle."""
        return output_ready or any(stage is None for stage in self.stages)

    @property
    def output(self) -> Any:
        """What the last stage holds; None where it is empty."""
        return self.stages[-1]

    def clock(self, offered: Any, output_ready: bool) -> None:
        """
        One clock edge.

        Parameters
        ----------
        offered : object or None
          What stands at the input; taken only where :meth:`input_ready` says so.
        output_ready : bool
        """
        moves = output_ready
        for index in reversed(range(len(self.stages))):
            moves = moves or self.stages[index] is None
            if moves:
                self.stages[index] = self.stages[index - 1] if index else offered
