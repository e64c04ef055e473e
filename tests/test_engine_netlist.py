# SPDX-License-Identifier: Apache-2.0
"""The netlist: constants repaired, nothing else let through, made once for each state of its sources."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from quadshade.contract.formats import Formats
from quadshade.engine.netlist import TOP, check_names, repair_constants, write_netlist
from quadshade.engine.tool_runner import run_tool
from quadshade.errors import QuadshadeError

ROOT = Path(__file__).resolve().parents[1]
needs_ghdl = pytest.mark.skipif(shutil.which("ghdl") is None, reason="needs GHDL: run `make setup`")

WIDE = """\
-- SPDX-License-Identifier: Apache-2.0
library ieee;
use ieee.std_logic_1164.all;
entity wide is
  generic (ones : natural := 1);
  port (data : out std_ulogic_vector(39 downto 0));
end entity;
architecture rtl of wide is
begin
  data <= x"123456789a" when ones = 0 else (others => '1');
end architecture;
"""

FOREIGN = """\
-- SPDX-License-Identifier: Apache-2.0
library ieee;
use ieee.std_logic_1164.all;
entity uart_rx is
  port (clk, rx : in std_logic; ready : out std_logic);
end entity;
architecture rtl of uart_rx is
begin
  ready <= rx when rising_edge(clk);
end architecture;

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;
library quadshade;
use quadshade.link_pkg.all;
entity foreign is
  port (clk, reset, rx : in std_logic; seen, valid : out std_logic);
end entity;
architecture rtl of foreign is
begin
  mine : entity work.uart_rx port map (clk => clk, rx => rx, ready => seen);
  theirs : entity quadshade.uart_rx
    port map (
      clk => clk, reset => reset, phase_step => to_unsigned(77, phase_bits), rx => rx, byte_valid => valid,
      byte_data => open, framing_error => open, break_seen => open
    );
end architecture;
"""


def test_repairs_constants() -> None:
    assert repair_constants('a <= "0101";\nb = "zX01";\n') == "a <= 4'b0101;\nb = 4'bzX01;\n"


@pytest.mark.parametrize("line", ['$display("hello");', 'a = "";', 'a = "012";'])
def test_refuses_other_quotes(line: str) -> None:
    with pytest.raises(QuadshadeError, match="line 2 of the netlist has a quote that is not a constant's"):
        repair_constants(f"module unit;\n{line}\n")


@needs_ghdl
def test_refuses_signals_that_are_words_of_systemverilog(tmp_path: Path) -> None:
    source = tmp_path / "word.vhd"
    text = WIDE.replace("wide", "word").replace(
        "begin\n  data <=",
        "  signal final : std_ulogic_vector(39 downto 0);\nbegin\n  data <= final;\n  final <=",
    )
    source.write_text(text)
    with pytest.raises(QuadshadeError, match="a signal is called 'final', a word of SystemVerilog"):
        write_netlist({}, "word", [source])
    check_names("module unit(final_one);\n  input  final_one;\n  wire [3:0] finals;\n")


@needs_ghdl
def test_wide_constants_have_their_value(tmp_path: Path) -> None:
    source = tmp_path / "wide.vhd"
    source.write_text(WIDE)
    text = write_netlist({}, "wide", [source]).read_text()
    assert {int(bits, 2) for bits in re.findall(r"40'b([01]{40})", text)} == {0x123456789A, 2**40 - 1}


@needs_ghdl
def test_is_made_once_and_again_when_anything_changes(tmp_path: Path) -> None:
    source = tmp_path / "wide.vhd"
    source.write_text(WIDE)
    first = write_netlist({}, "wide", [source])
    made = first.stat().st_mtime_ns
    assert write_netlist({}, "wide", [source]) == first and first.stat().st_mtime_ns == made
    source.write_text(WIDE + "-- changed\n")
    assert (
        len({first, write_netlist({}, "wide", [source]), write_netlist({"ones": 0}, "wide", [source])}) == 3
    )


@needs_ghdl
def test_names_of_others_do_not_collide(tmp_path: Path) -> None:
    """A design has a `uart_rx` of its own beside that of the RTL, which is in a library of its own."""
    source = tmp_path / "foreign.vhd"
    source.write_text(FOREIGN)
    options = ["--std=08", "-Werror"]
    names = ("generated/quadshade_pkg.vhd", "generated/link_pkg.vhd", "link/uart_rx.vhd")
    needed = [ROOT / "rtl" / name for name in names]
    run_tool(["ghdl", "-a", *options, "--work=quadshade", *map(str, needed)], tmp_path)
    run_tool(["ghdl", "-a", *options, str(source)], tmp_path)
    run_tool(["ghdl", "-e", *options, "foreign"], tmp_path)
    # Verilog has no libraries, and GHDL gives both one name.
    with pytest.raises(QuadshadeError, match="two modules of the netlist are called 'uart_rx'"):
        write_netlist({}, "foreign", [source], library="quadshade")
    source.write_text(
        FOREIGN.replace("uart_rx is", "my_uart_rx is")
        .replace("of uart_rx", "of my_uart_rx")
        .replace("work.uart_rx", "work.my_uart_rx")
    )
    text = write_netlist({}, "foreign", [source], library="quadshade").read_text()
    modules = re.findall(r"^module (\w+)", text, re.MULTILINE)
    assert sorted(modules) == ["foreign", "my_uart_rx", "uart_rx"]


@needs_ghdl
def test_core_has_no_string_whatever_its_generics() -> None:
    for formats in (Formats(), Formats(word_width=60, frac_bits=40, stream_width=128)):
        text = write_netlist(formats.core_generics()).read_text()
        assert f"module {TOP}\n" in text and '"' not in text


@needs_ghdl
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--generic", "word_width=61"], "generic word_width is 61; give a value from 12 to 60"),
        (["--generic", "nonsuch=1"], 'no generic "nonsuch"'),
        (["--top", "nonsuch"], "cannot find entity or configuration nonsuch"),
        (["--file", "nonsuch.vhd"], "nonsuch.vhd"),
    ],
)
def test_script_says_errors_in_one_line(arguments: list[str], message: str) -> None:
    command = [sys.executable, "-m", "scripts.netlist", *arguments]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 2 and result.stdout == ""
    assert message in result.stderr
    assert result.stderr.startswith("netlist: error: ") and len(result.stderr.splitlines()) == 1


@needs_ghdl
def test_script_writes_a_file(tmp_path: Path) -> None:
    output = tmp_path / "made" / "core.v"
    command = [sys.executable, "-m", "scripts.netlist", "--generic", "span_depth=1", "-o", output]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    assert result.stdout == f"{output}\n"
    assert output.read_text() == write_netlist({"span_depth": 1}).read_text()
    assert [path.name for path in output.parent.iterdir()] == ["core.v"]


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("exit 3", "exit code 3"),
        ("kill -9 $$", "ended by signal 9"),
        ("echo; echo one; echo a failure; exit 1", "a failure"),
        ("echo one; echo two; exit 1", "one"),
        ("printf '\\377 error'; exit 1", "\ufffd error"),
    ],
)
def test_a_tool_that_fails_says_why(script: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(QuadshadeError, match=f"^sh failed: {reason}$"):
        run_tool(["sh", "-c", script], tmp_path)


def test_what_a_tool_has_started_ends_with_the_program(tmp_path: Path) -> None:
    """GHDL runs the program that it built as a child of its own."""
    program = (
        "import signal\n"
        "from pathlib import Path\n"
        "from quadshade.engine.tool_runner import run_tool\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "run_tool(['sh', '-c', 'sleep 600 & echo $! > begun && mv begun child; wait'], Path.cwd())\n"
    )
    host = subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stderr=subprocess.DEVNULL)
    child = tmp_path / "child"
    end = time.monotonic() + 60
    while not child.exists() and time.monotonic() < end:
        time.sleep(0.02)
    host.send_signal(signal.SIGINT)
    assert host.wait(10) == -signal.SIGINT
    status = Path("/proc") / child.read_text().strip() / "stat"
    while status.exists() and ") Z " not in status.read_text() and time.monotonic() < end:
        time.sleep(0.02)
    assert not status.exists() or ") Z " in status.read_text()
