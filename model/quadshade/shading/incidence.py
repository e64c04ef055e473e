# SPDX-License-Identifier: Apache-2.0
"""
W(i) of Phong's shading function: how much light a surface mirrors, over the angle at which it arrives.

B. T. Phong, *Illumination for Computer Generated Pictures*, equation 3; he gives 10 to 80 percent, adjusted
to the picture. A table does that; Fresnel's curve is that of a smooth dielectric.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from quadshade.errors import QuadshadeError

Incidence = Callable[[np.ndarray], np.ndarray]
"""Cosines of incident angles, (m,) in (0, 1], to shares, (m,) in [0, 1]."""

LARGEST_TABLE = 64
"""Most numbers of a table."""


def table_curve(shares: Sequence[float]) -> Incidence:
    """
    W(i) through numbers at equal steps of the angle, linear between them.

    Parameters
    ----------
    shares : 2 to 64 floats
      0 .. 1, from light along the normal (0 degrees) to grazing light (90 degrees).

    Returns
    -------
    callable
      See :data:`Incidence`.

    Raises
    ------
    QuadshadeError
      A number out of range, or a wrong count of them.
    """
    table = np.asarray(shares, dtype=np.float64)
    if not 2 <= len(table) <= LARGEST_TABLE:
        raise QuadshadeError(f"the material's w has {len(table)} numbers", f"give 2 to {LARGEST_TABLE}")
    if not ((table >= 0) & (table <= 1)).all():
        raise QuadshadeError(f"the material's w is {shares}", "give shares from 0 to 1")
    angles = np.linspace(0, np.pi / 2, len(table))

    def share(cosine: np.ndarray) -> np.ndarray:
        return np.interp(np.arccos(np.clip(cosine, 0, 1)), angles, table)

    return share


def fresnel_curve(index: float) -> Incidence:
    """
    W(i) of a smooth dielectric in air, for unpolarised light: the mean of Fresnel's two reflectances.

    Parameters
    ----------
    index : float
      Index of refraction, 1 to 10; glass has about 1.5.

    Returns
    -------
    callable
      See :data:`Incidence`.

    Raises
    ------
    QuadshadeError
      An index out of range.
    """
    if not 1 <= index <= 10:
        raise QuadshadeError(f"the material's fresnel is {index:g}", "give an index of refraction, 1 to 10")

    def share(cosine: np.ndarray) -> np.ndarray:
        inside = np.sqrt(1 - (1 - cosine**2) / index**2)
        across = (cosine - index * inside) / (cosine + index * inside)
        along = (inside - index * cosine) / (inside + index * cosine)
        return (across**2 + along**2) / 2

    return share
