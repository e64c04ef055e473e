# SPDX-License-Identifier: Apache-2.0
"""READ's bytes in fewer (``rtl/link/pixel_packer.vhd``); docs/reference/readback.md says how."""

from __future__ import annotations

from quadshade.contract.protocol import ESCAPE_ONES

BYTE_BITS = 8


def predicted(data: bytes, index: int, size: int) -> int:
    """
    What a byte should be, by those in its place of the pixels before: 2 a - b, modulo 256.

    Parameters
    ----------
    data : bytes
      At least up to ``index``.
    index : int
    size : int
      Bytes of a pixel. The first pixel is predicted as 0, the second one as the first.
    """
    if index < size:
        return 0
    before = data[index - size]
    slope = before - data[index - 2 * size] if index >= 2 * size else 0
    return (before + slope) % (1 << BYTE_BITS)


def code_of(byte: int, residual: int) -> str:
    """The bits of a byte that is ``residual`` (modulo 256) more than predicted."""
    residuals = [
        (ones + 1) // 2 if ones % 2 else -(ones // 2) % (1 << BYTE_BITS) for ones in range(ESCAPE_ONES)
    ]
    if residual in residuals:
        return "1" * residuals.index(residual) + "0"
    return "1" * ESCAPE_ONES + f"{byte:0{BYTE_BITS}b}"


def packed_bits(data: bytes, size: int) -> str:
    """
    Bytes of a plane as bits, the first one first.

    Parameters
    ----------
    data : bytes
    size : int
      Bytes of a pixel.
    """
    bits = ""
    # Zeros in a row; of a run those since its last 1, and how many the next 1 stands for.
    zeros, run, step = 0, 0, 0
    for index, byte in enumerate(data):
        residual = (byte - predicted(data, index, size)) % (1 << BYTE_BITS)
        if step and residual == 0:
            run += 1
            if run == step:
                bits += "1"
                run, step = 0, 2 * step
            continue
        if step:
            # The run ends: as many binary digits as the step has behind its first one.
            bits += "0" + f"{step + run:b}"[1:]
            run = step = 0
        bits += code_of(byte, residual)
        zeros = zeros + 1 if residual == 0 else 0
        if zeros == size:
            zeros, run, step = 0, 0, 1
    # How many bytes there are is known, so a run may go beyond their end.
    return bits + "1" * (run > 0)


def pack_pixels(data: bytes, size: int) -> bytes:
    """
    What a READ that may be packed is answered.

    Parameters
    ----------
    data : bytes
      READ's, at least one.
    size : int
      Bytes of a pixel.

    Returns
    -------
    bytes
      Packed, the first bit in the highest place, zeros to a whole byte; ``data`` itself where that is not
      longer.
    """
    bits = packed_bits(data, size)
    count = -(-len(bits) // BYTE_BITS)
    if count >= len(data):
        return bytes(data)
    return int(bits.ljust(BYTE_BITS * count, "0"), 2).to_bytes(count, "big")
