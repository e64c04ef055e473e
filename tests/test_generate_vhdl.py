# SPDX-License-Identifier: Apache-2.0
"""``quadshade_pkg.vhd`` computes in GHDL what ``Formats`` computes in Python, for any generics."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from quadshade.contract.formats import DERIVED, GENERIC_CHOICES, GENERIC_RANGES, SECTIONS, Formats
from quadshade.engine.tool_runner import tool_command
from quadshade.errors import QuadshadeError

ROOT = Path(__file__).resolve().parents[1]
GHDL = tool_command("GHDL")
GENERICS = tuple(Formats().generics())


def probe() -> str:
    """A VHDL entity that reports every derived width and every field's bits as ``name=value``."""
    values = {name: f"{name}(formats)" for name, _, _ in DERIVED if name != "depth_frac_bits"}
    for section, section_fields in SECTIONS:
        for field, _, _ in section_fields:
            for end in ("low", "high"):
                values[f"{section}.{field}_{end}"] = f"{section}.{field}_{end}"
        values |= {f"{section}.{part}": f"{section}.{part}" for part in ("bits", "beats")}
    generics = ";\n".join(f"    {name} : natural := default_formats.{name}" for name in GENERICS)
    associations = ", ".join(f"{name} => {name}" for name in GENERICS)
    reports = "\n".join(f'    report "{n}=" & integer\'image({v});' for n, v in values.items())
    layouts = "\n".join(f"  constant {s} : {s}_layout_t := {s}_layout(formats);" for s, _ in SECTIONS)
    return f"""
use work.quadshade_pkg.all;
entity probe is
  generic (
{generics}
  );
end entity;
architecture sim of probe is
  constant formats : formats_t := ({associations});
  constant formats_ok : boolean := check_formats(formats);
{layouts}
begin
  process
  begin
{reports}
    report "formats_ok=" & integer'image(boolean'pos(formats_ok));
    wait;
  end process;
end architecture;
"""


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("probe")
    source = folder / "probe.vhd"
    source.write_text(probe())
    for command in (
        ["-a", "--std=08", ROOT / "rtl" / "generated" / "quadshade_pkg.vhd", source],
        ["-e", "--std=08", "probe"],
    ):
        subprocess.run([*GHDL, *command], cwd=folder, check=True)
    return folder


def elaborate(build: Path, generics: dict[str, int]) -> tuple[int, dict[str, int], str]:
    """Exit code, reported values and raw text of the probe with these generics."""
    settings = [f"-g{name}={value}" for name, value in generics.items()]
    command = [*GHDL, "-r", "--std=08", "probe", *settings]
    result = subprocess.run(command, cwd=build, capture_output=True, text=True, check=False)
    text = result.stdout + result.stderr
    values = {name: int(value) for name, value in re.findall(r"\(report note\): ([\w.]+)=(-?\d+)", text)}
    return result.returncode, values, text


def expected(formats: Formats) -> dict[str, int]:
    """What the probe must report."""
    values = {name: getattr(formats, name) for name, _, _ in DERIVED if name != "depth_frac_bits"}
    for section, _ in SECTIONS:
        for field, (offset, width) in formats.section(section).items():
            values[f"{section}.{field}_low"] = offset
            values[f"{section}.{field}_high"] = offset + width - 1
        values[f"{section}.bits"] = formats.section_bits(section)
        values[f"{section}.beats"] = formats.section_beats(section)
    return values | {"formats_ok": 1}


def random_generics(rng: np.random.Generator) -> dict[str, int]:
    """Generics each within its own range; together they may still be wrong."""
    generics = {name: int(rng.choice(values)) for name, values in GENERIC_CHOICES}
    for name, low, high, condition in GENERIC_RANGES:
        if high.isdecimal() and condition == "1":
            generics[name] = int(rng.integers(int(low), int(high) + 1))
    generics["num_specular"], generics["shade_guard_bits"] = map(int, rng.integers(0, (5, 15)))
    generics["frac_bits"] = int(rng.integers(0, max(1, generics["word_width"] - generics["value_bits"])))
    return generics


def test_package_agrees_with_formats(build: Path, rng: np.random.Generator) -> None:
    verdicts = set()
    for generics in ({}, *(random_generics(rng) for _ in range(40))):
        code, values, text = elaborate(build, generics)
        try:
            formats = Formats(**generics)
        except QuadshadeError:
            assert code != 0, f"accepted {generics}"
            verdicts.add("rejected")
        else:
            assert code == 0, f"rejected {generics}: {text}"
            assert values == expected(formats), f"generics {generics}"
            verdicts.add("accepted")
    assert verdicts == {"accepted", "rejected"}


def outside() -> list[tuple[str, int, str]]:
    """Every generic one above its range and one below, where that is a natural, and what must be 1 for it."""
    settings = [(name, values[-1] + 1, "1") for name, values in GENERIC_CHOICES]
    for name, low, high, condition in GENERIC_RANGES:
        formats = Formats(**needed(condition))
        settings.append((name, formats.evaluate(high) + 1, condition))
        if formats.evaluate(low) > 0:
            settings.append((name, formats.evaluate(low) - 1, condition))
    return sorted(set(settings))


def needed(condition: str) -> dict[str, int]:
    """Generics with which a range holds; wide words, so that no other is broken."""
    return {"with_shade": 1, "word_width": 60} if condition == "with_shade" else {}


@pytest.mark.parametrize(("name", "value", "condition"), outside(), ids=str)
def test_out_of_range_is_named(build: Path, name: str, value: int, condition: str) -> None:
    generics = needed(condition) | {name: value}
    with pytest.raises(QuadshadeError, match=rf"generic {name} is {value}; give"):
        Formats(**generics)
    code, _, text = elaborate(build, generics)
    assert code != 0
    assert f"generic {name} is {value}; give" in text
