# SPDX-License-Identifier: Apache-2.0
"""
Mach bands, measured: how far the intensity's first derivative jumps across the edges of a mesh.

The eye sees such a jump as a light or dark line (Phong, "Illumination for Computer Generated Pictures"). It
is taken in float at right angles to shared edges, in grey levels per pixel, for every shading.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from quadshade.adapt.centre_test import centre_subdivision
from quadshade.contract.formats import Formats
from quadshade.scene import Projected, load_scene, parse_camera, project
from quadshade.scene.subdivide import CORNERS, shared_edges
from quadshade.shading import Material, default_lights, sample
from quadshade.shading.lights import DirectionalLight
from quadshade.shading.reference import polynomial
from quadshade.shading.sample import full_scale, reflected

SHADINGS = ("gouraud", "quadratic", "quadratic-specular", "adaptive", "phong")
SCENES = ("sphere:168", "sphere:374", "sphere:690", "torus:288")
EXPONENTS = (5.0, 50.0)
ALLOWED = 2.0
"""Grey levels at a triangle's centre beyond which ``adaptive`` divides it (Abbas et al., section 4)."""
PLACES = (np.arange(8) + 0.5) / 8
"""Where along an edge."""
REACH = 0.25
"""Pixels between the three points of a one-sided derivative, exact for quadratics."""
FACING = 0.5
"""Edges count whose triangles' normals are within 60 degrees of the viewer."""
GREY = (0.6, 0.6, 0.6)

Shade = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Grey levels at (m, 3) barycentric coordinates of (m,) triangles."""


def material_of(exponent: float) -> Material:
    """A grey material, so that one channel says all."""
    return Material(colour=GREY, exponent=exponent)


def view(scene: str, size: int, degrees: float = 0.0) -> Projected:
    """A scene seen from infinitely far, as in the paper's figures, turned about the vertical."""
    turn = np.radians(degrees)
    mesh = load_scene(scene)
    tall = "1.05" if scene.startswith("sphere") else "1.5"
    camera = parse_camera(f"from={np.sin(turn)},0.4,{np.cos(turn)},ortho={tall}", mesh)
    return project(mesh, camera, size, size)


def shades(projected: Projected, exponent: float) -> dict[str, Shade]:
    """All shadings in float, of one channel; none is clamped or rounded."""
    material, lights = material_of(exponent), default_lights(projected.axes)
    formats = Formats()

    def through_samples(shading: str) -> Shade:
        triangles = sample(projected, shading, lights, material)
        return lambda owner, weights: polynomial(
            triangles.samples[owner, :1], triangles.orders[owner, :1], weights
        )[:, 0]

    def by_phong(owner: np.ndarray, weights: np.ndarray) -> np.ndarray:
        return full_scale(reflected(projected, owner, weights[:, None], lights, material)[:, 0, 0], formats)

    return {
        "gouraud": through_samples("gouraud"),
        "quadratic": through_samples("quadratic"),
        "quadratic-specular": by_cosines(projected, material),
        "phong": by_phong,
    }


def by_cosines(projected: Projected, material: Material) -> Shade:
    """
    N . L and N . H as quadratics, the specular power taken at the pixel (Barrera et al., section 5).

    Of the default lights, under which the material's terms are multiplied by one white light each.
    """
    light = next(one for one in default_lights(projected.axes) if isinstance(one, DirectionalLight))
    half = np.array(light.direction) / np.linalg.norm(light.direction) + projected.axes[2]
    half /= np.linalg.norm(half)

    def cosines(point: np.ndarray, normal: np.ndarray, to_light: np.ndarray, to_viewer: np.ndarray):
        return np.stack([normal @ to_light[0], normal @ half, np.zeros(len(normal))], axis=1)

    # Cosines may be negative, samples not: half of each, half a unit up.
    lifted = Material(reflectance=lambda *vectors: 0.5 + 0.5 * cosines(*vectors))
    triangles = sample(projected, "quadratic", [light], lifted)
    top = 2.0 ** Formats().value_bits - 1

    def shade(owner: np.ndarray, weights: np.ndarray) -> np.ndarray:
        lifted_cosines = polynomial(triangles.samples[owner, :2], triangles.orders[owner, :2], weights)
        facing, towards = (2 * lifted_cosines / top - 1).T
        specular = np.where((facing > 0) & (towards > 0), np.clip(towards, 0, 1) ** material.exponent, 0)
        base = material.ambient[0] + np.maximum(facing, 0) * material.diffuse[0]
        return (base * material.colour[0] + specular * material.specular[0]) * top

    return shade


def interior_edges(projected: Projected) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Edges between two triangles that are smooth there: (e, 2) triangles, (e, 2, 2) ends, (e, 2, 2) thirds.

    Ends and third corners (one of each triangle) in pixels.
    """
    edges = shared_edges(projected.vertices)
    flat = edges.index.reshape(-1)
    order = np.argsort(flat, kind="stable")
    counts = np.bincount(flat, minlength=len(edges))
    starts = np.cumsum(counts) - counts
    pairs = np.stack([order[starts[counts == 2]], order[starts[counts == 2] + 1]], axis=1)
    owner, side = pairs // 3, pairs % 3
    corners = np.array(CORNERS)[side]
    turned = edges.reversed.reshape(-1)[pairs]
    corners = np.where(turned[..., None], corners[..., ::-1], corners)
    normals = projected.normal[owner[..., None], corners]
    smooth = np.abs(normals[:, 0] - normals[:, 1]).max(axis=(1, 2)) < 1e-9
    place = projected.vertices / 256.0
    ends = place[owner[:, :1], corners[:, 0]]
    third = place[owner, 3 - corners.sum(axis=2)]
    # Towards the silhouette any shading is as steep as the surface.
    keep = smooth & (projected.normal @ projected.axes[2] > FACING).all(axis=1)[owner].all(axis=1)
    return owner[keep], ends[keep], third[keep]


def barycentric(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(m, 3) weights of points (m, 2) in triangles (m, 3, 2), in pixels."""
    legs, off = corners[:, 1:] - corners[:, :1], points - corners[:, 0]
    area = legs[:, 0, 0] * legs[:, 1, 1] - legs[:, 0, 1] * legs[:, 1, 0]
    second = (off[:, 0] * legs[:, 1, 1] - off[:, 1] * legs[:, 1, 0]) / area
    third = (legs[:, 0, 0] * off[:, 1] - legs[:, 0, 1] * off[:, 0]) / area
    return np.stack([1 - second - third, second, third], axis=1)


def jumps(projected: Projected, shade: Shade) -> dict[str, float]:
    """Jump of the derivative across shared edges, in grey levels per pixel, and of the value itself."""
    owner, ends, third = interior_edges(projected)
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / length[:, None]
    # Into the first triangle of each pair.
    facing = np.sign(((third[:, 0] - ends[:, 0]) * across).sum(axis=1))
    across *= facing[:, None]
    corners = projected.vertices / 256.0
    slope, value = np.zeros((2, len(owner), len(PLACES))), np.zeros((2, len(owner), len(PLACES)))
    for column, share in enumerate(PLACES):
        start = ends[:, 0] + share * along
        for side, sign in ((0, 1.0), (1, -1.0)):
            own = owner[:, side]
            near, middle, far = (
                shade(own, barycentric(corners[own], start + sign * step * REACH * across))
                for step in (0, 1, 2)
            )
            value[side, :, column] = near
            slope[side, :, column] = sign * (4 * middle - 3 * near - far) / (2 * REACH)
    jump = np.abs(slope[0] - slope[1])
    weight = np.repeat(length, len(PLACES))
    return {
        "edges": len(owner),
        "rms": float(np.sqrt(np.average(jump.ravel() ** 2, weights=weight))),
        "mean": float(np.average(jump.ravel(), weights=weight)),
        "p95": float(np.percentile(jump, 95)),
        "largest": float(jump.max()),
        "value_jump": float(np.abs(value[0] - value[1]).max()),
    }


def mach_bands(size: int, scenes: tuple[str, ...]) -> list[dict]:
    """Records of every scene, exponent and shading."""
    rows = []
    for scene in scenes:
        for exponent in EXPONENTS:
            projected = view(scene, size)
            divided, _ = centre_subdivision(projected, ALLOWED, None, material_of(exponent))
            functions = {name: (projected, shade) for name, shade in shades(projected, exponent).items()}
            functions["adaptive"] = divided, shades(divided, exponent)["quadratic"]
            for shading in SHADINGS:
                drawn, shade = functions[shading]
                rows.append(
                    {
                        "scene": scene,
                        "exponent": exponent,
                        "shading": shading,
                        "size": size,
                        "triangles": len(drawn),
                    }
                    | jumps(drawn, shade)
                )
    return rows
