# SPDX-License-Identifier: Apache-2.0
"""What commands do, one after the other: for the command units' model, and to compare the ports with."""

from __future__ import annotations

from quadshade.contract.protocol import PACKED

READ_FIELDS = ("x", "y", "width", "count", "pixels", "plane", "packed")
"""The ports of a READ, in the order in which they are recorded."""


class CommandRecorder:
    """
    A board that only takes notes.

    Attributes
    ----------
    done : list of tuple
      The name of what was done, and its values.
    """

    def __init__(self) -> None:
        self.done: list[tuple] = []

    def triangles(self, words: list[int]) -> None:
        self.done += [("setup", word) for word in words]

    def state(self, address: int, value: int) -> None:
        self.done.append(("state", address, value))

    def clear(self, colour: int) -> None:
        self.done.append(("clear", colour))

    def swap(self) -> None:
        self.done.append(("swap",))

    def read(self, **fields: int) -> bytes:
        packed, plane = divmod(fields["plane"], PACKED)
        ports = fields | {"plane": plane, "packed": packed}
        self.done.append(("read", *(ports[name] for name in READ_FIELDS)))
        return bytes(fields["count"])

    def frame_crc(self, plane: int) -> int:
        self.done.append(("frame_crc", plane))
        return 0

    def reset(self) -> None:
        self.done.append(("reset",))
