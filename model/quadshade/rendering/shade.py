# SPDX-License-Identifier: Apache-2.0
"""A scene as its camera sees it, and its triangles with what is to be interpolated over them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from quadshade.choices import (
    ADAPTIVE_SHADINGS,
    FITS,
    JUMP,
    PHONG,
    SMOOTHNESS,
    SPECULAR_ORDERS,
    parse_pack_error,
)
from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.packing.line import picture_line_bytes
from quadshade.rendering.groups import SceneChoice
from quadshade.rendering.settings import RenderSettings, Reports, check_colours
from quadshade.rendering.supersample import jitter, moved
from quadshade.scene import (
    Camera,
    Mesh,
    Projected,
    build_mesh,
    level_of_detail,
    load_scene,
    parse_camera,
    project,
)
from quadshade.scene.from_trimesh import mesh_from_trimesh
from quadshade.scene.turned import Turn
from quadshade.shading import (
    Light,
    Material,
    UnsuitedError,
    default_lights,
    load_reflectance,
    parse_light,
    parse_material,
    sample,
    sample_specular,
    specular_formats,
    toon_curves,
)
from quadshade.shading.sample import widened

if TYPE_CHECKING:
    from quadshade.adapt import Adapted
    from quadshade.adapt.plan import LineCount


@dataclass(frozen=True)
class ShownScene:
    """
    A scene from its camera, in its light.

    Attributes
    ----------
    projected : Projected
    lights, surface
      For :func:`quadshade.shading.sample`.
    ground : tuple of int
      Background, 8 bits each.
    faces : int
      Of the mesh.
    whole : Mesh
      The scene's mesh before ``--lod``.
    camera : Camera
    adapted : Adapted or None
      What a budget was found to be best for, where it chose the level of detail.
    """

    projected: Projected
    lights: tuple[Light, ...] | None
    surface: Material
    ground: tuple[int, int, int]
    faces: int
    whole: Mesh
    camera: Camera
    adapted: Adapted | None = None


class Shaded(NamedTuple):
    """What is to be drawn, the formats of a core for it, and what was adapted, if anything was."""

    triangles: ScreenTriangles
    formats: Formats
    adapted: Adapted | None


def show_scene(settings: RenderSettings, formats: Formats, reports: Reports) -> ShownScene:
    """
    Read a scene and look at it, in the light of its style.

    Raises
    ------
    QuadshadeError
      A wrong camera, light, material or background, or a mesh that cannot be read.
    """
    choice = settings.scene
    given = choice.lights if isinstance(choice.lights, Sequence) else (choice.lights,)
    texts = (given,) if isinstance(given, str) else given
    lights = tuple(parse_light(one) if isinstance(one, str) else one for one in texts) or None
    surface, ground = _material(choice), choice.ground
    reports.step(f"reading {choice.name}")
    mesh = choice_mesh(choice)
    camera = choice.camera if isinstance(choice.camera, Camera) else parse_camera(choice.camera, mesh)
    whole = mesh
    if choice.level is not None:
        mesh = _level(whole, choice.level, choice)
    projected = project(mesh, camera, *choice.pixels, formats, choice.cull)
    for note in (*(f"{choice.name}: {text}" for text in mesh.notes), *projected.notes):
        reports.notice(note)
    if not len(projected):
        reports.notice(f"the picture is empty: {_why_empty(choice, mesh, camera, formats)}")
    if not formats.with_depth:
        projected = projected.back_to_front()
    if settings.style.style == "gooch":
        from quadshade.style import gooch_material

        surface, lights = gooch_material(surface, lights or default_lights(projected.axes))
    return ShownScene(projected, lights, surface, ground, len(mesh), whole, camera)


def _level(whole: Mesh, count: int, choice: SceneChoice) -> Mesh:
    """The scene in at most so many triangles; errors as of :func:`quadshade.scene.level_of_detail`."""
    if isinstance(choice.scene, Turn):
        return choice.scene.level(count)
    name = choice.scene if isinstance(choice.scene, str | Path) else None
    return level_of_detail(whole, count, name, choice.crease)


def at_level(shown: ShownScene, count: int, choice: SceneChoice, formats: Formats) -> ShownScene:
    """A scene in at most so many triangles; errors as of :func:`quadshade.scene.level_of_detail`."""
    mesh = _level(shown.whole, count, choice)
    projected = project(mesh, shown.camera, *choice.pixels, formats, choice.cull)
    if not formats.with_depth:
        projected = projected.back_to_front()
    return replace(shown, projected=projected, faces=len(mesh))


def _why_empty(choice: SceneChoice, mesh: Mesh, camera: Camera, formats: Formats) -> str:
    """Why no triangle of a mesh is seen, and the option that helps."""
    if choice.cull and len(project(mesh, camera, *choice.pixels, formats, cull=False)):
        return "all faces in view look away from the camera; give --no-cull, or look from outside"
    along = (camera.eye - mesh.vertices) @ camera.axes[2]
    if camera.ortho is None and not (along > (camera.near or 0)).any():
        return "everything lies behind the camera or before its near plane; leave out eye= or give from="
    return "everything lies outside of the view; leave out eye= and target= in --camera, or give from="


def choice_mesh(choice: SceneChoice) -> Mesh:
    """The scene's mesh, read or as it was given; raises :class:`QuadshadeError` where it cannot be read."""
    if isinstance(choice.scene, str | Path):
        return load_scene(choice.scene, choice.crease)
    if isinstance(choice.scene, Turn):
        return choice.scene.mesh
    if isinstance(choice.scene, Mesh):
        mesh = choice.scene
        if choice.crease is None:
            return mesh
        return build_mesh(
            mesh.vertices,
            mesh.faces,
            crease=choice.crease,
            colours=mesh.colours,
            double_sided=mesh.double_sided,
            notes=mesh.notes,
        )
    return mesh_from_trimesh(choice.scene, choice.crease)


def _material(choice: SceneChoice) -> Material:
    """The material, with the exponent and the reflectance that stand beside it."""
    reflectance = choice.reflectance
    if isinstance(reflectance, str):
        reflectance = load_reflectance(reflectance)
    if isinstance(choice.material, str):
        return parse_material(choice.material, choice.exponent, reflectance)
    material = choice.material
    if choice.exponent is not None:
        material = replace(material, exponent=choice.exponent)
    return material if reflectance is None else replace(material, reflectance=reflectance)


def shade_scene(
    settings: RenderSettings,
    shown: ShownScene,
    formats: Formats,
    reports: Reports,
    count_line: LineCount | None = None,
) -> Shaded:
    """
    Shade a scene at the points that its shading needs, or what is cheapest for its error or budget.

    Parameters
    ----------
    settings : RenderSettings
    shown : ShownScene
    formats : Formats
      From :meth:`RenderSettings.checked`.
    reports : Reports
      Its ``notice`` is told where a scene cannot be drawn as asked, and how it is drawn instead.
    count_line : callable, optional
      Bytes on the line of one frame; by default of a board that is the core.

    Returns
    -------
    Shaded

    Raises
    ------
    QuadshadeError
      A limit that cannot be kept, or formats that do not go with the scene.
    """
    if shown.adapted is not None:
        return Shaded(shown.adapted.triangles, shown.adapted.formats, shown.adapted)
    if settings.adapt.is_adaptive:
        adapted = adapted_scene(settings, shown, formats, reports, count_line or default_count(settings))
        return Shaded(adapted.triangles, adapted.formats, adapted)
    choice = settings.scene
    shading, method = choice.interpolation, settings.setup.setup
    x_shading, taylor = method == "xshading", method == "taylor"
    projected, lights, surface = shown.projected, shown.lights, shown.surface
    if shading in SPECULAR_ORDERS:
        try:
            curves = None if choice.toon is None else toon_curves(choice.toon, surface.exponent)
            fitted = specular_formats(
                settings.core_generics, projected, lights, surface, choice.toon is not None
            )
            triangles = sample_specular(
                projected, shading, lights, surface, fitted, x_shading, curves, taylor
            )
            return Shaded(_fitted(settings, shown, triangles, fitted, reports), fitted, None)
        except UnsuitedError as reason:
            shading = shading.removesuffix("-specular").replace("linear", "gouraud")
            steps = "" if choice.toon is None else ", without steps"
            check_colours(formats)
            reports.notice(f"drawn as {shading}{steps}: {reason}")
    order = "flat" if shading == PHONG else shading
    triangles = sample(projected, order, lights, surface, formats, x_shading, taylor)
    triangles = _fitted(settings, shown, triangles, formats, reports)
    return Shaded(widened(triangles, formats.num_channels), formats, None)


def _fitted(
    settings: RenderSettings,
    shown: ShownScene,
    triangles: ScreenTriangles,
    formats: Formats,
    reports: Reports,
) -> ScreenTriangles:
    """What the fit makes of triangles at six points, and parts of them; its notes are notices."""
    choice = settings.scene
    if choice.fit == FITS[0]:
        return triangles
    from quadshade.fit import fit_scene

    reports.step(f"fitting {len(triangles)} triangles, {choice.fit}")
    fitted = fit_scene(
        shown.projected,
        triangles,
        choice.fit,
        shown.lights,
        shown.surface,
        formats,
        smoothness=SMOOTHNESS if choice.smoothness is None else choice.smoothness,
        jump=JUMP if choice.jump is None else choice.jump,
        moves=jitter(choice.supersample, formats),
    )
    for note in fitted.notes:
        reports.notice(note)
    reports.step(f"drawing {len(fitted.triangles)} triangles")
    return fitted.triangles


def default_count(settings: RenderSettings, error: float | None = None) -> LineCount:
    """What a frame takes on the line to a board that is the core; ``error`` is that of packing."""
    error = parse_pack_error(settings.port.added_error) if error is None else error
    return partial(picture_line_bytes, error=error, **settings.setup.arguments())


def board_count(settings: RenderSettings, formats: Formats) -> LineCount:
    """What a frame takes on the line to a board of some formats, with the channels and the depth it has."""
    from quadshade.board.fallbacks import sent_triangles

    count = default_count(settings)
    return lambda triangles, _: count(sent_triangles(triangles, formats), formats)


def adapted_scene(
    settings: RenderSettings,
    shown: ShownScene,
    formats: Formats,
    reports: Reports,
    count_line: LineCount,
) -> Adapted:
    """What is to be drawn for an error or a budget; of colours or cosines, whichever takes least."""
    from quadshade.adapt import adapt

    projected, lights, surface = shown.projected, shown.lights, shown.surface
    specular, shading = None, settings.scene.shading
    if shading != ADAPTIVE_SHADINGS[0]:
        try:
            specular = specular_formats(settings.core_generics, projected, lights, surface)
        except UnsuitedError as reason:
            shading = ADAPTIVE_SHADINGS[0]
            reports.notice(f"drawn as {shading}: {reason}")
    moves = jitter(settings.scene.supersample, formats)

    def count(triangles: ScreenTriangles, core: Formats) -> int:
        return sum(count_line(moved(triangles, by, core), core) for by in moves)

    fit = settings.scene.fit
    adapted = adapt(
        projected, lights, surface, formats, **settings.adapt.arguments(),
        shading=shading or "auto", specular=specular, count_line=count, fit=fit,
    )  # fmt: skip
    if fit in FITS and adapted.fit != fit:
        reports.notice(f"fit: no picture of the fit {fit} is better, so it is drawn without")
    return adapted
