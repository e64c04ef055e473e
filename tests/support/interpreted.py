# SPDX-License-Identifier: Apache-2.0
"""
Runs commands with every compiled loop as the Python that it is: numpy then checks each index.

``python -m tests.support.interpreted FOLDER`` writes what the commands write, and in ``loops.json`` which
loops they never called, and what a loop says that is given an array one element short.
"""

from __future__ import annotations

import functools
import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

SCENE = ("cube:1", "--size", "20x14", "--camera", "from=1,2,3")
BALL = ("icosphere:0", "--size", "24x20")
COMMANDS = {
    "quadratic.png": ("render", *SCENE),
    "gouraud.png": ("render", *SCENE, "--shading", "gouraud"),
    "specular.png": ("render", *SCENE, "--shading", "quadratic-specular", "--exponent", "50"),
    "xshading.png": ("render", *SCENE, "--setup", "xshading"),
    "phong.png": ("render", *SCENE, "--shading", "phong", "--light", "point=2,2,2"),
    "abbas.png": ("render", *SCENE, "--setup", "abbas"),
    "fit.png": ("render", *SCENE, "--fit", "smooth"),
    "minimax.png": ("render", *BALL, "--exponent", "50", "--fit", "minimax"),
    "squares.png": ("render", *SCENE, "--fit", "least-squares"),
    "cosines.png": ("render", *SCENE, "--shading", "quadratic-specular", "--fit", "minimax"),
    "c1.png": ("render", *SCENE, "--fit", "c1"),
    "taylor.png": ("render", *SCENE, "--setup", "taylor", "--exponent", "20"),
    "adapt.png": ("render", *SCENE, "--max-error", "3", "--exponent", "50"),
    "refit.png": ("render", *BALL, "--exponent", "50", "--max-error", "4", "--fit", "minimax"),
    "incidence.png": ("render", *SCENE, "--max-error", "90", "--material", "fresnel=1.5"),
    "fractional.png": ("render", *SCENE, "--stepping", "fractional"),
    "painter.png": ("render", *SCENE, "--generic", "with_depth=0"),
    "edges.png": ("render", *SCENE, "--edges", "profile,inner"),
    "picture.qs": ("pack", *SCENE),
    "vertices.qs": ("pack", *SCENE, "--vertices"),
    "exact.qs": ("pack", *SCENE, "--pack-error", "0"),
    "board.png": ("render", *SCENE, "--port", "sim", "--engine", "model"),
    "timed.png": ("render", *SCENE, "--port", "sim", "--engine", "model", "--frame-time", "40"),
}
"""What is written, and by which words of the command line; small, because interpreted loops are slow."""

COMPUTED = "computed.npz"
FUSED = "fused "
"""Before the names of what is computed with products fused with sums: each saves a rounding."""


def draw(folder: Path, names: Iterable[str] = tuple(COMMANDS)) -> None:
    """Run commands, which are called by what they write, in this process."""
    from click.testing import CliRunner

    from quadshade.cli.main import main

    for name in names:
        result = CliRunner().invoke(main, [*COMMANDS[name], "-o", str(folder / name)])
        if result.exit_code:
            raise SystemExit(f"{name}: {result.output}\n{result.exception!r}")


def compute(folder: Path) -> None:
    """Loops that no option reaches, on a scene of twelve triangles."""
    import numpy as np

    from quadshade.adapt.cho import highlight_subdivision
    from quadshade.adapt.highlight import highlight_centres
    from quadshade.contract.formats import Formats
    from quadshade.golden.unpacker_clocks import unpacking_clocks, unpacking_of
    from quadshade.image.compare import largest_and_rms
    from quadshade.packing.pack_vertices import pack_vertices
    from quadshade.scene import load_scene, parse_camera, project
    from quadshade.setup.literature.kernels import METHODS, coefficients
    from quadshade.setup.literature.methods import FITS, fit
    from quadshade.setup.tile import Cuttable, Rectangle
    from quadshade.setup.triangle_setup import setup_triangles
    from quadshade.shading.lights import PointLight
    from quadshade.shading.sample import sample
    from tests.support.setup_reference import screen_triangles

    mesh = load_scene("icosphere:1")
    projected = project(mesh, parse_camera("from=1,2,3", mesh), 20, 14)
    light = PointLight((1.0, 2.0, 2.0))
    direction = np.array([1.0, 2.0, 3.0]) / 14**0.5
    divided = highlight_subdivision(projected, [light], threshold=0.05).projected
    vertices = projected.vertices / 256.0
    six = np.random.default_rng(2).random((len(projected), 6))
    terms = {method: fit(method, vertices, six) for method in FITS}
    for method in METHODS:
        terms[FUSED + method] = coefficients(method, vertices, projected.normal, direction)
    where, what = highlight_centres(projected, np.arange(len(projected)), light)
    # Over the screen's borders, and steep enough to be drawn in parts.
    formats = Formats(num_channels=1, coord_bits=4, frac_bits=6)
    numbers = np.random.default_rng(1)
    corners = numbers.integers(*formats.guard_band, (12, 3, 2))
    crossing = screen_triangles(corners, formats, 12, 10, numbers.integers(0, 2, (12, 1, 6)) * 255.0)
    terms["words"] = setup_triangles(crossing, formats, limit=0.02).words
    for name, fractional in (("centre", False), ("fractional", True)):
        whole = Cuttable(setup_triangles(crossing, formats, fractional=fractional), formats)
        for where_cut in (Rectangle(3, 2, 5, 6), Rectangle(0, 0, 12, 10)):
            terms[f"{name}{where_cut.width}"] = whole.to(where_cut).words
        terms[f"{name}_shared"] = whole.interleaved(2, 1, 12, 10).words
    # Triangles as vertices, and in a run between them others that are never sent so.
    formats = Formats()
    cube = load_scene("cube:1")
    sampled = sample(
        project(cube, parse_camera("from=1,2,3", cube), 20, 14, formats), "quadratic", formats=formats
    )
    primitives = setup_triangles(sampled, formats)
    primitives.undefined[1:3] = True
    packed = pack_vertices(primitives, sampled, formats)
    terms["unpacking"] = np.array(unpacking_clocks(unpacking_of(packed.words, formats, packed.vertices)))
    terms["compared"] = np.array(largest_and_rms(*numbers.integers(0, 256, (2, 9, 11, 3), np.uint8)))
    np.savez(folder / COMPUTED, vertices=divided.vertices, where=where, what=what, **terms)


def interpret(uncalled: set[str]) -> None:
    """Let numba's decorator leave a function as it is, and strike it off a set when it is called."""
    import numba

    def njit(*functions: Callable[..., Any], **options: Any) -> Any:
        def decorate(function: Callable[..., Any]) -> Any:
            name = f"{function.__module__}.{function.__qualname__}"
            uncalled.add(name)

            @functools.wraps(function)
            def called(*arguments: Any) -> Any:
                uncalled.discard(name)
                return function(*arguments)

            return called

        return decorate(functions[0]) if functions else decorate

    numba.njit = njit


def said_of_a_short_array() -> str:
    """What a loop of the golden model says of a row of scanlines that is not there."""
    import numpy as np

    from quadshade.contract.formats import Formats
    from quadshade.golden import clocks

    rows = np.ones(3, np.int64)
    first_rows = np.array([0, 4])
    try:
        clocks.count_clocks(np.array([9]), first_rows, rows, Formats())
    except IndexError as error:
        return str(error)
    return ""


def main(folder: Path) -> None:
    """Everything, into a folder."""
    uncalled: set[str] = set()
    interpret(uncalled)
    draw(folder)
    compute(folder)
    found = {
        "uncalled": sorted(name for name in uncalled if name.startswith("quadshade.")),
        "short": said_of_a_short_array(),
    }
    (folder / "loops.json").write_text(json.dumps(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
