# SPDX-License-Identifier: Apache-2.0
"""The mutator of the RTL, and a mutant of each unit that its bench has to notice again."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from quadshade.errors import QuadshadeError
from scripts.mutation.report import REPORT, score, wilson, with_section
from scripts.mutation.rtl import report
from scripts.mutation.rtl.__main__ import main
from scripts.mutation.rtl.benches import ROOT, above, cases_of, digest, rtl_paths
from scripts.mutation.rtl.equivalence import netlist_of, proved
from scripts.mutation.rtl.results import Result, append, known, load, publishable
from scripts.mutation.rtl.run_netlist import NetlistRun
from scripts.mutation.rtl.run_text import digest_of, own_units, sampled
from scripts.mutation.rtl.settle import STEPS, Settling, tried
from scripts.mutation.rtl.simulate_case import VhdlBuild
from scripts.mutation.rtl.vhdl_text import TextMutant, mutants_of
from scripts.mutation.rtl.vhdl_tokens import tokens_of

NUMBERS = json.loads(report.NUMBERS.read_text())
SLOW = {"board", "raster_core", "render_core", "screen"}
"""Their benches take longest to build; `make mutation` runs them."""

ARCHITECTURE = """\
entity small is
  generic (width : positive := 4);
end entity;
architecture rtl of small is
  signal one, two : std_ulogic := '0';  -- '1' and 7 here are a comment
  type state_t is (idle, busy);
begin
  out_port <= '1' when one = '0' else two;
  clocked : process (clk)
    variable total : natural := 3;
  begin
    if rising_edge(clk) then
      total := total - 1;
      if reset = '1' or one = '1' then
        one <= std_ulogic'('0');
      end if;
    end if;
  end process;
  assert width > 2 report "width is 1" severity failure;
end architecture;
"""


def changes(text: str) -> list[tuple[int, str]]:
    return [(mutant.line, mutant.what) for mutant in mutants_of("rtl/small.vhd", text)]


def test_changes_are_those_a_bench_should_notice() -> None:
    found = changes(ARCHITECTURE)
    assert {line for line, _ in found} <= {8, 10, 13, 14, 15}
    assert {what for line, what in found if line == 8} == {
        "`'1'` becomes `'0'`", "`=` becomes `/=`", "`'0'` becomes `'1'`",
        "`one` becomes `two`", "`two` becomes `one`",
    }  # fmt: skip
    assert {what for line, what in found if line == 10} == {"`3` becomes `4`", "`3` becomes `2`"}
    assert (13, "`total := total - 1` becomes `null`") in found
    assert (14, "`or` becomes `and`") in found
    assert (14, "`reset = '1' or one = '1'` becomes `not (reset = '1' or one = '1')`") in found
    assert (15, "`'0'` becomes `'1'`") in found
    assert (15, "`one <= std_ulogic'('0')` becomes `null`") in found


def test_a_name_stays_when_other_lines_change() -> None:
    one = {mutant.name: mutant.what for mutant in mutants_of("rtl/small.vhd", ARCHITECTURE)}
    moved = ARCHITECTURE.replace("begin\n  out_port", "begin\n  more <= '0';\n\n    out_port")
    other = {mutant.name: mutant.what for mutant in mutants_of("rtl/small.vhd", moved)}
    assert one.items() <= other.items()
    assert len(other) > len(one)


def test_ticks_of_attributes_are_no_characters() -> None:
    assert [token.text for token in tokens_of("a'length = '1' & b'('0')")] == [
        "a", "'", "length", "=", "'1'", "&", "b", "'", "(", "'0'", ")",
    ]  # fmt: skip


def test_every_unit_has_mutants_of_every_kind() -> None:
    every = [mutant for unit in rtl_paths() for mutant in sampled(unit, seed=1)]
    assert len({mutant.name for mutant in every}) == len(every) > 9000
    kinds = Counter(mutant.kind for mutant in every)
    assert set(kinds) == {
        "arithmetic", "condition", "constant", "dropped", "index",
        "logic", "operand", "range", "relation", "swapped",
    }  # fmt: skip
    for mutant in every[:: len(every) // 50]:
        text = (ROOT / mutant.file).read_text()
        changed = mutant.apply(text)
        assert changed != text
        assert changed.splitlines()[: mutant.line - 1] == text.splitlines()[: mutant.line - 1]


def test_a_larger_sample_begins_with_the_smaller_one() -> None:
    assert sampled("edge_dda", 1)[:20] == sampled("edge_dda", 1)[:30][:20]
    assert sampled("edge_dda", 1)[:20] != sampled("edge_dda", 2)[:20]


def test_cases_are_those_that_pytest_runs() -> None:
    cases = cases_of("edge_dda")
    assert [case.label for case in cases][:2] == ["default", "coord_bits=3-subpixel_bits=0"]
    assert dict(cases[0].generics) == {"column_bits": 13, "edge_bits": 22}
    assert {case.module for case in cases_of("screen")} == {
        "cocotb_tests.screen.test_screen",
        "cocotb_tests.screen.test_screen_video",
    }
    assert cases_of("memory_pkg") == []
    assert "block_ram" in own_units("memory_pkg")
    assert len(digest("edge_dda")) == 12 and digest("edge_dda") != digest("load_adder")
    assert above("edge_dda")[:2] == ["edge_walker", "raster_core"]
    assert set(above("edge_dda")[-2:]) == {"board", "quadshade_axis"} and above("board") == []
    for unit in set(rtl_paths()) - {"memory_pkg", "screen_pkg"}:
        assert cases_of(unit), unit


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> VhdlBuild:
    return VhdlBuild(tmp_path_factory.mktemp("mutation") / "rtl")


def killed_before() -> list[dict[str, str]]:
    """Every second unit's; the seed says which."""
    entries = [entry for entry in NUMBERS["kill_again"] if entry["unit"] not in SLOW]
    return entries[int(os.environ.get("QUADSHADE_SEED", "1")) % 2 :: 2]


@pytest.mark.parametrize("entry", killed_before(), ids=lambda entry: entry["unit"])
def test_a_mutant_is_killed_again(build: VhdlBuild, entry: dict[str, str]) -> None:
    found = [mutant for mutant in sampled(entry["unit"], NUMBERS["seed"]) if mutant.name == entry["name"]]
    if not found:
        pytest.skip("its line is another by now: `make mutation` takes another mutant")
    (mutant,) = found
    cases = [case for unit in own_units(entry["unit"]) for case in cases_of(unit)]
    (case,) = [case for case in cases if case.name == entry["case"]]
    build.mutate(mutant.file, mutant.apply((ROOT / mutant.file).read_text()))
    try:
        build.make(case.unit)
        ran = build.run(case)
    finally:
        build.mutate(mutant.file, None)
    assert ran.verdict in ("failed", "crashed"), f"{mutant.original}: {mutant.what} is not noticed: {ran}"


def test_most_mutants_of_the_sample_are_still_there() -> None:
    names = {mutant.name for unit in rtl_paths() for mutant in sampled(unit, NUMBERS["seed"])}
    kept = [entry["name"] in names for entry in NUMBERS["kill_again"]]
    assert kept and sum(kept) >= 0.75 * len(kept), "the RTL is another by now: run `make mutation`"


def test_a_netlist_with_its_mutants_is_simulated_once(tmp_path: Path) -> None:
    run = NetlistRun("load_adder", tmp_path, count=6, seed=1)
    results = list(run.own(run.mutants))
    assert [result.name for result in results] == [mutant.name for mutant in run.mutants]
    assert len({result.name for result in results}) == 6
    assert {result.verdict for result in results} <= {"killed", "survived"}
    assert sum(result.verdict == "killed" for result in results) >= 4
    logs = sorted((tmp_path / "load_adder_netlist").glob("mutant_*.log"))
    assert len(logs) == 7, "the netlist as it is, and six mutants"


def test_what_is_no_hardware_is_not_chosen(tmp_path: Path) -> None:
    """Yosys aborts where a memory's reading without a clock is given an enable."""
    run = NetlistRun("single_port_ram", tmp_path, count=15, seed=1, label="num_words=2-data_bits=1")
    listed = (tmp_path / "single_port_ram_netlist" / "mutants.txt").read_text().splitlines()
    assert len(run.mutants) == 15 < len(listed)
    assert len(list(run.own(run.mutants))) == 15


def mutant_of(unit: str, original: str, what: str) -> TextMutant:
    (found,) = [one for one in sampled(unit, 1) if (one.original, one.what) == (original, what)]
    return found


def test_proofs_tell_equal_netlists_from_others(build: VhdlBuild, tmp_path: Path) -> None:
    """The bit that the range holds more is of no effect where the value is negative; the one it lacks is."""
    case = cases_of("output_clamp")[0]
    line = "over <= or word(high - 1 downto frac_bits + value_bits);"
    netlists = []
    for what in (None, "`1` becomes `0`", "`1` becomes `2`"):
        mutant = mutant_of("output_clamp", line, what) if what else None
        path = rtl_paths()["output_clamp"]
        build.mutate(str(path.relative_to(ROOT)), mutant.apply(path.read_text()) if mutant else None)
        build.make(case.unit)
        netlists.append(netlist_of(build, case))
    build.mutate(str(path.relative_to(ROOT)), None)
    clean, same, other = netlists
    assert clean and same != clean
    assert proved(clean, same, case.unit, tmp_path / "same")
    assert not proved(clean, other, case.unit, tmp_path / "other")


def test_interval_is_that_of_the_tables() -> None:
    """Newcombe (1998), Statistics in Medicine 17, table I, method 3."""
    expected = {
        (81, 263): (0.2553, 0.3662),
        (15, 148): (0.0624, 0.1605),
        (0, 20): (0, 0.1611),
        (1, 29): (0.0061, 0.1718),
    }
    for (hits, total), (low, high) in expected.items():
        assert wilson(hits, total) == (pytest.approx(low, abs=5e-5), pytest.approx(high, abs=5e-5))
    assert wilson(0, 0) == (0.0, 1.0)
    assert score(0, 0) == "-"


def test_sections_are_replaced_apart() -> None:
    text = (
        "a\n<!-- rtl begin -->\nold\n<!-- rtl end -->\nb\n<!-- python begin -->\nkept\n<!-- python end -->\n"
    )
    assert with_section(text, "rtl", "new\\1") == text.replace("old", "new\\1")
    with pytest.raises(QuadshadeError, match="no section vhdl"):
        with_section(text, "vhdl", "")


def test_a_cut_line_of_results_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "results.jsonl"
    first = Result("a", "edge_dda", "", 1, "logic", "", "", "text", "survived")
    append(first, path)
    append(Result("a", "edge_dda", "", 1, "logic", "", "", "text", "killed"), path)
    append(Result("b", "edge_dda", "", 1, "logic", "", "", "text", "killed"), path)
    path.write_text(path.read_text()[:-20])
    assert {name: result.verdict for name, result in load(path).items()} == {"a": "killed"}


def test_a_run_goes_on_from_what_was_published(tmp_path: Path) -> None:
    """A survivor is kept whole, and of what was killed all that tells whether it is run again."""
    survivor = Result("a", "edge_dda", "x.vhd", 7, "logic", "line", "what", "text", "survived", stage="proof")
    killed = Result(
        "b", "edge_dda", "", 0, "netlist inv", "default", "cell", "netlist", "killed", "edge_dda[default]",
        "failed: colour", benches="0123", date="2026-01-02",
    )  # fmt: skip
    same, other = replace(killed, name="c"), replace(killed, name="d", verdict="stillborn")
    numbers, lines = tmp_path / "numbers.json", tmp_path / "results.jsonl"
    numbers.write_text(json.dumps(publishable([survivor, killed, same, other])))
    found = known(numbers, lines)
    assert found["a"] == survivor
    assert [replace(found[name], what="cell", kind=killed.kind, detail=killed.detail) for name in "bcd"] == [
        killed, same, other,
    ]  # fmt: skip
    assert len(json.loads(numbers.read_text())["named"]) == 2
    append(replace(survivor, verdict="killed"), lines)
    assert known(numbers, lines)["a"].verdict == "killed"


def test_kills_without_a_name_count_until_a_run_names_them() -> None:
    earlier = {"edge_dda": report.Earlier(2, 3, "2026-01-02")}
    survivor = Result("a", "edge_dda", "", 0, "", "", "", "netlist", "survived", date="2026-02-03")
    found = report.tallies([survivor], {}, earlier)
    assert found["edge_dda"] == report.Tally(2, 3, 4, 0, 0, 0, 1, "2026-01-02") == found["all"]
    assert report.unnamed([survivor], earlier).startswith("Of 4 of those killed")
    named = [replace(survivor, name=f"n{index}", verdict="killed") for index in range(2)]
    named += [replace(one, name=f"t{one.name}", source="text") for one in named]
    found = report.tallies([survivor, *named], {}, earlier)
    assert found["edge_dda"] == report.Tally(2, 3, 4, 0, 0, 0, 1, "2026-02-03")
    assert report.unnamed([survivor, *named], earlier) == ""


def test_what_is_run_again_after_a_change_of_the_bench() -> None:
    """Survivors always, kills where that is asked for; a proof was tried in vain only where one was tried."""
    kinds = [Settling("load_adder", (1, 1), 1, STEPS, again, print) for again in (False, True)]
    for verdict, stage, wanted in [
        ("survived", "own", [True, True]),
        ("survived", "above", [True, True]),
        ("killed", "own", [False, True]),
        ("killed", "above", [False, False]),
        ("stillborn", "own", [False, False]),
        ("equivalent", "proof", [False, False]),
    ]:
        old = Result("a", "load_adder", "", 1, "logic", "", "", "text", verdict, stage=stage, benches="other")
        assert [kind.stale(old) for kind in kinds] == wanted, (verdict, stage)
        now = replace(old, benches=kinds[0].own_benches)
        assert [kind.stale(now) for kind in kinds] == [False, False]
    found = Result("a", "load_adder", "", 1, "logic", "", "", "text", "survived")
    assert tried(found, None) == tried(found, found) == found
    assert tried(found, replace(found, stage="above")).stage == "proof"
    assert tried(found, replace(found, verdict="killed", stage="above")) == found


def test_the_report_tells_kills_of_benches_that_have_changed() -> None:
    killed = Result("a", "load_adder", "", 1, "logic", "", "", "text", "killed", benches="other")
    now = replace(killed, benches=digest_of(["load_adder"]))
    assert report.changed([killed, killed, now, replace(killed, verdict="survived")]).startswith("2 of those")
    assert report.changed([now]) == report.changed([]) == ""


def test_reviewed_mutants_exist_and_have_reasons() -> None:
    there = {mutant.name: mutant for unit in rtl_paths() for mutant in sampled(unit, 1)}
    for name, review in report.reviews().items():
        assert len(review.reason.split()) >= 5, review
        if review.file:
            assert name in there, f"{review.file}: {review.original}: its line is another by now"
            assert (there[name].original, there[name].what) == (review.original, review.what)


def test_the_report_is_of_its_numbers() -> None:
    whole = report.Tally(**NUMBERS["all"])
    text = REPORT.read_text()
    assert f"**{score(whole.own + whole.above, whole.alive)}**" in text
    for unit, numbers in NUMBERS["units"].items():
        row = " | ".join(map(str, report.Tally(**numbers).row(unit)))
        assert row in re.sub(r"\s+\|", " |", text), unit


@pytest.mark.parametrize("options", [["--unit", "no_unit"], ["--count", "0"], ["--jobs", "0"]])
def test_bad_input_is_one_line(options: list[str]) -> None:
    done = CliRunner().invoke(main, options)
    assert done.exit_code == 2
    assert done.output.startswith("mutation: error: ") and len(done.output.splitlines()) == 1
