# SPDX-License-Identifier: Apache-2.0
"""
What host and hardware agree on: formats, packed format, protocol, shade state, triangles.

It imports nothing else of the project but the errors.
"""

__all__ = [
    "arrays",
    "formats",
    "packed_format",
    "protocol",
    "releases",
    "shade_state",
    "triangles",
    "width_expressions",
]
