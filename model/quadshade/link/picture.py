# SPDX-License-Identifier: Apache-2.0
"""The board's picture over a session, run by run, checked from end to end."""

from __future__ import annotations

import zlib
from collections import deque

import numpy as np

from quadshade.link.protocol import MAX_READ, LinkError, Opcode
from quadshade.link.session import Session

READS = 4
"""READs on their way at a time."""


def read_picture(session: Session) -> np.ndarray:
    """
    Fetch plane 0 and compare its CRC with the one that the board computes.

    A run that does not arrive is asked for again in two halves, so a bad line gets short answers.

    Parameters
    ----------
    session : Session
      Connected.

    Returns
    -------
    (height, width, colour_bytes) uint8

    Raises
    ------
    LinkError
      The link is too bad, or the CRC differs.
    """
    width, height, size = (
        session.identity[name] for name in ("screen_width", "screen_height", "colour_bytes")
    )
    picture = np.zeros((height, width, size), np.uint8)
    most = MAX_READ // size
    runs = deque((x, y, min(most, width - x)) for y in range(height) for x in range(0, width, most))
    fruitless = 0
    while runs:
        asked = [runs.popleft() for _ in range(min(READS, len(runs)))]
        found = session.ask(Opcode.READ, [question(*run, size) for run in asked])
        fruitless = 0 if found else fruitless + 1
        if fruitless > session.retries:
            raise session.too_bad("READ")
        for index, (x, y, count) in enumerate(asked):
            if index in found:
                picture[y, x : x + count] = np.frombuffer(found[index], np.uint8).reshape(count, size)
            else:
                half = (count + 1) // 2
                runs.extendleft(run for run in ((x + half, y, count - half), (x, y, half)) if run[2])
    crc = session.frame_crc()
    got = zlib.crc32(picture.tobytes())
    if got != crc:
        raise LinkError(
            f"the picture that was read has CRC {got:08x}, the board's {crc:08x}", "read it again"
        )
    return picture


def question(x: int, y: int, count: int, size: int) -> dict[str, int]:
    """READ's fields for some pixels of a scanline."""
    return {"x": x, "y": y, "width": count, "count": count * size, "pixels": count, "plane": 0}
