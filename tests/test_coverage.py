# SPDX-License-Identifier: Apache-2.0
"""Coverage: what counts as a decision, what is a compiler's own branch, and what fails the command."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from cocotb_tests.support.cover import SOURCES, Cover
from quadshade.engine.build_cache import build_key
from quadshade.engine.sources import rtl_files
from scripts.coverage.__main__ import EXCEPTIONS
from scripts.coverage.arcs import FAKE, ON_TREE, Arc, Function
from scripts.coverage.functional import read_crosses
from scripts.coverage.page import page
from scripts.coverage.rtl_coverage import FileCoverage, check, coverage_of, read_counts, read_exceptions
from scripts.coverage.vhdl_lines import assertion_lines, decision_lines

ROOT = Path(__file__).resolve().parents[1]

VHDL = """\
entity e is -- if this were one
end entity;
architecture rtl of e is
begin
  assert width < 5
    report "if a then"
    severity failure;
  shown <= a when place = rest
    and left = 0
    else b;
  process (clk)
  begin
    if rising_edge(clk) then
      case place is
        when rest =>
          place <= begins;
        when others =>
          null;
      end case;
      if a = '1'
        and b = '1' then
        c <= '1';
      elsif c = '0' then
        c <= ''';
      end if;
      while x > 1 loop
        x := x - 1;
        exit when y;
      end loop;
    end if;
  end process;
end architecture;
"""


def test_decisions_and_assertions() -> None:
    assert decision_lines(VHDL) == {8, 9, 10, 13, 14, 20, 21, 23, 26, 28}
    assert assertion_lines(VHDL) == {5, 6, 7}


def function(arcs: list[tuple[int, int, int]], lines: dict[int, int]) -> Function:
    """A function of blocks 0 (enter), 1 (leave) and more; each block has a line of one file."""
    found = Function("process", 1, 1 + max(max(arc[:2]) for arc in arcs))
    found.arcs = [Arc(*arc) for arc in arcs]
    for block, line in lines.items():
        found.lines[block] = [("/e.vhd", line)]
    return found


def test_counts_follow_from_those_that_are_written() -> None:
    arcs = [(0, 2, 0), (2, 3, 0), (2, 4, ON_TREE), (3, 5, ON_TREE), (4, 5, ON_TREE), (5, 1, ON_TREE)]
    found = function(arcs, {2: 1, 3: 2, 4: 3, 5: 4})
    found.solve([10, 3])
    assert [arc.count for arc in found.arcs] == [10, 3, 7, 3, 7, 10]
    assert found.executed() == {("/e.vhd", 1): 10, ("/e.vhd", 2): 3, ("/e.vhd", 3): 7, ("/e.vhd", 4): 10}
    assert sorted(found.branches()) == [(("/e.vhd", 1), 3), (("/e.vhd", 1), 7)]
    with pytest.raises(ValueError):
        found.solve([10])


def test_branches_of_the_compiler_are_none() -> None:
    # An index check that fails, whose call never returns.
    check_of_index = [(0, 2, 0), (2, 3, 0), (2, 4, ON_TREE), (3, 1, FAKE), (4, 1, ON_TREE)]
    # An assignment: where is the driver's value, and is the new one another?
    driver = [(0, 2, 0), (2, 3, 0), (2, 4, ON_TREE), (3, 5, ON_TREE), (4, 5, ON_TREE)]
    driver += [(5, 6, 0), (5, 7, ON_TREE), (6, 7, ON_TREE), (6, 1, FAKE), (7, 1, ON_TREE)]
    # Is a slice's range empty? If not, is its length a wrong one?
    slices = [(0, 2, 0), (2, 3, 0), (2, 4, ON_TREE), (3, 6, ON_TREE), (4, 5, 0), (4, 6, ON_TREE)]
    slices += [(5, 6, ON_TREE), (5, 1, FAKE), (6, 1, ON_TREE)]
    for arcs in (check_of_index, driver, slices):
        found = function(arcs, dict.fromkeys(range(2, 8), 1))
        found.solve([0] * len(found.counted()))
        assert list(found.branches()) == []
    # The second operand of an `and` is looked at or not.
    short = [(0, 2, 0), (2, 3, 0), (2, 4, ON_TREE), (3, 4, ON_TREE), (4, 5, 0), (4, 6, ON_TREE)]
    short += [(5, 7, ON_TREE), (6, 7, ON_TREE), (7, 1, ON_TREE)]
    found = function(short, {2: 1, 3: 1, 4: 1, 5: 2, 6: 3, 7: 4})
    found.solve([9, 0, 0])
    assert [count for _, count in found.branches()] == [0, 9, 0, 9]


def test_what_was_not_run_needs_a_reason(tmp_path: Path) -> None:
    (tmp_path / "e.vhd").write_text(VHDL)
    found = {"e.vhd": FileCoverage({13: 5, 16: 0, 20: 5, 22: 5}, {13: [5, 5], 16: [0, 0], 20: [5, 0, 5, 0]})}
    faults, excused = check(found, [], tmp_path)
    assert (
        faults
        == [
            "e.vhd:16: not executed: place <= begins;",
            "e.vhd:20: 2 ways not gone: if a = '1'",
        ]
        and not excused
    )
    statement = {"file": "e.vhd", "line": "place <= begins;", "kind": "statement", "why": "never begins"}
    branch = {"file": "e.vhd", "line": "if a = '1'", "kind": "branch", "ways": 2, "why": "a is tied"}
    assert check(found, [statement, branch], tmp_path) == (
        [],
        Counter({("e.vhd", "statement"): 1, ("e.vhd", "branch"): 2}),
    )
    text = page(found, [statement, branch], check(found, [statement, branch], tmp_path)[1], [], "tools")
    assert "| `e.vhd` | 4 | 3 | 1 | 8 | 6 | 2 |" in text and "2 of its ways | a is tied |" in text
    for wrong in (statement | {"line": "place <= ends;"}, branch | {"ways": 1}, branch | {"file": "f.vhd"}):
        faults, _ = check(found, [statement, branch, wrong], tmp_path)
        assert len(faults) == 1 and "has no such line" in faults[0]
    assert check({"e.vhd": FileCoverage()}, [], tmp_path)[0] == ["e.vhd: nothing of it was run"]


def test_assertions_count_only_where_they_were_reached(tmp_path: Path) -> None:
    (tmp_path / "e.vhd").write_text(VHDL)
    ran = function(
        [(0, 2, 0), (2, 3, 0), (2, 4, ON_TREE), (3, 4, ON_TREE), (4, 1, ON_TREE)], {2: 5, 3: 6, 4: 8}
    )
    ran.lines = {block: [(str(tmp_path / "e.vhd"), line)] for block, ((_, line),) in ran.lines.items()}
    ran.solve([4, 0])
    found = coverage_of([ran], tmp_path, [tmp_path / "e.vhd"])["e.vhd"]
    assert found.statements == {5: 4, 8: 4} and not found.branches


def test_counts_of_other_sources_are_refused(tmp_path: Path) -> None:
    data, libraries, source = tmp_path / "data", tmp_path / "libraries", tmp_path / "e.vhd"
    source.write_text(VHDL)
    with pytest.raises(ValueError, match="has no counts"):
        read_counts(data, libraries, [source])
    for folder in (data / "1a", libraries / "1a"):
        folder.mkdir(parents=True)
    (data / "1a" / "e.gcda").write_bytes(b"adcg" + b"*31B" + bytes(8))
    (data / "1a" / SOURCES).write_text(build_key(source))
    (libraries / "1a" / "e.gcno").write_bytes(b"oncg" + b"*31B" + bytes(8))
    with pytest.raises(ValueError, match=r"e.gcno: not written by a program of gcc 12"):
        read_counts(data, libraries, [source])
    source.write_text(VHDL + "-- changed\n")
    with pytest.raises(ValueError, match=r"1a was run on other sources"):
        read_counts(data, libraries, [source])


def test_every_reason_names_a_line_of_the_rtl() -> None:
    names = {str(path.relative_to(ROOT)) for path in rtl_files(ROOT)}
    for row in read_exceptions(EXCEPTIONS):
        assert row["file"] in names and row["why"]
        assert row["line"] in {line.strip() for line in (ROOT / row["file"]).read_text().splitlines()}


def test_crosses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bins = {"order": ("0", "1"), "held": ("0", "1")}
    impossible = [("nothing to hold", {"order": ["0"], "held": ["1"]})]
    cover = Cover("unit", bins, impossible)
    cover.sample(order=1, held=0)
    with pytest.raises(ValueError, match="unit: order is 2"):
        cover.sample(order=2, held=0)
    cover.save()
    assert not list(tmp_path.iterdir())
    monkeypatch.setenv("QUADSHADE_COVERAGE", str(tmp_path))
    cover.save()
    for _ in range(2):
        cover.sample(order=0, held=0)
        cover.save()
    (cross,) = read_crosses(tmp_path)
    assert cross.hits == {("1", "0"): 1, ("0", "0"): 2}
    assert cross.faults() == ["unit: 1, 1: not driven"]
    cover.sample(order=0, held=1)
    cover.sample(order=1, held=1)
    cover.save()
    (cross,) = read_crosses(tmp_path)
    assert cross.faults() == ["unit: 0, 1: driven, and yet nothing to hold"]
    text = page({}, [], Counter(), [cross], "tools")
    assert "3 of 3 possible combinations were driven (100.0 %), 1 of 4 cannot be" in text
    Cover("unit", {"order": ("0",)}).save()
    with pytest.raises(ValueError, match="run with other values"):
        read_crosses(tmp_path)
