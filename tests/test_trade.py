# SPDX-License-Identifier: Apache-2.0
"""``quadshade trade``: its numbers, its fronts, what it keeps and what it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.engine.sources import repository_root
from quadshade.image import compare, read_picture
from quadshade.trade import COSTS, Grid, Point, View, area, mark_pareto, pareto_front, sweep
from quadshade.trade.measure import HEAT_FULL, MEASURED, heat_map, measure
from quadshade.trade.store import store, stored
from quadshade.trade.subdivision import subdivide
from quadshade.trade.view import stage

SHADINGS = ("--shadings", "flat,gouraud,quadratic")
FEW = (*SHADINGS, "--fractions", "8,22", "--subdivisions", "none,all:1", "--jobs", "1")


def trade(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, ["trade", *map(str, arguments)])


def render(*arguments: str | Path) -> dict:
    """Statistics of ``quadshade render`` with the same settings."""
    run = CliRunner().invoke(main, ["render", *map(str, arguments)])
    assert run.exit_code == 0, run.output
    return json.loads(Path(arguments[-1]).read_text())


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small sweep without cells."""
    folder = tmp_path_factory.mktemp("swept")
    run = trade("torus:288", "-o", folder, "--size", "120x90", "--exponent", "50", "--no-area", *FEW)
    assert run.exit_code == 0, run.output
    assert "quadshade: notice: LUTs are not counted: --no-area leaves synthesis out" in run.output
    return folder


def contents(folder: Path) -> dict[str, object]:
    """A point's files; of its record all but the host's time, which is never the same twice."""
    files: dict[str, object] = {path.name: path.read_bytes() for path in folder.iterdir()}
    record = json.loads(files["record.json"])
    assert record.pop("host_seconds") > 0
    return files | {"record.json": record}


def points(folder: Path) -> list[dict]:
    return json.loads((folder / "trade.json").read_text())["points"]


def test_a_point_is_what_render_draws(swept: Path, tmp_path: Path) -> None:
    """The same picture, clocks and words as the command that draws one picture, by another way."""
    for shading in ("flat", "gouraud", "quadratic"):
        (point,) = [p for p in points(swept) if p["name"] == f"{shading}-22-none"]
        out, stats = tmp_path / "picture.png", tmp_path / "stats.json"
        scene = ("torus:288", "--size", "120x90", "--exponent", "50")
        drawn = render(*scene, "--shading", shading, "-o", out, "--stats", stats)
        assert np.array_equal(read_picture(out), read_picture(swept / point["picture"]))
        assert (point["clocks"], point["pixels"]) == (drawn["clocks"], drawn["pixels"])
        assert point["bytes"] == 4 * drawn["words"]
        render(*scene, "--shading", "phong", "-o", out, "--stats", stats)
        assert np.array_equal(read_picture(out), read_picture(swept / point["reference"]))


def test_the_power_at_the_pixel_is_a_choice(tmp_path: Path) -> None:
    """The picture that ``render`` draws through the shade unit; its state is among the bytes."""
    scene = (
        "torus:288",
        "--size",
        "120x90",
        "--exponent",
        "50",
        "--light",
        "dir=0,0,1",
        "--light",
        "dir=1,0,1",
    )
    wanted = ("--shadings", "quadratic,quadratic-specular", "--fractions", "8,22", "--subdivisions", "none")
    run = trade(*scene, *wanted, "-o", tmp_path / "swept", "--no-area", "--jobs", "1")
    assert run.exit_code == 0, run.output
    found = {point["name"]: point for point in points(tmp_path / "swept")}
    point = found["quadratic-specular-22-none"]
    out, stats = tmp_path / "picture.png", tmp_path / "stats.json"
    drawn = render(*scene, "--shading", "quadratic-specular", "-o", out, "--stats", stats)
    assert np.array_equal(read_picture(out), read_picture(tmp_path / "swept" / point["picture"]))
    assert (point["clocks"], point["order"], point["word_width"]) == (drawn["clocks"], "quadratic", 32)
    assert point["bytes"] > 4 * drawn["words"]
    assert point["rms"] < found["quadratic-22-none"]["rms"] / 2
    formats = Point("quadratic-specular", 8, "none").formats(Formats(), lights=2)
    assert (formats.num_channels, formats.num_specular, formats.shade_guard_bits) == (4, 2, 8)


def test_a_surface_without_two_cosines_is_refused(tmp_path: Path) -> None:
    """The point says why; the others are drawn."""
    run = trade(
        "sphere:24", "--size", "40x40", "--exponent", "2000", "--shadings", "gouraud,quadratic-specular",
        "--fractions", "22", "--subdivisions", "none", "-o", tmp_path, "--no-area", "--jobs", "1",
    )  # fmt: skip
    assert run.exit_code == 0, run.output
    refused = {point["shading"]: point["refused"] for point in points(tmp_path)}
    assert refused["gouraud"] is None and "exponent" in refused["quadratic-specular"]


def test_errors_are_those_of_the_pictures(swept: Path) -> None:
    for point in points(swept):
        picture, reference = read_picture(swept / point["picture"]), read_picture(swept / point["reference"])
        measured = compare(picture, reference)
        assert point["psnr"] == measured.psnr
        assert point["max_error"] == measured.largest_error
        assert point["rms"] == pytest.approx(255 / 10 ** (measured.psnr / 20), rel=1e-12)
        with Image.open(swept / point["error_map"]) as shown:
            assert np.array_equal(np.asarray(shown), heat_map(picture, reference))


def test_accuracy_grows(swept: Path) -> None:
    rms = {point["name"]: point["rms"] for point in points(swept)}
    assert rms["quadratic-22-none"] < rms["gouraud-22-none"] < rms["flat-22-none"]
    for shading in ("flat", "gouraud", "quadratic"):
        assert rms[f"{shading}-22-all1"] < rms[f"{shading}-22-none"]
    assert rms["quadratic-22-none"] < rms["quadratic-8-none"]


def test_csv_holds_the_same(swept: Path) -> None:
    with (swept / "trade.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(points(swept)) == 12
    for row, point in zip(rows, points(swept), strict=True):
        for name in ("rms", "psnr", "bytes", "clocks", "fraction"):
            assert float(row[name]) == point[name]
        assert row["lut4"] == ""
        assert [cost for cost in COSTS if row[f"pareto_{cost}"] == "1"] == point["pareto"]


def test_again_costs_nothing_and_other_settings_are_measured(tmp_path: Path) -> None:
    arguments = ("sphere:168", "-o", tmp_path, "--size", "32x32", "--no-area", *FEW)
    assert "12 points, 0 from before" in trade(*arguments).output
    first = (tmp_path / "trade.json").read_bytes()
    assert "12 points, 12 from before" in trade(*arguments).output
    assert (tmp_path / "trade.json").read_bytes() == first
    assert "12 points, 0 from before" in trade(*arguments, "--exponent", "7").output
    assert len(list((tmp_path / "points").iterdir())) == 12


def test_a_changed_mesh_is_measured_again(tmp_path: Path) -> None:
    mesh = tmp_path / "mesh.obj"
    arguments = (mesh, "-o", tmp_path / "out", "--size", "32x32", "--no-area", *FEW)
    text = "v 0 0 0\nv 1 0 0\nv 0 1 {z}\nf 1 2 3\n"
    mesh.write_text(text.format(z=0))
    assert "12 points, 0 from before" in trade(*arguments).output
    mesh.write_text(text.format(z=0.25))
    assert "12 points, 0 from before" in trade(*arguments).output


def test_fronts_by_their_definition(rng: np.random.Generator) -> None:
    cost, error = rng.integers(0, 8, (2, 200)).astype(float)
    for index, best in enumerate(pareto_front(cost, error)):
        no_worse = (cost <= cost[index]) & (error <= error[index])
        less = (cost < cost[index]) | (error < error[index])
        assert best == (not (no_worse & less).any())


def test_fronts_leave_out_what_is_unknown() -> None:
    records = [
        {"rms": 2.0, "bytes": 10, "clocks": 5, "lut4": None},
        {"rms": None, "bytes": None, "clocks": None, "lut4": 1},
        {"rms": 1.0, "bytes": 20, "clocks": 5, "lut4": 7},
    ]
    mark_pareto(records)
    assert [record["pareto"] for record in records] == [["bytes"], [], ["bytes", "clocks", "lut4"]]


@pytest.mark.parametrize("subdivision", ["all:2", "highlights:60", "centre:1"])
def test_subdivision_divides(subdivision: str) -> None:
    view = View("sphere:168", 128, 128, exponent=50)
    whole = view.projected(Formats())
    parts = subdivide(whole, subdivision, None, view.surface, Formats())
    assert len(parts) == 16 * len(whole) if subdivision == "all:2" else len(parts) > len(whole)


def test_refused_points_say_why(tmp_path: Path) -> None:
    """A screen that the core's coordinates cannot hold: no picture, no number, but the reason."""
    view, wide = View("sphere:168", 64, 64), Formats()
    place = stage(view, view.projected(wide), "none", wide)
    measured = measure(Point("gouraud", 8, "none"), place, Formats(coord_bits=5), "model")
    assert measured.files == {}
    assert measured.record["refused"] == "screen of 64 x 64 pixels; give 1 to 32 (generic coord_bits)"
    assert {measured.record[name] for name in MEASURED} == {None}
    store(tmp_path, "point", measured)
    assert stored(tmp_path, "point") == measured.record


@pytest.mark.parametrize(
    ("name", "content"),
    [("record.json", b""), ("record.json", b"{}"), ("record.json", b"[]"), ("picture.png", None)],
)
def test_a_damaged_point_is_measured_anew(tmp_path: Path, name: str, content: bytes | None) -> None:
    few = ("sphere:24", "--size", "16x16", "--no-area", "--jobs", "1", "--fractions", "22", "-o", tmp_path)
    few += ("--shadings", "flat", "--subdivisions", "none")
    points = tmp_path / "points"
    for other in ("mine", ".git", "flat-22-none-0123456789ab"):
        (points / other).mkdir(parents=True)
    assert "1 point, 0 from before" in trade(*few).output
    (point,) = points.glob("*-*/record.json")
    whole = contents(point.parent)
    damaged = point.with_name(name)
    damaged.unlink()
    if content is not None:
        damaged.write_bytes(content)
    run = trade(*few)
    assert run.exit_code == 0 and "1 point, 0 from before" in run.output
    assert contents(point.parent) == whole
    assert "1 point, 1 from before" in trade(*few).output
    # What is somebody else's stays, a point of another sweep goes.
    assert sorted(path.name for path in points.iterdir()) == [".git", point.parent.name, "mine"]


def test_cells_are_counted_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One small core: its cells are Yosys', and the second run takes them from where they are kept."""
    small = Formats(num_channels=1, with_depth=0, max_order=0, word_width=12, frac_bits=2, coord_bits=6)
    assert area.no_tools() == ""
    counted = area.count_cells(small, "ice40-up5k")
    folders = list((repository_root() / "build" / "synth" / "counted").glob("*/stat.json"))
    cells = [json.loads(path.read_text())["design"]["num_cells_by_type"].get("SB_LUT4") for path in folders]
    assert counted["lut4"] in cells
    assert counted["dsp"] == 0 < counted["ff"]

    def no_run(*_):
        raise AssertionError("Yosys runs again")

    monkeypatch.setattr(area, "run_yosys", no_run)
    assert area.count_cells(small, "ice40-up5k") == counted


def test_cells_stand_in_the_records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def count(formats: Formats, device: str) -> dict[str, int]:
        cells = 100 * formats.max_order + formats.word_width
        return {"lut4": cells, "ff": 1, "bram": 0, "dsp": 0, "carry": 0, "carry_luts": 0}

    monkeypatch.setattr("quadshade.trade.run_sweep.count_cells", count)
    result = sweep(
        View("sphere:168", 32, 32),
        Grid((8, 22), ("flat", "gouraud", "quadratic"), ("none",)),
        tmp_path,
        jobs=1,
    )
    assert result.device == "ecp5-25k-6"
    assert [r["lut4"] for r in result.records] == [18, 32, 118, 132, 218, 232]
    assert any("lut4" in record["pareto"] for record in result.records)


def test_without_synthesis_there_is_a_notice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GHDL", "/nowhere/ghdl")
    run = trade("sphere:168", "-o", tmp_path, "--size", "32x32", *FEW)
    assert run.exit_code == 0, run.output
    assert "quadshade: notice: LUTs are not counted: " in run.output
    content = json.loads((tmp_path / "trade.json").read_text())
    assert content["device"] is None
    assert content["notice"]
    assert all(point["lut4"] is None for point in content["points"])


def test_the_core_is_the_smallest() -> None:
    formats = Point("gouraud", 12, "none").formats(Formats(stream_width=64))
    assert (formats.max_order, formats.frac_bits, formats.word_width, formats.stream_width) == (1, 12, 22, 64)
    assert Point("quadratic", 22, "none").formats(Formats()) == Formats()


def test_adaptive_points_hold_their_error_and_are_cheaper(tmp_path: Path) -> None:
    """The rms error over the covered pixels is what was allowed; no fixed order is as good for less."""
    grid = Grid((22,), ("quadratic", "adaptive:1"), ("none", "all:1"))
    view = View("sphere:168", 256, 256, camera="ortho=1.05", exponent=50)
    result = sweep(view, grid, tmp_path, area=False, jobs=1)
    records = {record["name"]: record for record in result.records}
    assert list(records) == ["quadratic-22-none", "adaptive1-22-none", "quadratic-22-all1"]
    adaptive, fine = records["adaptive1-22-none"], records["quadratic-22-all1"]
    covered = adaptive["rms"] * (256 * 256 / adaptive["pixels"]) ** 0.5
    assert covered <= 1.02
    assert adaptive["rms"] < records["quadratic-22-none"]["rms"]
    assert adaptive["bytes"] < fine["bytes"]
    assert adaptive["bytes_per_triangle"] == adaptive["bytes"] / adaptive["mesh_triangles"]
    reference = read_picture(tmp_path / adaptive["reference"])
    assert compare(read_picture(tmp_path / adaptive["picture"]), reference).psnr == adaptive["psnr"]


def test_heat_maps_share_a_scale() -> None:
    black = np.zeros((1, 3, 3), np.uint8)
    shown = heat_map(black, np.array([[[0, 0, 0], [0, HEAT_FULL, 0], [255, 0, 0]]], np.uint8))
    assert shown[0, 0].sum() < 10
    assert np.array_equal(shown[0, 1], shown[0, 2])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--fractions", "8,x"), "the fractions are '8,x'; give whole numbers"),
        (("--fractions", "99"), "generic word_width is 109; give a value from 12 to 60"),
        (("--fractions", "8,8"), "the fractions are (8, 8); give at least one, and each once"),
        (("--fractions", ""), "the fractions are (); give at least one"),
        (("--shadings", "phong"), "the shading is 'phong'; give some of flat, gouraud"),
        (("--shadings", "adaptive:0.1"), "the shading is 'adaptive:0.1'; give some of flat, gouraud"),
        (
            ("--shadings", "adaptive:1", "--subdivisions", "all:1"),
            "the shading adaptive:1 divides by itself; give the subdivision none",
        ),
        (("--subdivisions", "all"), "the subdivision is 'all'; write none, all:1"),
        (("--subdivisions", "all:nan"), "the subdivision is 'all:nan'; give a number from 1 to 4"),
        (("--subdivisions", "halves:2"), "the subdivision is 'halves:2'; write none"),
        (("--size", "0x5"), "the size is 0x5"),
        (("--device", "abacus"), "unknown device 'abacus'; the devices are"),
        (("--generic", "num_channels=1"), "generic num_channels is 1; a picture needs 3"),
    ],
)
def test_bad_input_is_one_line(tmp_path: Path, arguments: tuple[str, ...], said: str) -> None:
    run = trade("sphere:168", "-o", tmp_path / "out", *arguments)
    assert run.exit_code == 2
    assert run.output.startswith(f"quadshade: error: {said}"), run.output
    assert len(run.output.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    run = trade("sphere:168", "-o", tmp_path / "file" / "out", "--size", "32x32", "--no-area", *FEW)
    assert run.exit_code == 2
    assert run.output.startswith(f"quadshade: error: cannot write {tmp_path}/file/out")


def test_density_and_fit_are_axes(tmp_path: Path) -> None:
    """Levels are compared with Phong shading of all triangles; only quadratic colours are fitted."""
    arguments = (
        "torus:288",
        "-o",
        tmp_path,
        "--size",
        "64x64",
        "--no-area",
        "--jobs",
        "1",
        "--exponent",
        "50",
    )
    arguments += ("--shadings", "gouraud,quadratic", "--fractions", "22", "--subdivisions", "none")
    run = trade(*arguments, "--lods", "all,100", "--fits", "six-point,least-squares")
    assert run.exit_code == 0, run.output
    content = json.loads((tmp_path / "trade.json").read_text())
    points = {(p["shading"], p["lod"], p["fit"]): p for p in content["points"]}
    fits = [("gouraud", "six-point"), ("quadratic", "six-point"), ("quadratic", "least-squares")]
    assert set(points) == {(shading, lod, fit) for shading, fit in fits for lod in ("all", "100")}
    for shading, fit in fits:
        fine, coarse = points[shading, "all", fit], points[shading, "100", fit]
        assert fine["mesh_triangles"] > coarse["mesh_triangles"]
        assert fine["line"] > coarse["line"] > 0 and fine["rms"] < coarse["rms"]
        assert coarse["reference"] == "phong-fine.png" and fine["host_seconds"] > 0
    assert points["quadratic", "all", "least-squares"]["rms"] < points["quadratic", "all", "six-point"]["rms"]
    # The level's reference is the fine mesh's own picture.
    names = ("phong-fine.png", points["gouraud", "all", "six-point"]["reference"])
    one, other = (np.asarray(Image.open(tmp_path / name)) for name in names)
    assert np.array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--lods", "most"), "give a number of triangles, or auto"),
        (("--lods", "auto"), "the level of detail is 'auto'; give all, or numbers"),
        (("--lods", "9000"), "the mesh has 288 triangles"),
        (("--fits", "best"), "the fit is 'best'"),
        (("--lods", "all,all"), "give at least one, and each once"),
    ],
)
def test_wrong_densities_and_fits(tmp_path: Path, arguments: tuple[str, str], said: str) -> None:
    run = trade("torus:288", "-o", tmp_path, "--size", "32x32", "--no-area", *arguments)
    assert run.exit_code == 2 and said in run.output
