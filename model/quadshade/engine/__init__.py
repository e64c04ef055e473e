# SPDX-License-Identifier: Apache-2.0
"""Engines that draw: the golden model, or the RTL in a simulator. All give the same pixels and clocks."""

from quadshade.engine.draw import ENGINES, default_engine, draw, draw_words

__all__ = ["ENGINES", "default_engine", "draw", "draw_words"]
