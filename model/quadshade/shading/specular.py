# SPDX-License-Identifier: Apache-2.0
"""
Diffuse and specular cosines at six points of every triangle, for the power that the hardware takes per pixel.

Barrera, Hast and Bengtsson interpolate N.L and N.H apart and raise the second to the exponent at every pixel.
A light has one channel of each; where N.L is not positive its specular channel counts nothing, as in Phong's
function.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from quadshade.choices import SPECULAR_ORDERS
from quadshade.contract.formats import CONSTANT, LINEAR, QUADRATIC, SHADED_COLOURS, Formats
from quadshade.contract.shade_state import (
    COEFFICIENT_LIMIT,
    Curve,
    ShadeState,
    power_curve,
    shade_state,
    specular_gain,
)
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.scene.project import Projected
from quadshade.shading.lights import AmbientLight, Light, PointedLight, PointLight, default_lights
from quadshade.shading.material import Material, dot
from quadshade.shading.sample import (
    CHUNK,
    SAMPLE_POINTS,
    TAYLOR_POINTS,
    TAYLOR_SHARES,
    middle_normals,
    surface,
)

MAX_CHANNELS = 8
EXPONENTS = (1, 1024)


class UnsuitedError(QuadshadeError):
    """A scene that the shade unit cannot draw: its colours have to be interpolated instead."""


def specular_lights(projected: Projected, lights: Sequence[Light], material: Material) -> list[PointedLight]:
    """
    The lights that need a pair of channels each.

    Raises
    ------
    UnsuitedError
      A surface or lights that two cosines for each light do not describe.
    """
    if material.reflectance is not None:
        raise UnsuitedError("the reflectance is the user's own")
    if material.incidence is not None:
        raise UnsuitedError("the material's W varies with the incident angle")
    if projected.colour is not None:
        raise UnsuitedError("the mesh has colours of its own")
    if not EXPONENTS[0] <= material.exponent <= EXPONENTS[1]:
        raise UnsuitedError(f"the exponent {material.exponent:g} is not in {EXPONENTS[0]} .. {EXPONENTS[1]}")
    pointed = [light for light in lights if not isinstance(light, AmbientLight)]
    if not pointed:
        raise UnsuitedError("all light is ambient")
    if 2 * len(pointed) > MAX_CHANNELS:
        raise UnsuitedError(f"{len(pointed)} lights need {2 * len(pointed)} channels of {MAX_CHANNELS}")
    return pointed


def specular_formats(
    generics: dict[str, int],
    projected: Projected,
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    through_tables: bool = False,
) -> Formats:
    """
    Formats with a shade unit, and a diffuse and a specular channel for each light.

    Parameters
    ----------
    generics : dict of str to int
      Generics that the user has set; they win.
    projected : Projected
    lights : sequence of lights, optional
      By default those that go with the viewer.
    material : Material, optional
    through_tables : bool
      Diffuse channels have a table too: all channels are specular ones.

    Returns
    -------
    Formats

    Raises
    ------
    UnsuitedError
      A scene for which it takes colour channels.
    QuadshadeError
      A wrong generic.
    """
    material = Material() if material is None else material
    lights = default_lights(projected.axes) if lights is None else lights
    count = len(specular_lights(projected, lights, material))
    fitted = {"with_shade": 1, "num_channels": 2 * count, "num_specular": count * (1 + through_tables)}
    formats = Formats().with_generics(fitted | generics)
    if not formats.with_shade:
        raise UnsuitedError("generic with_shade is 0")
    if through_tables:
        if formats.num_channels < 2 * count or formats.num_specular < formats.num_channels:
            raise UnsuitedError(f"{count} lights need {2 * count} channels, all of them with a table")
    elif formats.num_specular < count or formats.num_channels - formats.num_specular < count:
        raise UnsuitedError(
            f"{count} lights need as many diffuse and specular channels; of {formats.num_channels} channels"
            f" {formats.num_specular} are specular"
        )
    return formats


def sample_specular(
    projected: Projected,
    shading: str = "quadratic-specular",
    lights: Sequence[Light] | None = None,
    material: Material | None = None,
    formats: Formats | None = None,
    x_shading: bool = False,
    curves: tuple[Curve, Curve] | None = None,
    taylor: bool = False,
) -> ScreenTriangles:
    """
    Take the diffuse and the specular cosine of each light at the points that a triangle's order needs.

    Parameters
    ----------
    projected : Projected
    shading : str
      ``linear-specular`` (the vertices) or ``quadratic-specular`` (vertices and middles of the edges).
    lights : sequence of lights, optional
      By default those that go with the viewer.
    material : Material, optional
    formats : Formats, optional
      With shade; by default those of :func:`specular_formats`.
    x_shading : bool
      Middles of edges take their normals from :func:`quadshade.shading.sample.middle_normals`.
    curves : two callables, optional
      What diffuse and specular cosines go through, as
      :func:`quadshade.contract.shade_state.curve_table` takes them,
      :func:`quadshade.shading.toon.toon_curves` for example; the formats then have a table for
      every channel (``through_tables``). A highlight on the dark side is then not cut. By default the power.
    taylor : bool
      Values of the cosines' Taylor quadratics at the centre (:mod:`quadshade.shading.taylor`).

    Returns
    -------
    ScreenTriangles
      Channels d0 .. and s0 .., full scale for a cosine of 1, negative ones too; its ``shade`` holds colours
      and power tables. A light that falls off scales d by its intensity a over the largest one, s by the
      exponent's root of that, so that the power has it as a factor.

    Raises
    ------
    UnsuitedError
      A scene for which it takes colour channels.
    """
    if shading not in SPECULAR_ORDERS:
        raise QuadshadeError(f"the shading is {shading!r}", f"give one of {', '.join(SPECULAR_ORDERS)}")
    order = SPECULAR_ORDERS[shading]
    material = Material() if material is None else material
    lights = default_lights(projected.axes) if lights is None else lights
    through_tables = curves is not None
    if formats is None:
        formats = specular_formats({}, projected, lights, material, through_tables)
    pointed = specular_lights(projected, lights, material)
    points = SAMPLE_POINTS[: 3 if order == LINEAR else 6]
    taylor = taylor and order == QUADRATIC
    places = TAYLOR_POINTS if taylor else points
    diffuse, specular, strength = cosines(
        projected, pointed, material, places, x_shading=x_shading and order == QUADRATIC
    )
    if taylor:
        diffuse, specular = (np.clip(values @ TAYLOR_SHARES.T, -1, 1) for values in (diffuse, specular))
    first_specular = len(pointed) if through_tables else formats.num_channels - formats.num_specular
    samples = np.zeros((len(projected), formats.num_channels, len(SAMPLE_POINTS)))
    orders = np.full((len(projected), formats.num_channels), CONSTANT, dtype=np.int64)
    top = (1 << formats.value_bits) - 1
    for first, channels in ((0, diffuse), (first_specular, specular)):
        for index, cosine in enumerate(channels):
            samples[:, first + index, : len(points)] = cosine * top
            orders[:, first + index] = order
    names = [f"d{index}" for index in range(first_specular)]
    others = formats.num_channels - first_specular
    return ScreenTriangles(
        projected.width,
        projected.height,
        projected.vertices,
        samples,
        orders,
        projected.depth if formats.with_depth else None,
        (*names, *(f"s{index}" for index in range(others))),
        specular_state(formats, lights, material, strength, curves),
    )


def specular_state(
    formats: Formats,
    lights: Sequence[Light],
    material: Material,
    strength: np.ndarray,
    curves: tuple[Curve, Curve] | None = None,
    power: bool = True,
    reach: float = 1.0,
) -> ShadeState:
    """
    Colours and tables of the shade unit for a scene.

    Parameters
    ----------
    formats : Formats
    lights : sequence of lights
      Ambient ones too.
    material : Material
    strength : (pointed lights,) float
      From :func:`cosines`.
    curves : two callables, optional
      As for :func:`sample_specular`.
    power : bool
      Without it specular channels skip their tables: they carry the power itself.
    reach : float
      Specular channels carry so many times the cosine: the less, the fewer entries of a table are read, and
      the coarser they are.

    Returns
    -------
    ShadeState

    Raises
    ------
    UnsuitedError
      A light that reflects more than a coefficient holds.
    """
    pointed = [light for light in lights if not isinstance(light, AmbientLight)]
    first_specular = len(pointed) if curves is not None else formats.num_channels - formats.num_specular
    coefficients = np.zeros((formats.num_channels, SHADED_COLOURS))
    for first, colours in zip((0, first_specular), light_colours(pointed, material, strength), strict=True):
        coefficients[first : first + len(pointed)] = colours
    if coefficients.max() >= COEFFICIENT_LIMIT:
        raise UnsuitedError(f"a light reflects {coefficients.max():.3g}, not less than {COEFFICIENT_LIMIT}")
    others = formats.num_channels - first_specular
    if curves is None:
        tables = [power_curve(material.exponent, reach)] * others
    else:
        tables = [curves[0]] * first_specular + [curves[1]] * others
    gated = (1 << len(pointed)) - 1 if curves is None else 0
    if not power:
        # A value of 1 is the lane's largest; that of a table, or of a diffuse channel, is a little less.
        coefficients[first_specular:] /= specular_gain(formats)
    state = shade_state(formats, ambient_colour(lights, material), coefficients, tables, gated)
    if power:
        return state
    nothing = np.zeros((formats.num_specular, 0), dtype=np.uint32)
    return replace(state, tables=nothing, linear=(1 << formats.num_specular) - 1)


def ambient_colour(lights: Sequence[Light], material: Material) -> np.ndarray:
    """(3,) float64 what the surface reflects of ambient light."""
    arriving = (np.asarray(light.colour) for light in lights if isinstance(light, AmbientLight))
    return sum(arriving, np.zeros(3)) * (np.asarray(material.ambient) * material.colour)


def light_colours(
    pointed: Sequence[Light], material: Material, strength: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Two (lights, 3) float64: what the surface reflects of each, diffusely and specularly."""
    arriving = np.array([light.colour for light in pointed]) * strength[:, None]
    return arriving * (np.asarray(material.diffuse) * material.colour), arriving * np.asarray(
        material.specular
    )


def light_strength(projected: Projected, lights: Sequence[PointedLight], points: np.ndarray) -> np.ndarray:
    """(lights,) float64 the largest intensity of each light at (k, 3) points of all triangles."""
    strength = np.full(len(lights), np.finfo(np.float64).tiny)
    for start in range(0, len(projected), CHUNK):
        rows = np.arange(start, min(start + CHUNK, len(projected)))
        point = surface(projected, rows, points)[0] if any_near(lights) else np.zeros((1, 3))
        for index, light in enumerate(lights):
            strength[index] = max(strength[index], np.max(light.reach(point)[1]))
    return strength


def any_near(lights: Sequence[PointedLight]) -> bool:
    """Whether any light is at a place: the others are everywhere as strong."""
    return any(isinstance(light, PointLight) for light in lights)


def cosines(
    projected: Projected,
    lights: Sequence[PointedLight],
    material: Material,
    points: np.ndarray,
    strength: np.ndarray | None = None,
    x_shading: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    What diffuse and specular channels carry at points of triangles.

    Parameters
    ----------
    projected : Projected
    lights : sequence of lights
      Without ambient ones.
    material : Material
    points : (k, 3) float, the same for every triangle, or (n, k, 3) float
      Barycentric coordinates.
    strength : (lights,) float, optional
      Largest intensity of each light; by default that at these points.
    x_shading : bool
      Normals of the edges' middles from :func:`quadshade.shading.sample.middle_normals`.

    Returns
    -------
    diffuse, specular : (lights, n, k) float64
      Cosines with the light's fall.
    strength : (lights,) float64
    """
    shape = (len(lights), len(projected), points.shape[-2])
    diffuse, specular, intensity = np.empty(shape), np.empty(shape), np.empty(shape)
    everything = np.arange(len(projected))
    for start in range(0, len(projected), CHUNK):
        rows = slice(start, start + CHUNK)
        middle = middle_normals(projected.normal[rows]) if x_shading else None
        places = points if points.ndim == 2 else points[rows]
        point, normal, _, to_viewer = surface(projected, everything[rows], places, middle)
        toward = dot(normal, to_viewer)
        for index, light in enumerate(lights):
            to_light, arriving = light.reach(point)
            facing = dot(normal, to_light)
            cosine = material.specular_cosine(facing, toward, dot(to_light, to_viewer))
            part = diffuse[index, rows].shape
            diffuse[index, rows] = facing.reshape(part)
            specular[index, rows] = cosine.reshape(part)
            intensity[index, rows] = np.broadcast_to(arriving, facing.shape).reshape(part)
    if strength is None:
        strength = intensity.max(axis=(1, 2), initial=np.finfo(np.float64).tiny)
    share = np.minimum(intensity / strength[:, None, None], 1)
    # Interpolated normals are unit length up to rounding.
    diffuse, specular = np.clip(diffuse, -1, 1) * share, np.clip(specular, -1, 1)
    return diffuse, specular * share ** (1 / material.exponent), strength
