# SPDX-License-Identifier: Apache-2.0
"""Set-up words as files: what GHDL, a C compiler and $readmemh read of them is the stream."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import quadshade
from quadshade.cli.main import main
from quadshade.contract.formats import DIFFERENCES_OF_ORDER, Formats
from quadshade.engine import draw_words
from quadshade.setup import open_triangles, pack, setup_triangles
from quadshade.setup.packet import field_values

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "triangles.json"
SPHERE = ("sphere:24", "--size", "40x32")


def run(*words: str | Path) -> tuple[int, str]:
    result = CliRunner().invoke(main, ["words", *map(str, words)])
    return result.exit_code, result.output


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def stream(path: Path) -> np.ndarray:
    return np.frombuffer(path.read_bytes(), dtype="<u4")


@pytest.mark.parametrize("width", [32, 64, 128])
@pytest.mark.parametrize("shading", ["quadratic", "quadratic-specular"])
def test_what_tools_read_is_the_stream(tmp_path: Path, width: int, shading: str) -> None:
    given = (*SPHERE, "--shading", shading, "--generic", f"stream_width={width}")
    for ending in ("bin", "hex", "mem", "c", "vhd"):
        code, said = run(*given, "-o", tmp_path / f"a.{ending}")
        assert code == 0, said
    words = stream(tmp_path / "a.bin")
    beats = [sum(int(w) << 32 * i for i, w in enumerate(b)) for b in words.reshape(-1, width // 32)]
    assert [int(line, 16) for line in (tmp_path / "a.hex").read_text().split()] == beats
    assert read_by_icarus(tmp_path / "a.mem", width, len(beats)) == beats
    assert read_by_c(tmp_path, "A_WORDS", "a[i]") == words.tolist()
    shaded = shading != "quadratic"
    state = (
        {int(row["address"]): int(row["data"]) for row in table(tmp_path / "a.state.csv")} if shaded else {}
    )
    if shaded:
        assert read_by_c(tmp_path, "A_STATE_WRITES", "a_state[i][1]") == list(state.values())
    assert read_by_ghdl(tmp_path, "setup_beats") == beats
    if shaded:
        writes = [address << 32 | data for address, data in state.items()]
        assert read_by_ghdl(tmp_path, "state_writes") == writes


def read_by_icarus(path: Path, width: int, count: int) -> list[int]:
    """What Icarus' $readmemh takes from a file."""
    bench = path.with_suffix(".v")
    bench.write_text(
        f'module top; reg [{width - 1}:0] m [0:{count - 1}]; integer i; initial begin $readmemh("{path}", m);'
        f' for (i = 0; i < {count}; i = i + 1) $display("%h", m[i]); end endmodule'
    )
    program = path.with_suffix(".vvp")
    subprocess.run(["iverilog", "-o", program, bench], check=True)
    said = subprocess.run(["vvp", "-n", program], check=True, capture_output=True, text=True).stdout
    return [int(line, 16) for line in said.split()]


def read_by_c(folder: Path, count: str, element: str) -> list[int]:
    """What a C program finds in a.c."""
    (folder / "main.c").write_text(
        '#include <stdio.h>\n#include "a.c"\n'
        f'int main(void) {{ for (int i = 0; i < {count}; i++) printf("%u\\n", {element}); return 0; }}\n'
    )
    subprocess.run(["cc", "-Wall", "-Werror", "-o", folder / "main", folder / "main.c"], check=True)
    said = subprocess.run([folder / "main"], check=True, capture_output=True, text=True).stdout
    return [int(line) for line in said.split()]


def read_by_ghdl(folder: Path, constant: str) -> list[int]:
    """What a VHDL design finds in the package a_pkg."""
    (folder / "top.vhd").write_text(
        "library ieee; use ieee.std_logic_1164.all; use std.textio.all; entity top is end entity;\n"
        "architecture test of top is begin process begin\n"
        f"for i in work.a_pkg.{constant}'range loop report to_hstring(work.a_pkg.{constant}(i)); end loop;\n"
        "wait;\n"
        "end process; end architecture;\n"
    )
    for arguments in (["-a", "a.vhd", "top.vhd"], ["-e", "top"]):
        subprocess.run(["ghdl", arguments[0], "--std=08", *arguments[1:]], check=True, cwd=folder)
    said = subprocess.run(
        ["ghdl", "-r", "--std=08", "top"], check=True, cwd=folder, capture_output=True, text=True
    )
    return [int(line.rsplit(": ", 1)[1], 16) for line in (said.stdout + said.stderr).splitlines() if line]


def test_the_tables_say_what_the_words_are(tmp_path: Path) -> None:
    """Every field, read from the file at the place that the layout gives, is the set-up's."""
    assert run(EXAMPLE, "-o", tmp_path / "a.bin")[0] == 0
    triangles, formats = open_triangles(EXAMPLE, {})
    primitives = setup_triangles(triangles, formats)
    words = stream(tmp_path / "a.bin")
    assert np.array_equal(words, pack(primitives, formats))
    packets, layout = table(tmp_path / "a.packets.csv"), table(tmp_path / "a.layout.csv")
    assert [int(row["triangle"]) for row in packets] == primitives.triangle.tolist()
    read = 0
    for index, row in enumerate(packets):
        first, count = int(row["first_word"]), int(row["words"])
        bits = sum(int(word) << 32 * place for place, word in enumerate(words[first : first + count]))
        begin = 0
        for section in ("edge", "second"):
            if section == "second" and not primitives.header["has_second"][index]:
                continue
            for entry in (entry for entry in layout if entry["section"] == section):
                value = bits >> begin + int(entry["first_bit"]) & (1 << int(entry["bits"])) - 1
                expected = int(field_values(primitives, entry["field"], formats)[index])
                assert value == expected & (1 << int(entry["bits"])) - 1, entry
                read += 1
            begin += formats.section_beats(section) * formats.stream_width
        for group, channels in enumerate(formats.channel_groups):
            order = max(primitives.orders[index, channel] for channel in channels)
            for entry in (entry for entry in layout if entry["section"] == f"group {group}"):
                _, channel, name = entry["field"].split()
                difference = ("value", "d_row", "d_col", "dd_row", "dd_mixed", "dd_col").index(name)
                if difference < DIFFERENCES_OF_ORDER[order]:
                    value = bits >> begin + int(entry["first_bit"]) & (1 << int(entry["bits"])) - 1
                    expected = int(primitives.words[index, int(channel), difference])
                    assert value == expected & (1 << formats.word_width) - 1, entry
                    read += 1
            begin += DIFFERENCES_OF_ORDER[order] * formats.difference_beats * formats.stream_width
        assert begin == 32 * count
    assert read > 50


def test_the_pixels_are_those_of_the_words(tmp_path: Path) -> None:
    code, said = run(*SPHERE, "-o", tmp_path / "a.bin")
    assert code == 0
    drawn = draw_words(stream(tmp_path / "a.bin"), Formats())
    rows = table(tmp_path / "a.pixels.csv")
    assert len(rows) == len(drawn.x) > 300
    columns = ["packet", "x", "y", "r", "g", "b", "depth"]
    got = np.array([[int(row[name]) for name in columns] for row in rows])
    assert np.array_equal(got, np.column_stack([drawn.packet, drawn.x, drawn.y, drawn.value]))
    ends = [row["packet"] for row in rows if row["last"] == "1"]
    assert ends == list(dict.fromkeys(row["packet"] for row in rows))
    assert f"{len(rows)} pixels" in said


def test_a_picture_gives_its_words(tmp_path: Path) -> None:
    picture = quadshade.render("sphere:24", size=(40, 32), engine="model", max_error=4)
    words = picture.setup_words()
    words.save(tmp_path / "a.bin")
    assert np.array_equal(stream(tmp_path / "a.bin"), words.words)
    assert len(words.words) == picture.stats.words
    assert len(words.pixels.x) == picture.stats.pixels
    assert run(*SPHERE, "--max-error", "4", "-o", tmp_path / "b.bin")[0] == 0
    assert np.array_equal(stream(tmp_path / "b.bin"), words.words)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((*SPHERE, "-o", "a.txt"), "ends in .hex"),
        ((EXAMPLE, "-o", "a.hex", "--size", "8x8"), "--size is for a mesh"),
        ((EXAMPLE, "-o", "a.hex", "--light", "dir=0,0,1"), "--light is for a mesh"),
        ((*SPHERE, "-o", "a.hex", "--camera", "eye=0,0,9,target=0,0,99"), "there are no words"),
        ((*SPHERE, "-o", "nowhere/a.hex"), "nowhere"),
        ((*SPHERE, "-o", "/proc/a.hex"), "cannot write"),
        (("none.json", "-o", "a.hex"), "none.json"),
        ((*SPHERE, "-o", "a.hex", "--shading", "phong"), "phong"),
    ],
)
def test_wrong_calls_write_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, output = run(*words)
    assert code == 2
    assert said in output
    assert not list(tmp_path.iterdir())


def test_a_file_of_any_name_compiles(tmp_path: Path) -> None:
    for name in ("int", "main", "7", "a b"):
        path = tmp_path / f"{name}.c"
        assert run(*SPHERE, "-o", path)[0] == 0
        subprocess.run(["gcc", "-c", path, "-o", tmp_path / "a.o"], check=True)


def test_no_table_of_words_before_stays(tmp_path: Path) -> None:
    given = (*SPHERE, "-o", tmp_path / "a.hex")
    assert run(*given, "--shading", "quadratic-specular")[0] == 0
    assert (tmp_path / "a.state.csv").exists()
    assert run(*given)[0] == 0
    assert not (tmp_path / "a.state.csv").exists()
    (tmp_path / "b.state.csv").mkdir()
    code, said = run(*SPHERE, "-o", tmp_path / "b.hex", "--shading", "quadratic-specular")
    assert code == 2 and "b.state.csv" in said
    assert {path.name for path in tmp_path.glob("b.*")} == {"b.state.csv"}


def test_the_help_speaks_of_no_board() -> None:
    code, said = run("--help")
    assert code == 0 and "stream_width=128" in said
    assert "--port" not in said and "of the board" not in " ".join(said.split())
