# SPDX-License-Identifier: Apache-2.0
"""The highlight test of Abbas et al. (section 4): shade the centre once more, divide where it differs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.scene.project import Projected, doubled_area
from quadshade.scene.subdivide import refine
from quadshade.shading.lights import Light, default_lights
from quadshade.shading.material import Material
from quadshade.shading.sample import CENTRE, SAMPLE_POINTS, full_scale, reflected

CENTRE_SHARES = np.array([-1, -1, -1, 4, 4, 4]) / 9
"""What I1, I2, I3, I12, I13, I23 contribute to the quadratic at the centre."""
SMALLEST_AREA = 4.0
"""Pixels; smaller triangles are not divided."""


def centre_error(
    projected: Projected,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
) -> np.ndarray:
    """
    Difference between the quadratic through six samples and the true shading at triangles' centres.

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights, optional
      By default those that go with the viewer.
    material : Material, optional
    formats : Formats, optional

    Returns
    -------
    (n,) float64
      The largest over the channels, in output units.
    """
    formats = Formats() if formats is None else formats
    material = Material() if material is None else material
    lights = default_lights(projected.axes) if lights is None else lights
    points = np.concatenate([SAMPLE_POINTS, CENTRE])
    value = full_scale(reflected(projected, np.arange(len(projected)), points, lights, material), formats)
    return abs(np.einsum("nkc,k->nc", value[:, :6], CENTRE_SHARES) - value[:, 6]).max(axis=1, initial=0)


def centre_subdivision(
    projected: Projected,
    threshold: float,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    max_depth: int = 6,
) -> tuple[Projected, np.ndarray]:
    """
    Divide triangles into four until the quadratic is right at every centre.

    Parameters
    ----------
    projected : Projected
    threshold : float
      Allowed difference in output units.
    lights, material, formats
      As for :func:`centre_error`.
    max_depth : int
      Divisions of a triangle at most; triangles of less than ``SMALLEST_AREA`` are not divided either.

    Returns
    -------
    projected : Projected
    root : (m,) int64
      The triangle that each part is of.
    """
    formats = Formats() if formats is None else formats
    smallest = 2 * SMALLEST_AREA * 4.0**formats.subpixel_bits
    root = np.arange(len(projected))
    for _ in range(max_depth):
        wanted = abs(doubled_area(projected.vertices)) >= smallest
        wanted &= centre_error(projected, lights, material, formats) > threshold
        if not wanted.any():
            break
        projected, parent = refine(projected, wanted)
        root = root[parent]
    return projected, root
