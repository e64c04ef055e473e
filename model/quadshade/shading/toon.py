# SPDX-License-Identifier: Apache-2.0
"""Cartoon shading through the shade unit's tables: light in steps, highlights with a sharp border."""

from __future__ import annotations

import numpy as np

from quadshade.contract.shade_state import Curve
from quadshade.errors import QuadshadeError

MAX_STEPS = 64
BORDER = 0.5
"""A highlight ends where its intensity falls below this."""


def toon_curves(steps: int, exponent: float, border: float = BORDER) -> tuple[Curve, Curve]:
    """
    Curves for :func:`quadshade.shading.sample_specular`.

    Parameters
    ----------
    steps : int
      Levels of diffuse light, 2 to 64, equally wide in the cosine and equally far apart, 0 and 1 among them.
    exponent : float
      Specular exponent.
    border : float
      Intensity of the smooth highlight where the flat one ends, 0 < border <= 1.

    Returns
    -------
    two callables
      Of the diffuse and the specular cosines. A jump becomes a ramp over one interval of the table, at most
      1/32 of the distance from a cosine of 1.

    Raises
    ------
    QuadshadeError
      A number out of range.
    """
    if not 2 <= steps <= MAX_STEPS:
        raise QuadshadeError(f"toon shading with {steps} steps", f"give 2 to {MAX_STEPS}")
    if not 0 < border <= 1:
        raise QuadshadeError(f"a highlight's border of {border:g}", "give a number above 0, at most 1")

    def diffuse(cosine: np.ndarray) -> np.ndarray:
        return np.minimum(np.floor(cosine * steps), steps - 1) / (steps - 1)

    def specular(cosine: np.ndarray) -> np.ndarray:
        return (cosine**exponent >= border).astype(np.float64)

    return diffuse, specular
