# SPDX-License-Identifier: Apache-2.0
"""What a board has and knows, by the fields of HELLO's answer."""

from __future__ import annotations

from collections.abc import Mapping

from quadshade.contract.protocol import COLOUR_BITS, EDGE_BYTES, FEATURES, OPTIONAL, Opcode


def has_feature(identity: Mapping[str, int], name: str) -> bool:
    """Whether a board has a feature of :data:`FEATURES`, by HELLO's fields."""
    return bool(identity["features"] >> FEATURES.index(name) & 1)


def knows(identity: Mapping[str, int], opcode: Opcode) -> bool:
    """Whether a board knows a request, by HELLO's fields."""
    return opcode not in OPTIONAL or has_feature(identity, OPTIONAL[opcode])


def colour_bits(identity: Mapping[str, int]) -> int:
    """Bits that a board keeps of a colour, by HELLO's fields."""
    return min(bits for bits, name in COLOUR_BITS.items() if not name or has_feature(identity, name))


def plane_bytes(identity: Mapping[str, int]) -> tuple[int, ...]:
    """Bytes of a pixel in every plane of a board, by HELLO's fields; 0 where there is no such plane."""
    edges = EDGE_BYTES * has_feature(identity, "edge_map")
    return identity["colour_bytes"], identity["depth_bytes"], edges, edges
