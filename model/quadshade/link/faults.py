# SPDX-License-Identifier: Apache-2.0
"""Seeded faults of a serial line: what noise, loose plugs and full buffers do to a stream of bytes."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator

from quadshade.errors import QuadshadeError

MAX_RUN = 40
"""Most bytes that a burst garbles, or a cut loses, at once."""


class FaultInjector:
    """
    Damages bytes that pass, in order, at a mean rate.

    Kinds: ``flip`` (one bit), ``drop``, ``double``, ``insert`` (a random byte before it), ``burst`` (up to
    40 random bytes in place of as many) and ``cut`` (up to 40 bytes lost).

    Parameters
    ----------
    rate : float
      Faults a byte, 0 to 1.
    seed : int or str

    Attributes
    ----------
    injected : Counter of str
      Faults so far, by kind.

    Raises
    ------
    QuadshadeError
      A rate that is not from 0 to 1.
    """

    KINDS = ("flip", "drop", "double", "insert", "burst", "cut")

    def __init__(self, rate: float, seed: int | str = 1) -> None:
        if not 0 <= rate <= 1:
            raise QuadshadeError(f"fault rate {rate}", "give 0 to 1 faults a byte")
        self.rate = rate
        self.injected: Counter[str] = Counter()
        self._draw = random.Random(f"faults {seed}")
        self._clean = self._gap()
        self._burst = self._cut = 0

    @property
    def total(self) -> int:
        """Faults so far."""
        return self.injected.total()

    def _gap(self) -> int:
        """Bytes that pass before the next fault, geometrically distributed."""
        if self.rate == 0:
            return 1 << 62
        return int(self._draw.expovariate(self.rate)) if self.rate < 1 else 0

    def damage(self, data: bytes) -> bytes:
        """
        What arrives of bytes that were sent; a burst or a cut may go on in the next call's.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        bytes
        """
        out = bytearray()
        at = 0
        while at < len(data):
            if not (self._burst or self._cut):
                passing = min(self._clean, len(data) - at)
                out += data[at : at + passing]
                at += passing
                self._clean -= passing
                if at == len(data):
                    break
            out += bytes(self._damaged(data[at]))
            at += 1
        return bytes(out)

    def _damaged(self, byte: int) -> Iterator[int]:
        """What arrives of one byte in a running burst or cut, or of the first one of a new fault."""
        draw = self._draw
        if not (self._burst or self._cut):
            self._clean = self._gap()
            kind = draw.choice(self.KINDS)
            self.injected[kind] += 1
            if kind == "burst":
                self._burst = draw.randint(2, MAX_RUN)
            elif kind == "cut":
                self._cut = draw.randint(2, MAX_RUN)
            elif kind == "flip":
                yield byte ^ 1 << draw.randrange(8)
            elif kind == "double":
                yield from (byte, byte)
            elif kind == "insert":
                yield from (draw.randrange(256), byte)
        if self._cut:
            self._cut -= 1
        elif self._burst:
            self._burst -= 1
            yield draw.randrange(256)
