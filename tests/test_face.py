# SPDX-License-Identifier: Apache-2.0
"""``import quadshade``: a picture in one line, and all that the command line can do."""

from __future__ import annotations

import inspect
import json
import pkgutil
import shutil
import subprocess
import sys
import warnings
from dataclasses import replace
from importlib import import_module
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from PIL import Image

import quadshade
from quadshade.board import BoardSettings
from quadshade.cli.main import main
from quadshade.cli.render import render as render_command
from quadshade.image import read_picture
from quadshade.rendering import Reports
from quadshade.scene import Camera, build_mesh, parse_camera, project
from quadshade.shading import AmbientLight, DirectionalLight, parse_material
from quadshade.style import illustrate

SMALL = {"size": (48, 32), "engine": "model"}
HEAVY = ("numpy", "numba", "scipy", "trimesh", "skimage", "matplotlib", "rich", "quadshade.engine")


def command_line(*arguments: object) -> str:
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.fixture(scope="module")
def sphere() -> quadshade.Picture:
    return quadshade.render("sphere:690", exponent=50, engine="model", size="96x64")


def test_a_picture_in_one_line(tmp_path: Path) -> None:
    quadshade.render("sphere:690", exponent=50).save(tmp_path / "sphere.png")
    command_line("render", "sphere:690", "--exponent", 50, "-o", tmp_path / "same.png")
    assert (tmp_path / "sphere.png").read_bytes() == (tmp_path / "same.png").read_bytes()
    assert read_picture(tmp_path / "sphere.png").shape == (512, 512, 3)
    assert len(list(tmp_path.iterdir())) == 2


def test_a_picture_knows_what_it_cost(sphere: quadshade.Picture, tmp_path: Path) -> None:
    stats = tmp_path / "stats.json"
    line = command_line(
        *("render", "sphere:690", "--exponent", 50, "--engine", "model", "--size", "96x64"),
        *("-o", tmp_path / "a.png", "--stats", stats),
    )
    assert json.loads(stats.read_text()) == sphere.stats.as_dict()
    assert line == f"{tmp_path / 'a.png'}: {sphere.summary}\n"
    assert sphere.array.shape == (64, 96, 3) and sphere.array.dtype == np.uint8
    assert sphere.stats.clocks is not None and sphere.stats.words is not None
    assert sphere.stats.clocks > sphere.stats.visible_pixels == int(sphere.covered.sum()) > 500
    assert (sphere.array[~sphere.covered] == 0).all()
    # Where nothing was drawn depth is as far as can be, elsewhere nearer; the index is one of the triangles'.
    assert (sphere.depth[~sphere.covered] == 65535).all() and sphere.depth[sphere.covered].max() < 65535
    assert (sphere.triangle >= 0).sum() == sphere.covered.sum()
    assert sphere.triangle.max() < len(sphere.triangles)
    assert sphere.notes == ()


def test_a_notebook_shows_the_picture(sphere: quadshade.Picture) -> None:
    shown = np.asarray(Image.open(BytesIO(sphere._repr_png_())))
    assert (shown == sphere.array).all()


def test_the_error_to_phong_and_to_other_pictures(sphere: quadshade.Picture, tmp_path: Path) -> None:
    error = sphere.error_to("phong")
    flat = quadshade.render("sphere:690", exponent=50, shading="flat", engine="model", size="96x64")
    assert flat.error_to("phong").rms > 5 * error.rms > 0
    assert error.largest_error < flat.error_to("phong").largest_error
    phong = quadshade.render("sphere:690", exponent=50, shading="phong", size="96x64")
    assert error == sphere.error_to(phong) == sphere.error_to(phong.array)
    phong.save(tmp_path / "phong.png")
    assert error == sphere.error_to(tmp_path / "phong.png") == sphere.error_to(str(tmp_path / "phong.png"))
    square = np.mean((sphere.array.astype(float) - phong.array) ** 2)
    assert error.rms == pytest.approx(square**0.5) and sphere.error_to(sphere).rms == 0
    assert phong.stats.clocks is None and phong.error_to("phong").differing == 0
    with pytest.raises(quadshade.QuadshadeError, match="compare pictures of one size"):
        sphere.error_to(quadshade.render("sphere:24", **SMALL))
    # Generics that only say how channels are carried do not reach the reference.
    shaded = quadshade.render("sphere:690", shading="quadratic-specular", engine="model", size="96x64")
    assert shaded.stats.generics["num_channels"] == 2 and shaded.error_to("phong").psnr > 35


@pytest.mark.skipif(shutil.which("ghdl") is None, reason="no ghdl")
def test_a_mesh_of_trimesh_through_the_vhdl() -> None:
    mesh = trimesh.creation.icosphere(subdivisions=1)
    picture = quadshade.render(mesh, shading="quadratic-specular", engine="ghdl", size=(64, 48))
    model = quadshade.render(mesh, shading="quadratic-specular", engine="model", size=(64, 48))
    assert picture.stats.engine == "ghdl" and picture.stats.faces == 80 and picture.stats.scene == "mesh"
    assert (picture.array == model.array).all() and picture.stats.clocks == model.stats.clocks


@pytest.mark.parametrize("suffix", ("stl", "ply", "obj"))
def test_a_path_and_an_object_give_one_picture(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"part.{suffix}"
    trimesh.creation.annulus(0.4, 1.0, 0.7, sections=12).export(path)
    from_path = quadshade.render(path, **SMALL)
    loaded = quadshade.load_scene(path)
    held = trimesh.load(path, process=False)
    for given in (str(path), loaded, held, trimesh.Scene(held)):
        assert (quadshade.render(given, **SMALL).array == from_path.array).all(), type(given)
    assert (quadshade.render(loaded, crease=0, **SMALL).array != from_path.array).any()


def test_the_colours_of_an_object_are_drawn() -> None:
    mesh = trimesh.creation.box()
    mesh.visual.face_colors = [200, 20, 20, 255]
    red, _, blue = quadshade.render(mesh, **SMALL).array.reshape(-1, 3).sum(axis=0)
    assert red > 3 * blue > 0


def test_objects_say_what_texts_say() -> None:
    camera = Camera(np.array([0.0, 1.0, 4.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]), fov=40.0)
    lights = [DirectionalLight((1.0, 1.0, 1.0)), AmbientLight((0.2, 0.2, 0.2))]
    material = replace(parse_material(""), colour=(0.8, 0.3, 0.1), exponent=30.0)
    objects = quadshade.render(
        "torus:288",
        camera=camera,
        lights=lights,
        material=material,
        background=(0, 0.2, 1),
        generics={"stream_width": 64},
        budget=(9200, "bytes"),
        edges=("profile", "inner"),
        edge_colours={"inner": (1, 0, 0)},
        **SMALL,
    )
    texts = quadshade.render(
        "torus:288",
        camera="eye=0,1,4,target=0,0,0,up=0,1,0,fov=40",
        lights=["dir=1,1,1", "ambient=0.2"],
        material="colour=0.8,0.3,0.1,exponent=30",
        background="0,0.2,1",
        generics=["stream_width=64"],
        budget="9200bytes",
        edges="profile,inner",
        edge_colours=["inner=1,0,0"],
        **SMALL,
    )
    assert (objects.array == texts.array).all() and objects.stats == texts.stats
    assert objects.stats.generics["stream_width"] == 64 and objects.stats.adaptive["bytes"] <= 9200
    one = quadshade.render("sphere:24", lights=lights[0], **SMALL)
    assert (one.array == quadshade.render("sphere:24", lights="dir=1,1,1", **SMALL).array).all()


def test_a_function_is_a_reflectance() -> None:
    def red(point, normal, to_light, to_viewer):
        return 0 * normal + (0.5, 0, 0)

    picture = quadshade.render("sphere:168", reflectance=red, lights="dir=0,0,1", **SMALL)
    assert picture.array[16, 24].tolist() == [128, 0, 0]


def test_every_option_is_a_keyword() -> None:
    keywords = set(inspect.signature(quadshade.render).parameters)
    options = {parameter.name for parameter in render_command.params}
    # --no-verify is verify's none, seen apart so that both together are refused.
    assert options - {"output", "stats", "no_verify"} == keywords - {"reports"}
    documented = quadshade.render.__doc__.split("Returns")[0]
    assert all(name in documented for name in keywords)


@pytest.mark.parametrize(
    "keywords",
    (
        {"shading": "cartoon"},
        {"style": "oil"},
        {"setup": "magic"},
        {"rounding": "up"},
        {"edges": "outer"},
        {"edge_variant": "four"},
        {"edge_colours": {"inner": (1, 0, 0)}},
        {"size": (0, 5)},
        {"size": "wide"},
        {"background": 2},
        {"budget": "much"},
        {"error_measure": "rms"},
        {"strict": True, "divide": 0.5},
        {"divide": 0},
        {"generics": {"colour": 3}},
        {"generics": {"stream_width": 48}},
        {"engine": "verilog"},
        {"waves": "a.ghw", "engine": "model"},
        {"gbuffer": "g.txt"},
        {"baud": 9600},
        {"pack_error": 0.5},
        {"port": "sim", "shading": "phong"},
        {"port": "sim", "faults": 2},
    ),
    ids=str,
)
def test_what_cannot_be_drawn_is_said(keywords: dict) -> None:
    with pytest.raises(quadshade.QuadshadeError):
        quadshade.render("sphere:24", **{"size": (16, 16)} | keywords)


@pytest.mark.parametrize(
    "scene", ("none.obj", "cone:3", 7, np.zeros((3, 3))), ids=("file", "name", "7", "array")
)
def test_what_is_no_scene_is_said(scene: object) -> None:
    with pytest.raises(quadshade.QuadshadeError):
        quadshade.render(scene, **SMALL)


@pytest.mark.parametrize(
    "value", (None, "", -1.5, 1j, b"1", (), [None], {"a": 1}, np.zeros(3), np.zeros((2, 2)), object), ids=str
)
@pytest.mark.parametrize("name", sorted(set(inspect.signature(quadshade.render).parameters) - {"reports"}))
def test_a_value_of_another_kind_is_drawn_or_said(name: str, value: object) -> None:
    """Each keyword takes its own kinds, and says so of all others."""
    keywords = SMALL | {"scene": "cube:1", "edges": "inner", "shading": "quadratic-specular", name: value}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            picture = quadshade.render(**keywords)
        except quadshade.QuadshadeError as error:
            assert str(error) and "\n" not in str(error)
        else:
            assert picture.array.dtype == np.uint8


@pytest.mark.parametrize(
    "keywords",
    ({"size": ""}, {"size": 0}, {"engine": ""}, {"budget": (1, 2)}, {"generics": ""}, {"cull": "no"}),
)
def test_a_value_of_another_kind_is_not_taken_for_a_default(keywords: dict) -> None:
    (name,) = keywords
    with pytest.raises(quadshade.QuadshadeError, match=name):
        quadshade.render("cube:1", **(SMALL | keywords))


def test_a_picture_is_a_png(sphere: quadshade.Picture, tmp_path: Path) -> None:
    with pytest.raises(quadshade.QuadshadeError, match="ends in .png"):
        sphere.save(tmp_path / "a.jpg")
    with pytest.raises(quadshade.QuadshadeError, match="cannot write"):
        sphere.save(tmp_path / "no" / "a.png")
    assert not list(tmp_path.iterdir())


def test_what_is_not_as_asked_is_a_warning_and_a_note() -> None:
    asked = {"shading": "quadratic-specular", "lights": "ambient=1"} | SMALL
    with pytest.warns(UserWarning, match="drawn as quadratic: all light is ambient"):
        picture = quadshade.render("sphere:24", **asked)
    assert picture.notes == ("drawn as quadratic: all light is ambient",)
    told: list[str] = []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        quadshade.render("sphere:24", **asked, reports=Reports(told.append))
    assert told == list(picture.notes)


def test_a_board_draws_what_the_model_draws() -> None:
    settings = BoardSettings(screen_width=48, screen_height=32)
    hatched = {"style": "hatch", "background": 1.0}
    with quadshade.Board("sim", settings=settings, engine="model") as board:
        first = quadshade.render("sphere:168", port=board)
        second = quadshade.render("torus:288", port=board, pack_error=0, **hatched)
        for wrong in ({"engine": "ghdl"}, {"baud": 9600}, {"generics": {"frac_bits": 20}}):
            with pytest.raises(quadshade.QuadshadeError, match="leave"):
                quadshade.render("sphere:168", port=board, **wrong)
        # It is still open.
        assert (board.read() != first.array).any() and board.status()
    assert first.array.shape == (32, 48, 3) and first.stats.line["triangles"] > 0 and first.stats.port
    # Words lose fraction bits on the line: at most a grey level.
    assert first.error_to(quadshade.render("sphere:168", **SMALL)).largest_error <= 1
    assert second.error_to(quadshade.render("torus:288", **hatched, **SMALL)).differing == 0
    exact = quadshade.render("sphere:168", port="sim", pack_error=0, **SMALL)
    assert (exact.array == quadshade.render("sphere:168", **SMALL).array).all()
    assert exact.depth is None and exact.covered is None
    assert exact.error_to("phong") == quadshade.render("sphere:168", **SMALL).error_to("phong")


def test_triangles_are_drawn_again(sphere: quadshade.Picture, tmp_path: Path) -> None:
    drawing = quadshade.draw(sphere.triangles, engine="model")
    assert drawing.stats["clocks"] == sphere.stats.clocks
    shaded = quadshade.render("sphere:168", shading="quadratic-specular", toon=3, **SMALL)
    again = quadshade.draw(shaded.triangles, engine="model", generics=shaded.stats.generics)
    assert again.stats["clocks"] == shaded.stats.clocks == quadshade.draw(shaded.triangles).stats["clocks"]
    path = tmp_path / "triangles.json"
    path.write_text(
        '{"width": 10, "height": 10, "channels": ["r"], "triangles": '
        '[{"vertices": [[1, 1], [9, 2], [3, 9]], "samples": {"r": [5]}}]}'
    )
    pixels = quadshade.draw(path, engine="model").pixels
    assert len(pixels) > 20 and (pixels.value == 5).all()
    with pytest.raises(quadshade.QuadshadeError, match="nowhere.json"):
        quadshade.draw("nowhere.json")


def test_a_cartoon_has_smooth_tones_like_an_illustration() -> None:
    mesh = quadshade.load_scene("torus:288")
    shown = project(mesh, parse_camera("", mesh), 64, 48)
    drawn = illustrate(shown, "cartoon", parse_material(""))
    picture = quadshade.render(mesh, style="cartoon", edges="profile,inner", engine="model", size=(64, 48))
    assert (picture.array == drawn).all()
    board = quadshade.render(mesh, style="cartoon", port="sim", pack_error=0, **SMALL)
    assert board.error_to(quadshade.render(mesh, style="cartoon", **SMALL)).differing == 0


def test_two_triangles_of_a_mesh_made_by_hand() -> None:
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    square = build_mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    picture = quadshade.render(square, camera="from=0,0,1,ortho=1", size=(20, 20), engine="model")
    assert picture.covered.all() and set(np.unique(picture.triangle)) == {0, 1}


def loaded_by(*arguments: str, complete: str | None = None) -> set[str]:
    """The heavy modules that a new interpreter has imported in the end."""
    program = "import sys, atexit\natexit.register(lambda: sys.stderr.write(repr(sorted(sys.modules))))\n"
    program += "import quadshade\n"
    environment = {"PYTHONPATH": str(Path(quadshade.__file__).parents[1]), "PATH": ""}
    if complete is not None:
        environment |= {"_QUADSHADE_COMPLETE": "bash_complete", "COMP_WORDS": complete, "COMP_CWORD": "2"}
    if arguments or complete is not None:
        program += f"from quadshade.cli.main import main\nmain({list(arguments)!r}, prog_name='quadshade')\n"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr
    if arguments or complete is not None:
        assert done.stdout
    return set(eval(done.stderr)) & set(HEAVY)


@pytest.mark.parametrize(
    "arguments",
    ((), ("--help",), ("--version",), ("render", "--help"), ("raster", "--help"), ("pack", "--help"),
     ("trade", "--help"), ("info", "--help"), ("replay", "--help"), ("board", "--help"),
     ("compare", "--help"), ("dump", "--help"), ("completion", "zsh"), ("completion", "fish")),
    ids=" ".join,
)  # fmt: skip
def test_import_and_help_load_nothing_heavy(arguments: tuple[str, ...]) -> None:
    assert loaded_by(*arguments) == set()


def test_completion_loads_nothing_heavy() -> None:
    assert loaded_by(complete="quadshade render --sh") == set()


def test_the_shell_completes_commands_options_and_values() -> None:
    runner = CliRunner()
    for words, count, expected in (
        ("quadshade re", 1, "plain,render"),
        ("quadshade render --sha", 2, "plain,--shading"),
        ("quadshade render --shading qu", 3, "plain,quadratic-specular"),
        ("quadshade render sph", 2, "file,sph"),
    ):
        environment = {"_QUADSHADE_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(count)}
        result = runner.invoke(main, [], prog_name="quadshade", env=environment)
        assert expected in result.output.splitlines(), result.output
    for shell in ("bash", "zsh", "fish"):
        assert "_QUADSHADE_COMPLETE" in command_line("completion", shell)


def test_the_package_runs_as_a_module() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "quadshade", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"quadshade, version {quadshade.__version__}\n"


def test_the_help_groups_the_options_of_render() -> None:
    lines = command_line("render", "--help").splitlines()
    titles = ("Scene:", "Shading:", "Accuracy:", "Style:", "Engine or board:", "Output:", "Options:")
    places = [lines.index(title) for title in titles]
    assert places == sorted(places)
    assert places[0] < next(at for at, line in enumerate(lines) if line.startswith("  --camera")) < places[1]


def test_every_package_says_what_it_offers() -> None:
    assert sorted(quadshade.__all__) == dir(quadshade)
    for name in quadshade.__all__:
        assert getattr(quadshade, name) is not None
    with pytest.raises(AttributeError):
        quadshade.paint  # noqa: B018
    for found in pkgutil.iter_modules(quadshade.__path__):
        if found.ispkg and found.name != "cli":
            package = import_module(f"quadshade.{found.name}")
            assert package.__all__ and package.__doc__, found.name
            for name in package.__all__:
                offered = getattr(package, name, None) or import_module(f"quadshade.{found.name}.{name}")
                assert offered.__doc__ or not callable(offered), name
