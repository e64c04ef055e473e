# SPDX-License-Identifier: Apache-2.0
"""Mutants of the host library: what is changed, what is drawn, that tests are run on it, and the score."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from scripts.mutation.python import report
from scripts.mutation.python.__main__ import known_results
from scripts.mutation.python.mutants import Mutant, changed_lines, mutants_of, mutated, sample
from scripts.mutation.report import REPORT

ROOT = Path(__file__).resolve().parents[1]
SOURCE = """\
from __future__ import annotations

LIMIT: int | None = 7


@numba.njit(cache=True)
def total(values: list[int], start: int | None = 0) -> int | None:
    start += len(values) - 1
    values.append(start)
    for value in values:
        if value > LIMIT:
            break
    return start


class Counter:
    @property
    def count(self):
        return not self.empty
"""


@pytest.fixture
def mutants(tmp_path: Path) -> list[Mutant]:
    (tmp_path / "a.py").write_text(SOURCE)
    return mutants_of(tmp_path / "a.py", tmp_path)


def test_every_mutant_changes_one_line_of_code_that_runs(mutants: list[Mutant]) -> None:
    made = {(mutant.where, *changed_lines(SOURCE, mutated(mutant, SOURCE))) for mutant in mutants}
    squeezed = {(where, old, " ".join(new.split())) for where, old, new in made}
    assert {
        ("", "LIMIT: int | None = 7", "LIMIT: int | None = 8"),
        ("total", "start += len(values) - 1", "pass"),
        ("total", "start += len(values) - 1", "start += len(values) + 1"),
        ("total", "values.append(start)", "pass"),
        ("total", "for value in values:", "for value in []:"),
        ("total", "if value > LIMIT:", "if value >= LIMIT:"),
        ("total", "if value > LIMIT:", "if not value > LIMIT:"),
        ("total", "break", "continue"),
        ("Counter.count", "@property", ""),
        ("Counter.count", "return not self.empty", "return self.empty"),
    } <= squeezed
    for mutant in mutants:
        ast.parse(mutated(mutant, SOURCE))
    # Neither annotations nor numba's decorators.
    assert not [new for _, _, new in made if "& None" in new or "^ None" in new or "cache=False" in new]
    assert len({mutant.key for mutant in mutants}) == len(mutants)


def test_a_sample_is_repeated_and_keeps_each_files_share(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(SOURCE)
    (tmp_path / "b.py").write_text(SOURCE + "\n" + SOURCE.partition("\n\n\n")[2].replace("total", "other"))
    files = {name: mutants_of(tmp_path / name, tmp_path) for name in ("a.py", "b.py")}
    drawn = sample(files, 12, 1)
    assert drawn == sample(files, 12, 1) != sample(files, 12, 2)
    assert len(drawn) == 12 == len({(mutant.path, mutant.line, mutant.column) for mutant in drawn})
    counts = [sum(mutant.path == name for mutant in drawn) for name in files]
    assert counts[0] < counts[1] and sum(counts) == 12


def test_a_sample_stays_when_other_lines_change(tmp_path: Path) -> None:
    """A larger share of a file adds to what was drawn of it; what is put above moves it and no more."""
    (tmp_path / "a.py").write_text(SOURCE)
    before = sample({"a.py": mutants_of(tmp_path / "a.py", tmp_path)}, 7, 1)
    assert set(before) < set(sample({"a.py": mutants_of(tmp_path / "a.py", tmp_path)}, 9, 1))
    above = "from __future__ import annotations\n\nimport quadshade\n\nLOWEST = -1\n"
    (tmp_path / "a.py").write_text(SOURCE.replace("from __future__ import annotations\n", above))
    after = mutants_of(tmp_path / "a.py", tmp_path)
    drawn = sample({"a.py": after}, len({mutant.place for mutant in after}), 1)
    kept = [mutant for mutant in drawn if "LOWEST" not in mutant.place]
    found = [(mutant.key, mutant.line - 4) for mutant in kept[: len(before)]]
    assert found == [(mutant.key, mutant.line) for mutant in before]
    functions = {mutant.where: mutant.around for mutant in before if mutant.where}
    assert functions == {mutant.where: mutant.around for mutant in after if mutant.where in functions}


RUN = """
import json, sys
from pathlib import Path
from scripts.mutation.python.mutants import mutants_of
from scripts.mutation.python.runner import run_session

root, folder = Path(sys.argv[1]), Path(sys.argv[2])
package = root / "model" / "quadshade"
mutants = {f"{m.operator}:{m.occurrence}": m for m in mutants_of(package / "amount.py", package)}
found = {}

def work(session):
    for key, mutant in mutants.items():
        outcome = session.run(mutant)
        found[key] = [outcome.state, outcome.test]

problem = run_session(root, folder, ("quadshade.",), ["tests/test_amount.py"], 5.0, work, spare=1.0)
Path(sys.argv[3]).write_text(json.dumps({"problem": problem, "found": found}))
"""


def test_mutants_are_killed_in_functions_and_outside_and_others_survive(tmp_path: Path) -> None:
    root = tmp_path / "root"
    package = root / "model" / "quadshade"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "amount.py").write_text(
        "START = 5\nSPARE = 1\n\n\ndef amount(n):\n    while n > 3:\n        n = n - 1\n"
        "    return n + START\n"
    )
    (root / "tests").mkdir()
    (root / "pytest.ini").write_text("[pytest]\naddopts = --import-mode=importlib\n")
    (root / "tests" / "test_amount.py").write_text(
        "from quadshade.amount import START, amount\n\n\ndef test_it():\n    assert amount(9) == 8\n\n\n"
        "def test_start():\n    assert START == 5\n"
    )
    said = tmp_path / "said.json"
    command = [sys.executable, "-c", RUN, root, tmp_path / "copy", said]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    result = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    content = json.loads(said.read_text())
    assert content["problem"] == ""
    states = {name: state for name, (state, _) in content["found"].items()}
    numbers = [states[f"NumberReplacer:{index}"] for index in range(8)]
    # START twice, SPARE twice, 3 twice, 1 twice: a step of 2 ends at the same number, one of 0 does not end.
    assert numbers == ["killed", "killed", "survived", "survived", "killed", "killed", "survived", "timeout"]
    assert states["ReplaceBinaryOperator_Sub_Add:0"] == "timeout"
    assert states["ReplaceBinaryOperator_Add_Sub:0"] == "killed"
    assert content["found"]["ReplaceBinaryOperator_Add_Sub:0"][1] == "tests/test_amount.py::test_it"
    assert (package / "amount.py").read_text() == (tmp_path / "copy" / "quadshade" / "amount.py").read_text()


def test_killed_mutants_stay_killed() -> None:
    """A sample of those that the report says are killed, by the quick ones of the tests that killed them."""
    command = [sys.executable, "-m", "scripts.mutation.python", "--kept", "--count", "14", "--seed", "1"]
    environment = {"PYTHONPATH": f"{ROOT / 'model'}:{ROOT}", "PATH": "/usr/bin:/bin"}
    result = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    killed, run = re.search(r"(\d+) of (\d+) are killed again", result.stdout).groups()
    assert killed == run and int(run) >= 10


def row(state: str, old: str = "a", group: str = "link") -> dict[str, str]:
    return {
        "name": "0123456789ab",
        "path": f"{group}/x.py",
        "operator": "AddNot",
        "group": group,
        "where": "f",
        "old": old,
        "new": "b",
        "state": state,
        "test": "",
    }


def test_the_score_counts_what_can_be_noticed() -> None:
    argued = [{"path": "link/x.py", "where": "f", "old": "same", "new": "b", "reason": "it is the same"}]
    rows = [row("killed")] * 7 + [row("timeout"), row("survived"), row("survived", "same")]
    content = report.numbers(rows, argued, 10, {1: {rows[0]["name"]}, 7: {"not run yet"}})
    counts = content["overall"]
    assert [counts[name] for name in ("sampled", "killed", "timeouts", "equivalent", "survived")] == [
        10,
        8,
        1,
        1,
        1,
    ]
    assert "| all | 10 | 8 | 1 | 1 | 88.9 % (" in report.section(content)
    assert content["conditions"]["seeds"]["7"]["sampled"] == 0
    assert 'COUNT=10 SEED="1 7"' in report.section(content) and "of seed 7 0" in report.section(content)
    assert "| `link/x.py` | `f` | `a` | `b` |" in report.section(content)
    # A reason does not hide that a test notices the mutant after all.
    noticed = report.numbers([row("killed", "same")], argued, 1, {1: set()})
    assert noticed["overall"]["equivalent"] == 0


def test_a_run_goes_on_from_what_was_published(tmp_path: Path) -> None:
    """What a reader found equivalent is a survivor to the next run; what was found since counts."""
    entry = row("equivalent") | {"tests": "0123"}
    numbers, lines = tmp_path / "numbers.json", tmp_path / "python.jsonl"
    numbers.write_text(json.dumps({"mutants": [entry, entry | {"name": "other", "state": "killed"}]}))
    states = {name: result.state for name, result in known_results(lines, numbers).items()}
    assert states == {entry["name"]: "survived", "other": "killed"}
    lines.write_text(json.dumps(entry | {"state": "killed", "test": "t"}) + "\n")
    found = known_results(lines, numbers)[entry["name"]]
    assert (found.state, found.test, found.tests) == ("killed", "t", "0123")


def test_what_is_argued_is_still_there() -> None:
    for entry in report.argued():
        text = (ROOT / "model" / "quadshade" / entry["path"]).read_text()
        assert all(part in text for part in entry["old"].split(" / ")), entry
        assert len(entry["reason"].split()) > 4, entry


def test_the_report_says_what_its_numbers_say() -> None:
    content = json.loads(report.NUMBERS.read_text())
    assert report.section(content) in REPORT.read_text()
    assert content["overall"]["sampled"] == len(content["mutants"]) == content["conditions"]["run"]
