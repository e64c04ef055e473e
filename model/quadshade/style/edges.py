# SPDX-License-Identifier: Apache-2.0
"""
Edges of a G-buffer over a picture (Nienhaus and Döllner, *Edge-Enhancement*, 4.1.2 and 4.2).

Profile edges are discontinuities of depth, inner edges those of normals; both stay apart until they are
blended, so each can have a colour of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from quadshade.choices import EDGE_KINDS, EDGE_VARIANTS
from quadshade.errors import QuadshadeError
from quadshade.golden.screen.edge_map import DIAGONAL, EIGHT, edge_map
from quadshade.style.gbuffer import GBuffer

VARIANTS = dict(zip(EDGE_VARIANTS, (DIAGONAL, EIGHT), strict=True))

PROFILE_RANGE = {"diagonal": (0.06, 0.14), "eight": (0.07, 0.15)}
"""Depth's edge intensity, 0 without an edge, from which an edge begins to show, and is fully drawn."""

INNER_RANGE = (0.12, 0.30)
"""The same of normals: 1 - ½((A.H) + (C.F)). A crease of 35 degrees is 0.18 where both products cross it."""

INK = {"profile": (0.0, 0.0, 0.0), "inner": (0.15, 0.15, 0.15)}
"""Default colours of the edges, 0 .. 1."""


@dataclass(frozen=True)
class EdgeMaps:
    """
    Raw intensities of an edge map, as the hardware gives them.

    Attributes
    ----------
    normal, depth : (h, w) uint8
    variant : str
      ``diagonal`` or ``eight``.
    """

    normal: np.ndarray
    depth: np.ndarray
    variant: str

    def intensity(self, kind: str) -> np.ndarray:
        """(h, w) float64, 0 (none) to 1: how much of a ``profile`` or ``inner`` edge a pixel has."""
        if kind == "inner":
            return 1 - self.normal / 255
        return self.depth / 255 if self.variant == "eight" else 1 - self.depth / 255

    def strength(self, kind: str, ramp: tuple[float, float] | None = None) -> np.ndarray:
        """
        How strongly an edge is drawn at every pixel.

        Parameters
        ----------
        kind : str
          ``profile`` (from depth) or ``inner`` (from normals).
        ramp : (low, high), optional
          Intensity at which an edge begins, and is fully drawn; by default ``PROFILE_RANGE`` or
          ``INNER_RANGE``.

        Returns
        -------
        (h, w) float64
          0 .. 1.
        """
        low, high = ramp or (INNER_RANGE if kind == "inner" else PROFILE_RANGE[self.variant])
        return np.clip((self.intensity(kind) - low) / (high - low), 0, 1)


def find_edges(gbuffer: GBuffer, variant: str = "diagonal") -> EdgeMaps:
    """
    The edge map of a G-buffer, by the golden model: the bytes that the hardware gives.

    Raises
    ------
    QuadshadeError
      An unknown variant, or a picture narrower than three pixels.
    """
    if variant not in VARIANTS:
        raise QuadshadeError(f"the edge variant is {variant!r}", f"give {' or '.join(VARIANTS)}")
    maps = edge_map(gbuffer.normal, gbuffer.depth, gbuffer.depth_bits, VARIANTS[variant])
    return EdgeMaps(*maps, variant)


def parse_kinds(text: str) -> tuple[str, ...]:
    """Kinds of edges of ``profile,inner``; raises :class:`QuadshadeError` for any other."""
    kinds = tuple(dict.fromkeys(kind.strip() for kind in text.split(",")))
    if not kinds or not set(kinds) <= set(EDGE_KINDS):
        raise QuadshadeError(f"the edges are {text!r}", f"give {', '.join(EDGE_KINDS)}, or both with a comma")
    return kinds


def draw_edges(
    picture: np.ndarray,
    maps: EdgeMaps,
    kinds: Sequence[str] = EDGE_KINDS,
    colours: Mapping[str, Sequence[float]] | None = None,
) -> np.ndarray:
    """
    Blend edges over a picture, inner edges first.

    Parameters
    ----------
    picture : (h, w, 3) uint8
    maps : EdgeMaps
    kinds : sequence of str
      ``profile``, ``inner``.
    colours : dict of 3 floats, optional
      0 .. 1 by kind; by default ``INK``.

    Returns
    -------
    (h, w, 3) uint8
    """
    blended = picture.astype(np.float64)
    for kind in reversed(EDGE_KINDS):
        if kind in kinds:
            ink = 255 * np.asarray((colours or {}).get(kind, INK[kind]), dtype=np.float64)
            strength = maps.strength(kind)[..., None]
            blended += strength * (ink - blended)
    return np.rint(blended).astype(np.uint8)
