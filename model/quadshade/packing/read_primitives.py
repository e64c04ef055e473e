# SPDX-License-Identifier: Apache-2.0
"""A set-up stream back to primitives: what a packed picture that is there already is cut into tiles from."""

from __future__ import annotations

import numpy as np

from quadshade.contract.formats import EDGE_FIELDS, EDGES, HEADER_FIELDS, Formats
from quadshade.golden.compiled_packets import decode_packets
from quadshade.setup.packet import Primitives


def read_primitives(words: np.ndarray, formats: Formats) -> Primitives:
    """
    The primitives of set-up words: the inverse of :func:`quadshade.setup.packet.pack`.

    Parameters
    ----------
    words : (m,) uint32
      Whole packets.
    formats : Formats

    Returns
    -------
    Primitives
      A triangle each, as packets do not say whose they are; without bounds.

    Raises
    ------
    QuadshadeError
      The stream ends within a packet.
    """
    decoded = decode_packets(words, formats)
    packets, size, channels = decoded.packets, len(decoded.packets), formats.carried_channels
    header = {field.name: packets[field.name] for field in HEADER_FIELDS if field.name != "orders"}
    header["rows_first"] = header["rows_first"] + 2
    header["rows_second"] = np.where(header["has_second"] != 0, header["rows_second"] + 2, 0)
    edges = {}
    for edge in EDGES:
        fields = {field.name: packets[edge][field.name] for field in EDGE_FIELDS}
        # Mirrored columns run from -2**coord_bits to 0, others from 0 to 2**coord_bits.
        turn = 1 << formats.column_bits
        mirrored = (header["mirror"] != 0) & (fields["column"] > 0)
        fields["column"] = fields["column"] - turn * mirrored
        fields["step"] = signed(fields["step"], formats.column_bits)
        sent = header["has_second"] != 0 if edge == "second" else np.ones(size, bool)
        # An edge that is not there has the height of one that does not move.
        fields["decrement"] = np.where(sent, fields["decrement"], -1)
        edges[edge] = fields
    orders = packets["orders"][:, None] >> (2 * np.arange(channels)) & 3
    raw = decoded.differences.view(np.int64).reshape(size, channels, 6)
    return Primitives(
        np.arange(size),
        header,
        edges,
        np.minimum(orders, np.array(formats.channel_max_order)),
        signed(raw, formats.word_width),
        np.zeros((size, channels)),
        np.zeros(size, np.bool_),
    )


def signed(values: np.ndarray, bits: int) -> np.ndarray:
    """Two's complement of some bits, sign extended."""
    half = 1 << (bits - 1)
    return ((values + half) & (2 * half - 1)) - half
