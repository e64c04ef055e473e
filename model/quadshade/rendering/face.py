# SPDX-License-Identifier: Apache-2.0
"""The two functions of ``import quadshade`` that draw; everything else there is a class of its own room."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from quadshade.choices import parse_fps
from quadshade.contract.formats import Formats, parse_generics
from quadshade.contract.triangles import Drawing, ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.rendering.draw import draw_triangles, render_picture
from quadshade.rendering.groups import EngineChoice, SetupChoice
from quadshade.rendering.keywords import check_kind
from quadshade.rendering.picture import Picture
from quadshade.rendering.settings import RenderSettings, Reports, collect

if TYPE_CHECKING:
    import trimesh

    from quadshade.scene import Camera, Mesh
    from quadshade.scene.turned import Turn
    from quadshade.shading import Light, Material
    from quadshade.shading.material import Reflectance


def render(
    scene: str | Path | Mesh | Turn | trimesh.Trimesh | trimesh.Scene,
    *,
    shading: str | None = None,
    size: str | tuple[int, int] | None = None,
    camera: str | Camera = "",
    lights: str | Light | Sequence[str | Light] = (),
    material: str | Material = "",
    exponent: float | None = None,
    toon: int | None = None,
    fit: str = "six-point",
    smoothness: float | None = None,
    jump: float | None = None,
    supersample: int = 1,
    lod: str | int | None = None,
    reflectance: str | Reflectance | None = None,
    cull: bool = True,
    crease: float | None = None,
    background: str | float | Sequence[float] | None = None,
    generics: Mapping[str, int] | Sequence[str] | Formats = (),
    setup: str = "unit",
    rounding: str = "joint",
    stepping: str = "centre",
    strict: bool | float | None = None,
    divide: float | None = None,
    max_error: float | None = None,
    budget: str | int | tuple[int, str] | None = None,
    error_measure: str | None = None,
    frame_time: float | None = None,
    fps: float | None = None,
    clock: float | None = None,
    verify: bool | str = True,
    style: str = "none",
    edges: str | Sequence[str] | None = None,
    edge_variant: str = "diagonal",
    edge_colours: Sequence[str] | Mapping[str, Sequence[float]] = (),
    gbuffer: str | Path | None = None,
    gbuffer_order: str = "quadratic",
    gbuffer_space: str = "camera",
    engine: str | None = None,
    waves: str | Path | None = None,
    port: Any = None,
    baud: int | None = None,
    faults: str | float | tuple[float, int] | None = None,
    timeout: float | None = None,
    trace: Callable[[str], None] | None = None,
    pack_error: float | None = None,
    resume: str | Path | None = None,
    dask: str | None = None,
    reports: Reports | None = None,
) -> Picture:
    """
    Draw a mesh: what ``quadshade render`` does, under the names of its options.

    Parameters
    ----------
    scene : str, Path, Mesh, trimesh.Trimesh or trimesh.Scene
      A mesh file (OBJ, PLY, STL, GLB), a generated mesh such as ``sphere:690``, or a mesh.
    shading : str, optional
      ``flat``, ``gouraud``, ``quadratic`` (the default), ``linear-specular``, ``quadratic-specular``, or
      ``phong``, the reference that the host computes in float.
    size : str or tuple of int, optional
      Width and height in pixels, ``"640x480"`` or ``(640, 480)``; 512 x 512 or the board's screen.
    camera : str or Camera
      As ``--camera``, or an object; what is missing is fitted to the scene.
    lights : str, light, or sequence of them
      As ``--light``, or objects of :mod:`quadshade.shading`; by default white light that goes with the
      viewer.
    material : str or Material
      As ``--material``, or an object: ``Material()`` has more highlight and less ambient light than the
      default here, which is ``quadshade.shading.material.PICTURE_MATERIAL``.
    exponent : float, optional
      Specular exponent; takes the place of the material's.
    toon : int, optional
      Steps of diffuse light; needs a ``-specular`` shading.
    fit : str
      ``six-point``, ``least-squares``, ``minimax``, ``smooth`` or ``c1``: which quadratic a triangle gets
      (``docs/explanation/fit.md``); for an error or a budget ``six-point``, ``minimax`` or ``auto``.
    smoothness : float, optional
      Weight of jumps against errors, in pixels, with ``smooth``; 30.
    jump : float, optional
      Jump of the derivative across an edge that may stay with ``c1``, in grey levels per pixel; 0.02.
    supersample : int
      1, 2 or 4, n: the picture is the mean of n x n pictures, each moved by a part of a pixel.
    lod : str or int, optional
      Triangles that the scene is drawn in at most (``docs/guide/adapt.md``); ``auto``: the budget says.
    reflectance : str or callable, optional
      ``module:function``, or a function of point, normal, to_light and to_viewer.
    cull : bool
      Drop triangles that are seen from behind.
    crease : float, optional
      Degrees: compute normals, and leave edges sharper than this sharp.
    background : str, float or 3 floats, optional
      0 .. 1; black, or white with a style or edges.
    generics : mapping, sequence of ``name=value`` or Formats
      Generics of the core, or of a simulated board.
    setup, rounding, stepping : str
      Where coefficients come from and how they are rounded and stepped (``docs/explanation/setup.md``).
    strict : bool or float, optional
      Refuse a triangle that may be further than so many grey levels from exact; True: 0.5.
    divide : float, optional
      Without ``strict``, draw such a triangle in parts; 0.5.
    max_error : float, optional
      Grey levels against Phong shading, for which the cheapest orders are chosen (``docs/guide/adapt.md``).
    budget : str, int or (int, str), optional
      ``"30000bytes"``, ``"180000clocks"`` or ``"10000line"`` (bytes on the serial line): the least error for
      that; a number is bytes.
    error_measure : str, optional
      ``max`` (the default) or ``rms``: what the two mean by error.
    frame_time : float, optional
      Milliseconds in which a board has to have the whole picture: the least error (``rms`` by default) that
      its line and its core allow (``docs/guide/frame_time.md``).
    fps : float, optional
      The same as frames a second.
    clock : float, optional
      MHz of the core that a frame time is for where there is no port; 100. Its line has ``baud``.
    verify : bool or str
      ``picture`` (True), ``crc`` or ``none`` (False). Compare what was drawn for a largest error with Phong
      shading, and what a board shows with the golden model: pixel by pixel, or by its CRC alone, and then the
      picture is the model's.
    style : str
      ``none``, ``cartoon``, ``gooch`` or ``hatch``.
    edges : str or sequence of str, optional
      ``profile``, ``inner``, or both.
    edge_variant : str
      ``diagonal`` or ``eight`` neighbours.
    edge_colours : sequence of ``kind=r,g,b``, or mapping of str to 3 floats
      0 .. 1.
    gbuffer : str or Path, optional
      NPZ file of normals, depth and triangles to write.
    gbuffer_order, gbuffer_space : str
      ``quadratic`` or ``linear`` normals, in ``camera`` or ``world`` axes.
    engine : str, optional
      ``model``, ``ghdl`` or ``verilator``; the last one where it is installed. With ``port="sim"`` what
      simulates the board.
    waves : str or Path, optional
      GHW file of waveforms to write (GHDL).
    port : str, serial object or Board, or sequence of them, optional
      Draw on a board: as for :class:`quadshade.Board`, or an open one, which stays open. Several boards draw
      tiles of the picture at the same time, ``"sim:4"`` is four simulated ones; so does one whose screen is
      smaller than the picture (``docs/guide/scale.md``).
    baud, faults, timeout, trace
      As for :class:`quadshade.Board`: ``faults`` there, ``timeout`` is its ``answer_seconds``.
    pack_error : float, optional
      Grey levels that words with fewer fraction bits may add on the way to a board; 1/32, or 0 in tiles.
    resume : str or Path, optional
      Folder that keeps tiles until the picture is whole. Those that are there already are not drawn again.
    dask : str, optional
      Address of a Dask scheduler, whose workers draw tiles with the golden model or ``engine``; with ``port``
      each on a board of its own, ``"sim"`` or ``"auto"``.
    reports : Reports, optional
      Whom to tell what is being done, and what is not as asked; by default that becomes a warning.

    Returns
    -------
    Picture

    Raises
    ------
    QuadshadeError
      What cannot be drawn as it is asked for: the message says what is wrong, the hint what to do.
    """
    keywords = dict(locals())
    reports = keywords.pop("reports")
    check_kind("fps", keywords.pop("fps"), None)
    if fps is not None:
        if frame_time is not None:
            raise QuadshadeError("--fps and --frame-time are given", "give one of them")
        keywords["frame_time"] = 1000 / parse_fps(fps)
    return render_picture(RenderSettings.collect(keywords), reports)


def draw(
    triangles: ScreenTriangles | str | Path,
    *,
    engine: str | None = None,
    generics: Mapping[str, int] | Sequence[str] | Formats = (),
    waves: str | Path | None = None,
    setup: str = "unit",
    rounding: str = "joint",
    stepping: str = "centre",
    strict: bool | float | None = None,
    divide: float | None = None,
) -> Drawing:
    """
    Draw triangles that are on the screen already: what ``quadshade raster`` does.

    Parameters
    ----------
    triangles : ScreenTriangles, str or Path
      Or a triangles file; a :class:`Picture` has ``triangles`` too.
    engine, generics, waves, setup, rounding, stepping, strict, divide
      As for :func:`render`; the generics are fitted to the triangles' channels.

    Returns
    -------
    Drawing
      Pixels in the order in which the engine emits them, and its statistics.

    Raises
    ------
    QuadshadeError
      A malformed file, triangles that the core cannot draw, or an engine that is not installed.
    """
    keywords = dict(locals())
    check_kind("generics", generics, ())
    if isinstance(generics, Formats):
        generics = generics.generics()
    values = dict(generics) if isinstance(generics, Mapping) else parse_generics(generics)
    choice, drawn_by = collect(SetupChoice, keywords), collect(EngineChoice, keywords)
    return draw_triangles(triangles, values, choice, drawn_by)
