# SPDX-License-Identifier: Apache-2.0
"""Width expressions are integers, names and four operators; whatever else stands in one is refused."""

from __future__ import annotations

import numpy as np
import pytest

from quadshade.contract.arrays import record_dtype
from quadshade.contract.axis import pixel_bytes, pixel_data_bytes
from quadshade.contract.formats import DERIVED, Formats
from quadshade.contract.width_expressions import DerivedWidth, evaluate
from quadshade.errors import QuadshadeError
from quadshade.setup.edges import EDGE_STATE, EdgeState


def test_expressions_are_integers() -> None:
    formats = Formats(word_width=33, stream_width=64)
    assert evaluate("(word_width + 31) / 32 * 2 - 1", formats) == 3
    assert evaluate("stream_width / 32", formats) == formats.beat_words == 2
    assert evaluate("2 ** coord_bits - 1", formats) == (1 << formats.coord_bits) - 1
    # Derived widths may stand in each other's expressions.
    assert evaluate("error_bits - edge_bits", formats) == 1


@pytest.mark.parametrize(
    "text",
    ["2 % 3", "1.5", "'a'", "True and 1", "abs(1)", "word_width.bit_length()", "-1", "[1][0]", "7 // 2"],
)
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is no width"):
        evaluate(text, Formats())


def test_unknown_names_are_refused() -> None:
    with pytest.raises(AttributeError, match="word_breadth"):
        evaluate("word_breadth + 1", Formats())
    with pytest.raises(AttributeError):
        Formats().word_lanes  # noqa: B018


def test_derived_widths_are_attributes_with_a_meaning() -> None:
    formats = Formats()
    for name, expression, meaning in DERIVED:
        width = getattr(Formats, name)
        assert isinstance(width, DerivedWidth) and width.__doc__ == meaning
        assert getattr(formats, name) == evaluate(expression, formats)
        with pytest.raises(AttributeError):
            setattr(formats, name, 1)


def test_records_have_the_columns_of_their_class() -> None:
    assert EDGE_STATE.names == tuple(EdgeState.__annotations__)
    assert record_dtype(EdgeState) == np.dtype([(name, np.int64) for name in EDGE_STATE.names])


@pytest.mark.parametrize(
    ("generics", "hint"),
    [
        ({"num_channels": 9}, "give a value from 1 to 8"),
        ({"frac_bits": 23}, "give a value from 0 to word_width - value_bits - 2 = 22"),
    ],
)
def test_limits_are_named(generics: dict[str, int], hint: str) -> None:
    with pytest.raises(QuadshadeError) as refused:
        Formats(**generics)
    assert refused.value.hint == hint


def test_a_pixel_takes_the_next_power_of_two_of_bytes() -> None:
    sizes = [Formats(num_channels=channels) for channels in (1, 2, 3)]
    found = {pixel_bytes(formats): pixel_data_bytes(formats) for formats in sizes}
    assert found == {7: 8, 8: 8, 9: 16}
