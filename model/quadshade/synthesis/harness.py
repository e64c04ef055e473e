# SPDX-License-Identifier: Apache-2.0
"""
A netlist between two ranks of registers and three pins, so that only its own logic limits the clock.

Inputs come from ``synth/harness/shift_in.v``, outputs go to ``synth/harness/fold_out.v``; every input and
every output is observable through the pins, so synthesis can remove nothing that is used.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from quadshade.errors import QuadshadeError

HARNESS = "harness"
"""Name of the top module."""


@dataclass(frozen=True)
class Port:
    """A port of a netlist: name, ``input`` or ``output``, bits."""

    name: str
    direction: str
    bits: int


def module_ports(verilog: str, top: str) -> list[Port]:
    """
    Ports of a module as GHDL writes it.

    Parameters
    ----------
    verilog : str
      A netlist.
    top : str
      Name of a module in it.

    Raises
    ------
    QuadshadeError
      There is no such module.
    """
    header = re.search(rf"^module {re.escape(top)}\b(.*?)\);", verilog, re.MULTILINE | re.DOTALL)
    if header is None:
        raise QuadshadeError(f"the netlist has no module {top}")
    found = re.findall(r"(input|output)\s+(?:\[(\d+):0\])?\s*(\w+)", header[1])
    return [Port(name, direction, int(high) + 1 if high else 1) for direction, high, name in found]


def write_harness(ports: list[Port], top: str) -> str:
    """
    Verilog of a module ``harness`` (clk, serial, folded) around a netlist.

    Parameters
    ----------
    ports : list of Port
      Of the netlist; ``clk`` is its clock.
    top : str
      The netlist's module.
    """
    lines = [f"    {top} dut (\n        .clk(clk)"]
    widths = {"input": 0, "output": 0}
    for port in ports:
        if port.name == "clk":
            continue
        low = widths[port.direction]
        widths[port.direction] += port.bits
        vector = "stimulus" if port.direction == "input" else "response"
        lines.append(f",\n        .{port.name}({vector}[{low + port.bits - 1}:{low}])")
    inputs, outputs = widths["input"], widths["output"]
    return f"""\
module {HARNESS} (
    input clk,
    input serial,
    output folded
);
    wire [{inputs - 1}:0] stimulus;
    wire [{outputs - 1}:0] response;
    shift_in #(.WIDTH({inputs})) drive (.clk(clk), .serial(serial), .data(stimulus));
{"".join(lines)}
    );
    fold_out #(.WIDTH({outputs})) observe (.clk(clk), .data(response), .folded(folded));
endmodule
"""
