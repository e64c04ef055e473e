# SPDX-License-Identifier: Apache-2.0
"""
A teapot after Martin Newell's: 28 bicubic patches (without a bottom), as triangles with exact normals.

Rim, body and lid are an outline turned about the vertical in four quarters; handle and spout are two rows of
curves each, as deep as the width says, mirrored. At 4 x 4 quadrilaterals a patch it has 896 triangles.
"""

from __future__ import annotations

import numpy as np

from quadshade.scene.mesh import Mesh

QUARTER = 0.56
"""How far a quarter's inner control points lie along its tangents, over the radius."""
OUTLINE = (
    ((1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)),
    ((1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)),
    ((2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)),
    ((0.0, 3.15), (0.8, 3.15), (0.0, 2.7), (0.2, 2.55)),
    ((0.2, 2.55), (0.4, 2.4), (1.3, 2.4), (1.3, 2.25)),
)
"""Radius and height, four control points a patch: rim, body, lid."""
SIDES = (
    # Handle: inner and outer curve, upper and lower half; each from the body.
    ((-1.6, 2.025), (-2.3, 2.025), (-2.7, 2.025), (-2.7, 1.8)),
    ((-1.5, 2.25), (-2.5, 2.25), (-3.0, 2.25), (-3.0, 1.8)),
    ((-2.7, 1.8), (-2.7, 1.575), (-2.5, 1.125), (-2.0, 0.9)),
    ((-3.0, 1.8), (-3.0, 1.35), (-2.65, 0.9375), (-1.9, 0.6)),
    # Spout: upper and lower curve, root and tip.
    ((1.7, 1.425), (2.6, 1.425), (2.3, 2.1), (2.7, 2.4)),
    ((1.7, 0.6), (3.1, 0.825), (2.4, 2.025), (3.3, 2.4)),
    ((2.7, 2.4), (2.8, 2.475), (2.9, 2.475), (2.8, 2.4)),
    ((3.3, 2.4), (3.525, 2.49375), (3.45, 2.5125), (3.2, 2.4)),
)
WIDTHS = ((0.3,) * 4, (0.3,) * 4, (0.66, 0.66, 0.25, 0.25), (0.25, 0.25, 0.15, 0.15))
"""In y, of the four patches' control points."""


def patches() -> np.ndarray:
    """(28, 4, 4, 3) control points, z up; the first direction times the second points outwards."""
    made = []
    turn = np.array([[1.0, 0.0], [1.0, QUARTER], [QUARTER, 1.0], [0.0, 1.0]])
    for curve in np.array(OUTLINE):
        height = np.broadcast_to(curve[:, None, 1:], (4, 4, 1))
        quarter = np.concatenate([curve[:, None, :1] * turn, height], axis=-1)
        for _ in range(4):
            made.append(quarter)
            quarter = np.stack([-quarter[..., 1], quarter[..., 0], quarter[..., 2]], axis=-1)
    for one, other, width in zip(np.array(SIDES[::2]), np.array(SIDES[1::2]), np.array(WIDTHS), strict=True):
        curves = ((one, 0 * width), (one, width), (other, width), (other, 0 * width))
        points = [np.stack([curve[:, 0], side, curve[:, 1]], axis=-1) for curve, side in curves]
        half = np.stack(points, axis=1)
        made += [half, half[:, ::-1] * (1, -1, 1)]
    return np.array(made)


def teapot(parts: int = 4) -> Mesh:
    """
    The teapot as triangles.

    Parameters
    ----------
    parts : int
      Quadrilaterals a patch, each way.

    Returns
    -------
    Mesh
      56 parts^2 triangles, y up; those at the lid's top (a patch's side of no length) have no area.
    """
    t = np.linspace(0, 1, parts + 1)
    value = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    slope = 3 * np.stack([-((1 - t) ** 2), (1 - t) * (1 - 3 * t), t * (2 - 3 * t), t**2])
    control = patches()[..., [0, 2, 1]] * (1, 1, -1)

    def surface(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return np.einsum("iu,jv,pijx->puvx", first, second, control)

    normal = np.cross(surface(slope, value), surface(value, slope)).reshape(-1, 3)
    length = np.linalg.norm(normal, axis=1)
    normal[length < 1e-9] = 0, 1, 0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # Patches meet in the same vertices.
    points, index = np.unique(surface(value, value).reshape(-1, 3).round(9), axis=0, return_inverse=True)
    corner = np.arange(len(normal)).reshape(-1, parts + 1, parts + 1)
    here, down, right, across = corner[:, :-1, :-1], corner[:, 1:, :-1], corner[:, :-1, 1:], corner[:, 1:, 1:]
    faces = np.concatenate(
        [np.stack([here, down, right], axis=-1), np.stack([right, down, across], axis=-1)]
    ).reshape(-1, 3)
    return Mesh(points, index.reshape(-1)[faces], normal[faces])
