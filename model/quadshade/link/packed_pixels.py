# SPDX-License-Identifier: Apache-2.0
"""Packed answers of READ, unpacked again; docs/reference/readback.md is the format."""

from __future__ import annotations

import numba
import numpy as np

from quadshade.contract.protocol import ESCAPE_ONES, LinkError

BYTE_BITS = 8


@numba.njit(cache=True)
def _unpack(bits: np.ndarray, size: int, data: np.ndarray) -> int:
    """
    Bits to as many bytes as ``data`` has; how many bits they took, or -1 where they are too few or too many.

    A bit beyond the end is a 1, so that no loop goes on for ever.
    """
    at, end = 0, len(bits)
    zeros, step = 0, 0
    # Bytes of the run that are still to come, and whether a byte that is not as predicted follows it.
    due, follows = 0, False
    for index in range(len(data)):
        before = data[index - size] if index >= size else 0
        slope = before - data[index - 2 * size] if index >= 2 * size else 0
        expected = (before + slope) & 0xFF
        if step and not due and not follows:
            if at < end and not bits[at]:
                at += 1
                while step > 1:
                    step >>= 1
                    due += step * (at < end and bits[at] != 0)
                    at += 1
                follows = True
            else:
                at += 1
                due = step
                step *= 2
        if due:
            due -= 1
            data[index] = expected
            continue
        if follows:
            step, follows = 0, False
        ones = 0
        while ones < ESCAPE_ONES and (at >= end or bits[at]):
            ones += 1
            at += 1
        if ones == ESCAPE_ONES:
            byte = 0
            for _ in range(BYTE_BITS):
                byte = 2 * byte + (at < end and bits[at] != 0)
                at += 1
            data[index] = byte
        else:
            at += 1
            residual = (ones + 1) // 2 if ones & 1 else -(ones // 2)
            data[index] = (expected + residual) & 0xFF
        zeros = zeros + 1 if ones == 0 else 0
        if zeros == size:
            zeros, step = 0, 1
    return at if at <= end and not follows else -1


def unpack_pixels(packed: bytes, count: int, size: int) -> bytes:
    """
    READ's bytes from its answer: the inverse of :func:`quadshade.golden.link.pixel_packer.pack_pixels`.

    Parameters
    ----------
    packed : bytes
    count : int
      Bytes that were asked for.
    size : int
      Bytes of a pixel.

    Returns
    -------
    bytes

    Raises
    ------
    LinkError
      The answer is not what a board packs: too long, cut, or with bits left over.
    """
    if len(packed) == count:
        return bytes(packed)
    bits = np.unpackbits(np.frombuffer(packed, np.uint8))
    data = np.zeros(count, np.int64)
    used = _unpack(bits, size, data) if len(packed) < count else -1
    if used < 0 or len(bits) - used >= BYTE_BITS or bits[used:].any():
        raise LinkError(
            f"a packed answer of {len(packed)} bytes does not unpack to the {count} that were asked for",
            "the bitstream is another, or the board fails: build it again",
        )
    return data.astype(np.uint8).tobytes()
