# SPDX-License-Identifier: Apache-2.0
"""Of a power table only what a picture reads is sent: whatever is in the rest, the picture is the same."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.adapt import adapt, stream_bytes
from quadshade.adapt.costs import state_bytes
from quadshade.board import Board, BoardSettings
from quadshade.choices import MAX_ERROR
from quadshade.contract.formats import POWER_MANTISSA_BITS, STATE_REGISTERS, Formats
from quadshade.contract.shade_state import ShadeState, table_entries
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw
from quadshade.golden.core import raster_core
from quadshade.golden.shade.power_table import distance, exponent, normalise
from quadshade.golden.shade.render_core import draw as draw_words
from quadshade.golden.shade.render_core import first_entry, needed_writes
from quadshade.image import resolve
from quadshade.packing.pack import pack_primitives, packed_writes, unpack
from quadshade.scene import Projected, fit_camera, load_scene, project
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles
from quadshade.shading import Material, sample_specular, specular_formats
from quadshade.shading.lights import DirectionalLight, PointLight

SHINY = Material(exponent=50)
GARBAGE = 0xDEADBEEF


def looked_at(scene: str, size: int = 40) -> Projected:
    mesh = load_scene(scene)
    return project(mesh, fit_camera(mesh), size, size)


def pictures() -> list[tuple[ScreenTriangles, Formats]]:
    """Adaptive ones, of one light and of two, and six points whose cosines reach all octaves."""
    whole = looked_at("sphere:168")
    lights = (DirectionalLight((1.0, 1.0, 2.0)), PointLight((-3.0, 2.0, 2.0), (0.5, 0.6, 0.7)))
    made = []
    for given in (None, lights):
        adapted = adapt(whole, given, SHINY, max_error=2.0, shading="quadratic-specular")
        made.append((adapted.triangles, adapted.formats))
    formats = specular_formats({}, whole, None, SHINY)
    return [*made, (sample_specular(whole, material=SHINY, formats=formats), formats)]


def with_garbage(writes: np.ndarray, formats: Formats) -> ShadeState:
    """The state of a board whose tables held something else before these words were written."""
    everywhere = dict.fromkeys(range(STATE_REGISTERS), GARBAGE)
    return ShadeState.from_registers(everywhere | dict(writes.tolist()), formats)


@pytest.mark.parametrize("error", [0.0, 1.0])
def test_what_is_not_sent_is_not_read(error: float) -> None:
    for triangles, formats in pictures():
        state = triangles.shade
        assert state is not None
        batch = pack_primitives(setup_triangles(triangles, formats, limit=MAX_ERROR), formats, error, state)
        words = unpack(batch.words, formats)
        writes = packed_writes(batch.words, state, formats)
        assert len(writes) <= len(state.writes())
        drawn = draw_words(words, formats, state)
        again = draw_words(words, formats, with_garbage(writes, formats))
        assert (again.value == drawn.value).all()
        # The first entry that is sent is read, by the scalar model of the table.
        lanes = raster_core.draw_scalar(words.tolist(), formats.core)
        far = [
            distance(max(one.value[formats.num_channels - formats.num_specular : -1]), formats)
            for one in lanes
        ]
        entries = [normalise(one, exponent(one), formats)[0] for one in far]
        assert int(writes[0, 0]) == min(entries)


def test_adaptive_pictures_read_a_part_of_the_tables() -> None:
    (triangles, formats), *_, (six, plain) = pictures()
    entries = table_entries(formats)
    assert triangles.shade is not None and six.shade is not None
    words = pack(setup_triangles(triangles, formats, limit=MAX_ERROR), formats)
    first = int(needed_writes(words, triangles.shade, formats)[0, 0])
    # For this error cosines reach 7/8: three octaves of the table, and with them the least bytes.
    assert entries - first == 3 << POWER_MANTISSA_BITS
    assert state_bytes(triangles, formats) == 4 * len(triangles.shade.writes(first)) < state_bytes(six, plain)
    assert stream_bytes(triangles, formats) == 4 * len(words) + state_bytes(triangles, formats)
    # The error that the coarser table costs is in what planning verified.
    assert draw(triangles, formats).pixels.value.max() <= 255


def test_entries_are_counted_from_the_highest_value() -> None:
    (triangles, formats), *_ = pictures()
    state = triangles.shade
    assert state is not None
    top = (1 << formats.lane_value_bits) - 1
    assert first_entry(top, formats) == 0
    assert first_entry(0, formats) == table_entries(formats) - 1
    assert first_entry(-1, formats) == table_entries(formats)
    rising = [first_entry(value, formats) for value in range(0, top, top // 999)]
    assert rising == sorted(rising, reverse=True)
    for first in (0, 1, rising[500], table_entries(formats)):
        assert state.num_writes(first) == len(state.writes(first))


def test_a_board_draws_the_model_s_pictures_one_after_the_other() -> None:
    """What an earlier picture left in the tables is not read by a later one."""
    size, exponents = (64, 48), (50, 20, 90)
    mesh = load_scene("sphere:168")
    whole = project(mesh, fit_camera(mesh), *size)
    made = [
        adapt(whole, None, Material(exponent=exponent), max_error=4.0, shading="quadratic-specular")
        for exponent in exponents
    ]
    settings = BoardSettings(formats=made[0].formats, screen_width=size[0], screen_height=size[1])
    with Board("sim", engine="model", settings=settings) as board:
        for adapted in made:
            assert adapted.triangles.shade is not None
            board.clear((1, 2, 3))
            board.draw(adapted.triangles, pack_error=0)
            expected = resolve(draw(adapted.triangles, adapted.formats).pixels, *size, (1, 2, 3))
            assert np.array_equal(board.read(), expected)
        assert len(board._registers) < 0.6 * len(made[0].triangles.shade.writes())
