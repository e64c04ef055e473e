# SPDX-License-Identifier: Apache-2.0
"""The object ``shade`` of a triangles file, and what ``quadshade raster`` draws from it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import shade_state
from quadshade.errors import QuadshadeError
from quadshade.files.triangle_file import open_triangles, read_triangles, write_triangles


def content(**shade) -> dict:
    """A triangle that fills its screen, a constant diffuse and a linear specular channel."""
    given = {"specular": ["s"], "ambient": [0.1, 0, 0.2], "colour": [[0.5, 0.25, 0]], "light": [[0, 1, 2]]}
    return {
        "width": 16,
        "height": 16,
        "channels": ["d", "s"],
        "shade": {**given, **({} if "table" in shade or "tables" in shade else {"exponent": 3}), **shade},
        "triangles": [
            {"vertices": [[0, 0], [64, 0], [0, 64]], "samples": {"d": [102], "s": [255, -255, 255]}}
        ],
    }


def write(folder: Path, what: dict) -> Path:
    file = folder / "triangles.json"
    file.write_text(json.dumps(what))
    return file


def drawn(folder: Path, what: dict) -> dict[str, np.ndarray]:
    """What ``quadshade raster`` writes."""
    out = folder / "pixels.npz"
    result = CliRunner().invoke(main, ["raster", str(write(folder, what)), "-o", str(out)])
    assert result.exit_code == 0, result.output
    return dict(np.load(out))


def shown(pixels: dict[str, np.ndarray], cosine: np.ndarray, power: np.ndarray) -> None:
    """The pixels are the formula's, rounded; half a level and the units' bounds off at most."""
    factor = np.stack([0 * cosine + 102 / 255, power])
    exact = np.array([0.1, 0, 0.2]) + factor.T @ [[0.5, 0.25, 0], [0, 1, 2]]
    assert pixels["value"].shape == (256, 3)
    assert np.abs(pixels["value"] - 255 * exact.clip(0, 1)).max() < 0.56


def test_the_formula_at_every_pixel(tmp_path: Path) -> None:
    pixels = drawn(tmp_path, content())
    cosine = 1 - (pixels["x"] + 0.5) / 32
    shown(pixels, cosine, cosine.clip(0) ** 3)


def test_a_table_is_straight_between_its_values(tmp_path: Path) -> None:
    for table in ([0, 0.5, 0.25], [[0, 0], [0.5, 0.5], [1, 0.25]]):
        for shade in ({"table": table}, {"tables": [table]}):
            pixels = drawn(tmp_path, content(**shade))
            cosine = 1 - (pixels["x"] + 0.5) / 32
            shown(pixels, cosine, np.interp(cosine, [0, 0.5, 1], [0, 0.5, 0.25]))


def test_a_gate_is_the_lights_cosine(tmp_path: Path) -> None:
    """Where the diffuse channel is not positive the specular one counts only if it is not gated."""
    dark = content()
    dark["triangles"][0]["samples"] = {"d": [-1], "s": [255]}
    assert (drawn(tmp_path, dark)["value"] == [26, 0, 51]).all()
    dark["shade"]["gated"] = False
    assert (drawn(tmp_path, dark)["value"] == [26, 255, 255]).all()


def test_the_core_is_built_to_fit(tmp_path: Path) -> None:
    what = content(specular=2, colour=[], light=[[1, 1, 1], [0, 0, 0]], exponent=[1, 1024])
    triangles, formats = open_triangles(write(tmp_path, what), {"stream_width": 64})
    assert formats == Formats(with_shade=1, num_channels=2, num_specular=2, with_depth=0, stream_width=64)
    assert triangles.shade.gated == 3 and triangles.shade.coefficients.tolist() == [[65536] * 3, [0] * 3]
    assert (triangles.shade.tables[0] != triangles.shade.tables[1]).any()


def test_written_and_read_again_it_is_the_same(tmp_path: Path) -> None:
    triangles, formats = open_triangles(write(tmp_path, content(gated=False)), {})
    file = tmp_path / "again.json"
    write_triangles(file, triangles, formats)
    again = read_triangles(file, formats)
    assert (again.samples == triangles.samples).all()
    for name in ("ambient", "coefficients", "tables", "linear", "gated", "guard_bits"):
        assert np.array_equal(getattr(again.shade, name), getattr(triangles.shade, name)), name


@pytest.mark.parametrize(
    ("shade", "message"),
    [
        ({"specular": ["d"]}, "specular is not the last of the channels d, s"),
        ({"specular": 0}, "specular is not the last channels' names or their number"),
        ({"specular": True}, "specular is not"),
        ({"specular": 3}, "specular is not"),
        ({"ambient": [0, 0]}, "ambient is not 3 numbers"),
        ({"ambient": [0, 0, 1.5]}, "ambient has 1.5, not a number from 0 to 1"),
        ({"ambient": [0, 0, float("nan")]}, "ambient has nan"),
        ({"colour": [[1, 1, 4]]}, "colour 0 has 4, not a number from 0 to 4"),
        ({"colour": []}, "colour is not a list of 1 colours"),
        ({"light": [[1, 1, "x"]]}, "light 0 has x"),
        ({"exponent": 0.5}, "exponent has 0.5, not a number from 1 to 1024"),
        ({"exponent": [1, 2]}, "exponent is not 1 numbers"),
        ({"exponent": 5, "table": [0, 1]}, "has exponent and table; give one"),
        ({"table": [1]}, "table is not a list of at least two values"),
        ({"table": [[0.5, 0], [0.4, 1]]}, "table has cosines that fall"),
        ({"table": [0, 2]}, "table has 2"),
        ({"tables": [[0, 1], [0, 1]]}, "tables is not a list of 1 tables"),
        ({"gated": 1}, "gated is not true or false"),
        ({"color": []}, "unknown key 'color'"),
    ],
)
def test_faults_are_named(tmp_path: Path, shade: dict, message: str) -> None:
    with pytest.raises(QuadshadeError, match=r"triangles\.json: shade: .*") as caught:
        open_triangles(write(tmp_path, content(**shade)), {})
    assert message in str(caught.value)


def test_samples_are_cosines_only_with_shade(tmp_path: Path) -> None:
    what = content()
    what["triangles"][0]["samples"]["d"] = [-255.5]
    with pytest.raises(QuadshadeError, match=r"triangle 0: channel 'd' has -255\.5, outside -255 \.\. 255"):
        open_triangles(write(tmp_path, what), {})
    del what["shade"]
    with pytest.raises(QuadshadeError, match=r"outside 0 \.\. 255"):
        open_triangles(write(tmp_path, what), {})
    for generics in ({"with_shade": 0}, {"num_specular": 2}):
        with pytest.raises(QuadshadeError, match=r"generic \w+ is \d, .*triangles\.json needs 1"):
            open_triangles(write(tmp_path, content()), generics)


def test_a_state_from_python_draws_as_the_file(tmp_path: Path) -> None:
    triangles, formats = open_triangles(write(tmp_path, content()), {})
    made = shade_state(formats, [0.1, 0, 0.2], [[0.5, 0.25, 0], [0, 1, 2]], [lambda x: x**3], gated=1)
    assert (made.tables == triangles.shade.tables).all() and (made.ambient == triangles.shade.ambient).all()
