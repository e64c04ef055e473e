# SPDX-License-Identifier: Apache-2.0
"""The table of proofs against the RTL as it is, a proof with its mutants, and faults that are not proofs."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

from quadshade.errors import QuadshadeError
from scripts import formal

PROOFS = {proof.name: proof for proof in formal.load_proofs()}


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the test's own for what the tools write; below the checkout, which the tools can read."""
    folder = formal.ROOT / "build" / "test_formal" / tmp_path.name
    monkeypatch.setattr(formal, "BUILD", folder)
    return folder


@pytest.mark.parametrize("name", PROOFS)
def test_table_fits_files(name: str) -> None:
    proof = PROOFS[name]
    suffix = {"sby": ".sv", "smt2": ".smt2"}.get(proof.kind)
    assert suffix is None or (proof.folder / f"{name}{suffix}").is_file()
    for mutant in proof.mutants:
        questions = proof.kind == "smt2"
        path = proof.folder / mutant["file"] if questions else formal.rtl_file(mutant["file"])
        text = path.read_text()
        assert formal.mutate(text, mutant) != text


def test_files_are_in_the_table() -> None:
    files = {path.stem for path in formal.FORMAL.glob("*/*") if path.suffix in (".sv", ".smt2")}
    assert files == {name for name, proof in PROOFS.items() if proof.kind != "cones"}


def test_every_stateful_unit_is_proved() -> None:
    packages = {
        "quadshade_pkg",
        "link_pkg",
        "packed_pkg",
        "vertex_pkg",
        "axis_pkg",
        "memory_pkg",
        "screen_pkg",
    }
    stateless = {"output_clamp", "load_adder"}
    units = {path.stem for path in (formal.ROOT / "rtl").rglob("*.vhd")} - packages - stateless
    proved = {unit for proof in PROOFS.values() for unit in proof.units}
    # Inside the core, and there only: the lanes are compared with each other. A fill is proved
    # with what it fills; the memory is what the proofs take for granted.
    inside = {"channel_lane", "lane_handshake", "memory_clear", "block_ram", "single_port_ram"}
    # Compared with their models in every cycle, and with an independent peer.
    tested = {"uart_rx", "uart_tx", "cobs_encoder"}
    # Compared with their models: behind the frame receiver, which lets only what is right pass.
    tested |= {"answer_sender", "command_executor", "command_decoder"}
    # Compared with its model behind the controller's, whose chip refuses what is wrong.
    tested |= {"sdram_depth_test", "sdram_read_out", "sdram_screen"}
    # Compared with its model; in the proof of the unpacker, to which most numbers do not matter.
    tested |= {"vertex_alu"}
    # Compared with their models as a whole.
    tested |= {"render_core", "screen", "plane_requests", "board", "scan_out", "quadshade_axis"}
    assert units - proved == inside | tested


def test_page_names_every_proof() -> None:
    page = (formal.ROOT / "docs" / "explanation" / "formal.md").read_text()
    assert sorted(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)) == sorted(PROOFS)


def test_report_is_of_this_table() -> None:
    report = formal.REPORT.read_text()
    rows = [line.split(" | ")[0].removeprefix("| ") for line in report.splitlines() if line.startswith("| ")]
    expected = [proof.name for proof in PROOFS.values() for _ in proof.configs]
    expected += [proof.name for proof in PROOFS.values() for _ in proof.mutants]
    assert sorted(row for row in rows if row not in ("proof", "---")) == sorted(expected)


def test_proof_and_mutants(build: Path) -> None:
    outcomes = formal.run_all([PROOFS["skid_buffer"], PROOFS["edge_dda_exact"]], 1)
    assert [outcome for outcome in outcomes if not outcome.good] == []
    assert {outcome.verdict for outcome in outcomes} == {"holds", "fails"}


def test_mutant_that_changes_nothing_is_accepted(build: Path) -> None:
    same = {
        "what": "nothing",
        "file": "skid_buffer.vhd",
        "from": "ready <= '0';",
        "to": "ready <= not front_valid;",
    }
    proof = dataclasses.replace(PROOFS["skid_buffer"], mutants=[same])
    outcome = formal.run_job(formal.Job(proof, 0, 0), formal.tool_environment())
    assert (outcome.verdict, outcome.good) == ("holds", False)


def test_missing_signal_is_an_error(build: Path, tmp_path: Path) -> None:
    text = (formal.FORMAL / "common" / "skid_buffer.sv").read_text()
    (tmp_path / "skid_buffer.sv").write_text(text.replace("dut.spare", "dut.gone"))
    proof = dataclasses.replace(PROOFS["skid_buffer"], folder=tmp_path)
    outcome = formal.run_job(formal.Job(proof, 0), formal.tool_environment())
    assert outcome.verdict == "error" and "dut.gone" in outcome.detail


def test_mutant_without_its_line_is_an_error() -> None:
    mutant = {"what": "none", "file": "skid_buffer.vhd", "from": "no such line", "to": ""}
    with pytest.raises(QuadshadeError, match="0 times"):
        formal.mutate(formal.rtl_file("skid_buffer.vhd").read_text(), mutant)
