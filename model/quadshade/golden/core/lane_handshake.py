# SPDX-License-Identifier: Apache-2.0
"""The handshake state of a lane, cycle by cycle (``rtl/core/lane_handshake.vhd``)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class LaneInputs:
    """What the handshake sees in a cycle, under the names of the RTL's ports."""

    walk_span_coming: bool = False
    chain_full_next: bool = False
    span_valid: bool = False
    span_single: bool = False
    span_ending: bool = False
    clamped_valid: bool = False
    emitted_valid: bool = False
    emitted_ready: bool = False


class LaneHandshake:
    """
    When a lane's stages move.

    Attributes
    ----------
    walk : bool
      The edge walker's stages move in this cycle.
    walked_valid : bool
      A span stands in the edge walker's last stage.
    advance : bool
      Pixels move: the skid buffer's spare register is free.
    wanted : bool
      The span walker shows its span's last pixel, or none.
    """

    def __init__(self) -> None:
        self.walk = True
        self.walked_valid = False
        self.advance = True
        self.wanted = True

    @property
    def span_taken(self) -> bool:
        """The chain's end may move."""
        return self.wanted and self.advance

    @property
    def load(self) -> bool:
        """Pixels that advance load what stands at the chain's end, valid or not; else they step."""
        return self.wanted

    def clock(self, inputs: LaneInputs) -> None:
        """One clock edge."""
        if self.walk:
            self.walked_valid = inputs.walk_span_coming
        if self.advance:
            loads_span = self.wanted and inputs.span_valid
            self.wanted = inputs.span_single if loads_span else self.wanted or inputs.span_ending
        free = not inputs.emitted_valid or inputs.emitted_ready
        self.advance = free or (self.advance and not inputs.clamped_valid)
        self.walk = not self.walked_valid or not inputs.chain_full_next or self.span_taken
