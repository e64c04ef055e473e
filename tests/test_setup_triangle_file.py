# SPDX-License-Identifier: Apache-2.0
"""The triangles file: what is read, how it is rounded, and that every fault is named with its place."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError
from quadshade.files import triangle_file
from quadshade.files.triangle_file import open_triangles, read_triangles, write_triangles


def content() -> dict:
    """Two triangles of all three orders, with depth."""
    return {
        "width": 64,
        "height": 48,
        "channels": ["r", "heat"],
        "triangles": [
            {
                "vertices": [[0, 0], [60.5, 1], [3, 40]],
                "samples": {"r": [0, 1, 2, 3, 4, 5.5], "heat": [9]},
                "depth": [0, 10, 65535],
            },
            {
                "vertices": [[-5, 1], [6, 1], [3, 4]],
                "samples": {"heat": [1, 2, 255], "r": [8]},
                "depth": [1, 2, 3],
            },
        ],
    }


def write(path: Path, what: object) -> Path:
    file = path / "triangles.json"
    file.write_text(what if isinstance(what, str) else json.dumps(what))
    return file


def test_read(tmp_path: Path) -> None:
    triangles, formats = open_triangles(write(tmp_path, content()), {"stream_width": 64})
    assert formats == Formats(num_channels=2, with_depth=1, stream_width=64)
    assert (triangles.width, triangles.height, triangles.channels) == (64, 48, ("r", "heat"))
    assert triangles.vertices[0].tolist() == [[0, 0], [60 * 256 + 128, 256], [768, 40 * 256]]
    assert triangles.orders.tolist() == [[2, 0], [0, 1]]
    assert triangles.samples[0, 0].tolist() == [0, 1, 2, 3, 4, 5.5]
    assert triangles.samples[1, 1].tolist() == [1, 2, 255, 0, 0, 0]
    assert triangles.depth.tolist() == [[0, 10, 65535], [1, 2, 3]]


def test_depth_may_be_left_out(tmp_path: Path) -> None:
    given = content()
    for triangle in given["triangles"]:
        del triangle["depth"]
    triangles, formats = open_triangles(write(tmp_path, given), {})
    assert triangles.depth is None
    assert formats.with_depth == 0
    assert open_triangles(write(tmp_path, given), {"with_depth": 1})[1].with_depth == 1


def test_no_triangles(tmp_path: Path) -> None:
    triangles, _ = open_triangles(write(tmp_path, content() | {"triangles": []}), {})
    assert len(triangles) == 0


@pytest.mark.parametrize(
    "pixels, steps",
    ((1 / 512, 0), (3 / 512, 2), (5 / 512, 2), (-1 / 512, 0), (-3 / 512, -2), (0.3, 77), (1 / 511, 1)),
)
def test_vertices_are_rounded_ties_to_even(tmp_path: Path, pixels: float, steps: int) -> None:
    given = content()
    given["triangles"][0]["vertices"][1][0] = pixels
    assert read_triangles(write(tmp_path, given), Formats()).vertices[0, 1, 0] == steps


@given(
    triangles=st.lists(
        st.tuples(st.lists(st.integers(-4096, 8191), min_size=6, max_size=6), st.sampled_from((1, 3, 6))),
        max_size=4,
    ),
    data=st.data(),
)
def test_round_trip(triangles: list, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory) -> None:
    """What is written is read back bit for bit."""
    values = st.floats(0, 255)
    given = content() | {
        "channels": ["r"],
        "triangles": [
            {
                "vertices": np.array(corners).reshape(3, 2).tolist(),
                "samples": {"r": data.draw(st.lists(values, min_size=length, max_size=length))},
            }
            for corners, length in triangles
        ],
    }
    folder = tmp_path_factory.mktemp("round_trip")
    first = read_triangles(write(folder, given), Formats())
    write_triangles(folder / "again.json", first, Formats())
    second = read_triangles(folder / "again.json", Formats())
    for field in ("vertices", "samples", "orders"):
        assert np.array_equal(getattr(first, field), getattr(second, field))
    assert (first.width, first.height, first.channels) == (second.width, second.height, second.channels)


def change(path: tuple, value: object) -> dict:
    """The content with one place changed, or left out where the value is ..."""
    whole = content()
    place = whole
    for key in path[:-1]:
        place = place[key]
    if value is ...:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return whole


CORNER = ("triangles", 1, "vertices", 2)
FAULTS = (
    ("[1, 2", "not JSON"),
    ("[" * 100_000, "not JSON"),
    ("\x00", "not JSON"),
    ('{"width": 1' + "0" * 5000 + "}", "not JSON"),
    ([], "not a JSON object"),
    (change(("width",), ...), "width is null"),
    (change(("width",), 0), "width is 0"),
    (change(("height",), 4097), "height is 4097; give at most 4096"),
    (change(("height",), 2.5), "height is 2.5"),
    (change(("height",), True), "height is true"),
    (change(("channels",), ...), "channels is null"),
    (change(("channels",), []), "give a list of 1 to 8"),
    (change(("channels",), ["a"] * 2), "different names"),
    (change(("channels",), list("abcdefghi")), "1 to 8"),
    (change(("channels",), ["r", 3]), "channels is"),
    (change(("triangles",), ...), "triangles is missing"),
    (change(("triangles",), {}), "triangles is missing or is not a list"),
    (change(("triangles", 1), 7), "triangle 1: is not an object"),
    (change(("triangles", 1, "vertices"), ...), "triangle 1: vertices is missing"),
    (
        change(("triangles", 1, "vertices"), [[0, 0]]),
        "triangle 1: vertices is missing or is not three points",
    ),
    (change(CORNER, [1]), "triangle 1: vertex 3 is 1 values, not 2 numbers"),
    (change(CORNER, ["a", 1]), 'triangle 1: vertex 3: "a" is not a number'),
    (change(CORNER, [True, 1]), "triangle 1: vertex 3: true is not a number"),
    (change(CORNER, [float("nan"), 1]), "triangle 1: vertex 3: nan is not finite"),
    (change(CORNER, [1, float("-inf")]), "triangle 1: vertex 3: -inf is not finite"),
    (change(CORNER, [1, 10**400]), "triangle 1: vertex 3: inf is not finite"),
    (change(CORNER, [1e300, 1]), "triangle 1: triangle out of range: vertex 3"),
    (change(CORNER, [8192, 1]), "triangle 1: triangle out of range: vertex 3 at 8192.0"),
    (change(("triangles", 0, "samples"), ...), "triangle 0: samples is missing"),
    (change(("triangles", 0, "samples", "z"), [1]), "triangle 0: unknown channel 'z'"),
    (change(("triangles", 0, "samples", "r"), ...), "triangle 0: no samples for channel 'r'"),
    (change(("triangles", 0, "samples", "r"), [1, 2]), "'r' is 2 values, not 6 or 3 or 1 numbers"),
    (change(("triangles", 0, "samples", "r"), 5), "channel 'r' is 5, not"),
    (change(("triangles", 0, "samples", "r"), [256]), "channel 'r' has 256.0, outside 0 .. 255"),
    (change(("triangles", 0, "samples", "r"), [1, -0.1, 1]), "channel 'r' has -0.1, outside"),
    (change(("triangles", 0, "samples", "r"), [float("nan")]), "channel 'r': nan is not finite"),
    (change(("triangles", 0, "depth"), ...), "triangle 0: has no depth, others have"),
    (change(("triangles", 1, "depth"), [1, 2]), "triangle 1: depth is 2 values"),
    (change(("triangles", 1, "depth"), [1, 2, 65536]), "triangle 1: depth has 65536.0, outside 0 .. 65535"),
)


@pytest.mark.parametrize(
    "what, message",
    FAULTS,
    ids=lambda v: v.replace(" ", "_")[:60] if isinstance(v, str) and len(v) < 80 else "",
)
def test_faults_are_named(tmp_path: Path, what: object, message: str) -> None:
    file = write(tmp_path, what)
    with pytest.raises(QuadshadeError) as caught:
        open_triangles(file, {})
    text = str(caught.value)
    assert message in text
    assert str(file) in text
    assert "\n" not in text


def test_a_mesh_is_no_triangles_file() -> None:
    with pytest.raises(QuadshadeError) as caught:
        open_triangles(Path(__file__).parents[1] / "examples" / "part.stl", {})
    assert "not JSON" in str(caught.value) and "codec" not in str(caught.value)
    assert "quadshade render" in caught.value.hint


@pytest.mark.parametrize(
    "generics, message",
    (
        ({"num_channels": 3}, "generic num_channels is 3, .* has 2 channels"),
        ({"with_depth": 0}, "generic with_depth is 0, .* has depth"),
        ({"max_order": 1}, "triangle 0: is quadratic, generic max_order is 1"),
        ({"coord_bits": 5}, "width is 64; give at most 32"),
        ({"value_bits": 2}, "triangle 0: channel 'r' has 4.0, outside 0 .. 3"),
        ({"speed": 9}, "no generic 'speed'"),
    ),
    ids=lambda v: "_".join(v) if isinstance(v, dict) else "",
)
def test_generics_that_contradict_the_file(tmp_path: Path, generics: dict[str, int], message: str) -> None:
    with pytest.raises(QuadshadeError, match=message):
        open_triangles(write(tmp_path, content()), generics)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(QuadshadeError, match="cannot read .*nowhere.json: No such file"):
        open_triangles(tmp_path / "nowhere.json", {})


def test_more_than_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused before it is read, so that the system is not brought down first."""
    monkeypatch.setattr(triangle_file, "_available_memory", lambda: 1000)
    with pytest.raises(QuadshadeError, match="too many triangles for this machine's memory"):
        open_triangles(write(tmp_path, content()), {})
