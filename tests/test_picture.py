# SPDX-License-Identifier: Apache-2.0
"""A picture at a prompt, and what it can be compared with."""

from __future__ import annotations

import pytest

import quadshade


def test_a_picture_is_one_line_in_a_terminal() -> None:
    picture = quadshade.render("sphere:168", max_error=4, size=(48, 32), engine="model")
    assert "\n" not in repr(picture)
    assert "sphere:168: 48x32" in repr(picture)


@pytest.mark.parametrize("reference", [3, None, ["phong"]])
def test_a_reference_of_another_type_is_refused(reference) -> None:
    picture = quadshade.render("sphere:24", size=(48, 32), engine="model")
    with pytest.raises(quadshade.QuadshadeError, match="the reference is of type"):
        picture.error_to(reference)


def test_what_is_averaged_is_called_a_picture() -> None:
    """A frame is a message on the line and nothing else (``docs/reference/glossary.md``)."""
    picture = quadshade.render("sphere:24", size=(48, 32), engine="model", supersample=2)
    assert f"{picture.stats.clocks} clocks a picture, the mean of 4 pictures" in picture.summary
    assert "frame" not in repr(picture)
