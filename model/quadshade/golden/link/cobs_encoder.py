# SPDX-License-Identifier: Apache-2.0
"""A frame's bytes to bytes of the line, block by block (``rtl/link/cobs_encoder.vhd``)."""

from __future__ import annotations

LONGEST = 254
"""Bytes of a block without a zero."""


def encode_line(body: bytes) -> bytes:
    """
    What a frame looks like on the line: 00, blocks, 00.

    Parameters
    ----------
    body : bytes
      At least one.
    """
    line = bytearray(b"\0")
    block = bytearray()
    for position, byte in enumerate(body):
        last = position == len(body) - 1
        if byte:
            block.append(byte)
        if not byte or last or len(block) == LONGEST:
            line += bytes([len(block) + 1]) + block
            block.clear()
        if last and not byte:
            line.append(1)
    return bytes(line) + b"\0"
