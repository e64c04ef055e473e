# SPDX-License-Identifier: Apache-2.0
"""
The serial link between host and board.

``frames`` is the codec of what is on the wire (``quadshade.contract.protocol``); ``transport`` is the line,
``session`` what keeps order on it, ``planes`` the way back, ``faults`` a bad line.
``docs/reference/protocol.md`` is the description, ``docs/reference/link.md`` the use;
``rtl/generated/link_pkg.vhd`` is written from ``protocol``.
"""

from quadshade.link.faults import FaultInjector
from quadshade.link.frames import Frame, FrameParser
from quadshade.link.planes import read_area, read_picture
from quadshade.link.session import Session
from quadshade.link.transport import (
    FaultyTransport,
    MemoryTransport,
    SerialTransport,
    Transport,
    open_transport,
)

__all__ = [
    "FaultInjector",
    "FaultyTransport",
    "Frame",
    "FrameParser",
    "MemoryTransport",
    "SerialTransport",
    "Session",
    "Transport",
    "open_transport",
    "read_area",
    "read_picture",
]
