# SPDX-License-Identifier: Apache-2.0
"""
Subdivision by name, for an axis of a sweep.

``none``          the mesh as it is
``all:K``         every triangle divided into four, K times
``highlights:A``  Cho, Neumann and Woo, section 3.2: highlighted triangles and their neighbours, until their
                  area is below A pixels
``centre:E``      Abbas et al., section 4: triangles whose centre is more than E grey levels wrong
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quadshade.adapt import centre_subdivision, refine, regular_subdivision
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.scene import Projected
from quadshade.shading import DirectionalLight, Light, Material, PointLight, default_lights

WHOLE = "none"
LIMITS = {"all": (1.0, 4.0), "highlights": (1.0, 1e6), "centre": (0.25, 255.0)}
"""Smallest and largest number behind each name."""


def check_subdivision(text: str) -> tuple[str, float]:
    """
    Name and number of a subdivision.

    Raises
    ------
    QuadshadeError
      There is no such subdivision, or its number is out of range.
    """
    name, _, number = text.partition(":")
    if text == WHOLE:
        return WHOLE, 0.0
    try:
        value = float(number)
        lowest, highest = LIMITS[name]
    except (KeyError, ValueError):
        raise QuadshadeError(
            f"the subdivision is {text!r}", "write none, all:1, highlights:32 or centre:4, say"
        ) from None
    if not lowest <= value <= highest or (name == "all" and value != int(value)):
        raise QuadshadeError(f"the subdivision is {text!r}", f"give a number from {lowest:g} to {highest:g}")
    return name, value


def subdivide(
    projected: Projected,
    subdivision: str,
    lights: Sequence[Light] | None,
    material: Material,
    formats: Formats,
) -> Projected:
    """
    A mesh on the screen, divided.

    Parameters
    ----------
    projected : Projected
    subdivision : str
    lights : sequence of lights or None
      None for those that go with the viewer.
    material : Material
    formats : Formats
      Gives the sub-pixel bits.

    Returns
    -------
    Projected

    Raises
    ------
    QuadshadeError
      There is no such subdivision.
    """
    name, value = check_subdivision(subdivision)
    lights = default_lights(projected.axes) if lights is None else lights
    if name == "all":
        for _ in range(int(value)):
            projected, _ = refine(projected, np.ones(len(projected), dtype=bool))
    elif name == "highlights":
        shining = [light for light in lights if isinstance(light, DirectionalLight | PointLight)]
        projected = regular_subdivision(projected, shining, value, formats).projected
    elif name == "centre":
        projected, _ = centre_subdivision(projected, value, lights, material, formats)
    return projected
