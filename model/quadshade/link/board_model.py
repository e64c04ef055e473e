# SPDX-License-Identifier: Apache-2.0
"""A board in this process: the golden model of the whole board, behind bytes of a serial line."""

from quadshade.golden.board import BoardModel

__all__ = ["BoardModel"]
