# SPDX-License-Identifier: Apache-2.0
"""Triangles on the screen and the pixels drawn from them: what passes between host, engines and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from quadshade.contract.shade_state import ShadeState


@dataclass
class ScreenTriangles:
    """
    Triangles as the set-up takes them: exact vertices and sampled colours.

    Attributes
    ----------
    width, height : int
      Screen size in pixels; nothing is drawn outside.
    vertices : (n, 3, 2) int64
      x and y in sub-pixels (1 / 2**subpixel_bits pixel), y down; pixel centres lie at half a pixel.
    samples : (n, channels, 6) float64
      I1, I2, I3, I12, I13, I23 in output units (0 .. 255, with shade -255 .. 255): at the vertices, then at
      the middles of the edges (Abbas et al., section 3). A linear channel uses the first three, a constant
      one the first.
    orders : (n, channels) int64
      0 constant, 1 linear, 2 quadratic.
    depth : (n, 3) float64 or None
      Depth at the vertices, 0 (near) .. 2**depth_bits - 1 (far), linear on the screen.
    channels : tuple of str
      Channel names, as long as the channel axis.
    shade : ShadeState or None
      What the shade unit makes of the channels; None: the first three are the colour.
    """

    width: int
    height: int
    vertices: np.ndarray
    samples: np.ndarray
    orders: np.ndarray
    depth: np.ndarray | None
    channels: tuple[str, ...]
    shade: ShadeState | None = None

    def __len__(self) -> int:
        return len(self.vertices)

    def ordered(self, order: np.ndarray) -> ScreenTriangles:
        """The same triangles in another order, or a part of them: (m,) int indices."""
        depth = None if self.depth is None else self.depth[order]
        return replace(
            self, vertices=self.vertices[order], samples=self.samples[order], orders=self.orders[order],
            depth=depth,
        )  # fmt: skip

    def followed_by(self, others: Sequence[ScreenTriangles]) -> ScreenTriangles:
        """These triangles and then others, of the same screen, channels and shade unit's state."""
        if not others:
            return self
        every = (self, *others)
        depth = None if self.depth is None else np.concatenate([one.depth for one in every])
        vertices, samples, orders = (
            np.concatenate([getattr(one, name) for one in every])
            for name in ("vertices", "samples", "orders")
        )
        return replace(self, vertices=vertices, samples=samples, orders=orders, depth=depth)


@dataclass
class Pixels:
    """
    Pixels in the order in which the engine emits them.

    Attributes
    ----------
    triangle : (n,) int32
      Index of the triangle that drew the pixel.
    x, y : (n,) int32
    value : (n, channels) int32
      Of every channel, or with shade of red, green and blue; rounded and clamped to 0 .. 2**value_bits - 1.
    depth : (n,) int32 or None
    """

    triangle: np.ndarray
    x: np.ndarray
    y: np.ndarray
    value: np.ndarray
    depth: np.ndarray | None

    def __len__(self) -> int:
        return len(self.x)


@dataclass
class Drawing:
    """
    What an engine returns.

    Attributes
    ----------
    pixels : Pixels
    stats : dict
      ``engine``, ``clocks`` (first set-up word accepted to last pixel out, stream always valid, sink always
      ready), ``pixels``, ``triangles`` (all that were given), ``triangles_drawn`` (by at least one packet),
      ``packets``, ``words`` (of 32 bits), ``bound`` (grey levels, before rounding to a whole one) and
      ``triangles_undefined`` (by the set-up method; drawn as 0).
    """

    pixels: Pixels
    stats: dict[str, Any]
