# SPDX-License-Identifier: Apache-2.0
"""An answer as bytes of a frame (``rtl/link/answer_sender.vhd``)."""

from __future__ import annotations

from collections.abc import Sequence

from quadshade.contract.protocol import CRC_BYTES, WORD_BYTES
from quadshade.golden.common.crc32 import crc_of


def answer_bytes(opcode: int, number: int, words: Sequence[int], data: bytes = b"") -> bytes:
    """
    Header, words, bytes, CRC.

    Parameters
    ----------
    opcode, number : int
    words : sequence of int
      The link state first.
    data : bytes
      What READ found.
    """
    content = b"".join(word.to_bytes(WORD_BYTES, "little") for word in words) + data
    body = bytes([opcode, number]) + len(content).to_bytes(2, "little") + content
    return body + crc_of(body).to_bytes(CRC_BYTES, "little")
