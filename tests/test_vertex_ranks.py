# SPDX-License-Identifier: Apache-2.0
"""The bound that is proved of a packet with vertices, and programs for which there is none."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from quadshade.contract.formats import Formats
from quadshade.contract.vertex_program import IMMEDIATE, INDEXED, program
from quadshade.errors import QuadshadeError
from scripts import formal, vertex_ranks, vertex_ways
from scripts.vertex_ways import START, Code
from tests.support.vertex_stimuli import most_clocks
from tests.test_vertices import FORMATS


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
def test_bound_is_below_the_walk_of_the_program(formats: Formats) -> None:
    """The walk takes every instruction for the slowest of its kind; the proof follows constants."""
    assert most_clocks(formats) / 2 < vertex_ranks.table(formats).bound <= most_clocks(formats)


def test_pages_quote_the_bounds() -> None:
    (proof,) = (proof for proof in formal.load_proofs() if proof.name == "vertex_unpacker")
    page = (formal.ROOT / "docs" / "explanation" / "formal.md").read_text()
    for config in range(len(proof.configs)):
        formats = Formats(**formal.Job(proof, config).generics)
        assert f"{vertex_ranks.table(formats).bound:,}" in page
    reference = (formal.ROOT / "docs" / "reference" / "vertices.md").read_text()
    assert f"{vertex_ranks.table(Formats()).bound:,}" in reference


@pytest.mark.parametrize(
    ("at", "change"),
    [
        (lambda line: line.row.operation == "jmp", {"operand": 2}),
        (lambda line: (line.row.operation, line.operand) == ("add", 8), {"operand": 0}),
        (lambda line: line.row.operation == "loop", {"count": 9}),
    ],
    ids=["jump back", "table without an end", "index that wraps"],
)
def test_program_without_a_bound_is_refused(
    at: Callable[[Code], bool], change: dict[str, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the first instruction that is meant another operand, or count."""
    formats = FORMATS[0]
    code = list(vertex_ways.codes(formats))
    place = next(place for place, line in enumerate(code) if at(line))
    code[place] = code[place]._replace(**change)
    monkeypatch.setattr(vertex_ways, "codes", lambda _: tuple(code))
    with pytest.raises(QuadshadeError, match="may never end"):
        vertex_ways.clocks_to_go(formats, vertex_ways.reached(START, formats, "t"))


@pytest.mark.parametrize("formats", FORMATS, ids=range(len(FORMATS)))
def test_writes_belong_to_what_the_pointer_was_loaded_from(formats: Formats) -> None:
    """Of every write behind the pointer: the load above it in the program's text."""
    places, loaded = program().places, -1
    kinds = {places[cell]: 2 + kind for kind, cell in enumerate(vertex_ranks.CELLS)}
    for line, row in zip(vertex_ways.codes(formats), vertex_ranks.table(formats).rows, strict=False):
        if line.row.operation == "ldp":
            loaded = vertex_ranks.CONSTANT if line.row.mode == IMMEDIATE else kinds.get(line.operand, 0)
        if line.row.operation in ("st", "stq") and line.row.mode == INDEXED and row.reached:
            assert row.pointer == loaded > vertex_ranks.UNKNOWN


def test_rows_fit_their_bits() -> None:
    row = vertex_ranks.Row(1, acc_least=-1)
    bits = int(vertex_ranks.packed_rows((row,)), 16)
    below = sum(vertex_ranks.BITS[vertex_ranks.BITS._fields.index("acc_least") + 1 :])
    assert bits >> below == 1 << sum(vertex_ranks.BITS[1:]) - below | (1 << vertex_ranks.BITS.acc_least) - 1
    with pytest.raises(QuadshadeError, match="does not fit"):
        vertex_ranks.packed_rows((vertex_ranks.Row(0, owner=8),))
