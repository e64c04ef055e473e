# SPDX-License-Identifier: Apache-2.0
"""Hatching: strokes in layers, the darker the picture the more of them (luminance-indexed strokes)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Weights of red, green and blue (ITU-R BT.709)."""

PAPER, INK = 255, 24


@dataclass(frozen=True)
class Layer:
    """
    Parallel strokes.

    Attributes
    ----------
    below : float
      Luminance, 0 .. 1, under which the strokes begin; at ``full`` they have their whole width.
    full : float
    angle : float
      Degrees, counter-clockwise from the scanline.
    spacing : float
      Pixels between the strokes' middles.
    width : float
      Pixels of a stroke at its widest.
    """

    below: float
    full: float
    angle: float
    spacing: float
    width: float


LAYERS = (
    Layer(0.80, 0.45, 40.0, 6.0, 1.7),
    Layer(0.52, 0.25, -35.0, 6.0, 1.7),
    Layer(0.30, 0.10, 5.0, 5.0, 1.7),
    Layer(0.14, 0.02, 85.0, 4.0, 1.8),
)
"""From light to dark; each is drawn over those before it."""


def luminance(picture: np.ndarray) -> np.ndarray:
    """(h, w) float64 luminance, 0 .. 1, of a (h, w, 3) uint8 picture."""
    return picture @ LUMINANCE / 255


def stroke_texture(height: int, width: int, layer: Layer) -> np.ndarray:
    """
    Distance of every pixel's centre from the middle of its stroke.

    Strokes waver by a slow sine of their own phase, so that they look drawn; the same size of a picture
    always gives the same strokes.

    Returns
    -------
    (height, width) float64
      Pixels, 0 .. spacing / 2.
    """
    y, x = np.mgrid[:height, :width] + 0.5
    angle = np.radians(layer.angle)
    along, across = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
    stroke = np.floor(across / layer.spacing)
    # A hash of the stroke's number: phases that do not repeat over a picture.
    phase = np.modf(np.abs(np.sin(stroke * 12.9898 + layer.angle)) * 43758.5453)[0] * 2 * np.pi
    across = across + 0.35 * np.sin(along / 17 + phase)
    return np.abs(np.mod(across, layer.spacing) - layer.spacing / 2)


def hatch(
    picture: np.ndarray, covered: np.ndarray, paper: tuple[int, int, int] = (PAPER, PAPER, PAPER)
) -> np.ndarray:
    """
    A picture as strokes of ink on paper.

    Parameters
    ----------
    picture : (h, w, 3) uint8
      Any shading.
    covered : (h, w) bool
      Where there is something to hatch; elsewhere is paper.
    paper : 3 ints
      0 .. 255.

    Returns
    -------
    (h, w, 3) uint8
    """
    tone = luminance(picture)
    height, width = tone.shape
    ink = np.zeros(tone.shape)
    for layer in LAYERS:
        wide = np.clip((layer.below - tone) / (layer.below - layer.full), 0, 1) * layer.width / 2
        # Half a pixel's ramp at the stroke's border: strokes are smooth, and vanish where they are thin.
        cover = np.clip(wide + 0.5 - stroke_texture(height, width, layer), 0, 1) * np.minimum(wide * 2, 1)
        ink = np.maximum(ink, cover)
    ink[~covered] = 0
    sheet = np.asarray(paper, dtype=np.float64)
    return np.rint(sheet + ink[..., None] * (INK - sheet)).astype(np.uint8)
