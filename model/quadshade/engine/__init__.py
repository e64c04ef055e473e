# SPDX-License-Identifier: Apache-2.0
"""Engines that draw: the golden model, or the RTL in a simulator. All give the same pixels and clocks."""

from quadshade.choices import ENGINES
from quadshade.engine.draw import default_engine, draw, draw_words

__all__ = ["ENGINES", "default_engine", "draw", "draw_words"]
