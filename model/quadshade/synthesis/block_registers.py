# SPDX-License-Identifier: Apache-2.0
"""
Registers behind block RAM of ECP5, moved into the blocks.

A block's word comes 5.8 ns after the clock on speed grade 6, and 1 ns after it through the register that
the block has behind it (``REGMODE = OUTREG``). Yosys does not use that register; here the flip-flops that do
the same are replaced by it.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

BLOCK, FLIP_FLOP = "DP16KD", "TRELLIS_FF"
WIDEST = 18
"""Bits of a port's word; of wider ones a block has only one, across both ports."""


def _enable(cell: Mapping[str, Any]) -> tuple[Any, ...] | None:
    """A flip-flop's enable: a net, or ``("1",)``; None if it is inverted or has a reset or a set."""
    parameters, nets = cell["parameters"], cell["connections"]
    if nets.get("LSR", ["0"]) != ["0"] or parameters.get("LSRMUX", "LSR").strip() != "LSR":
        return None
    if parameters.get("CLKMUX", "CLK").strip() != "CLK" or parameters.get("REGSET", "RESET") != "RESET":
        return None
    chosen = parameters.get("CEMUX", "CE").strip()
    if chosen == "1":
        return ("1",)
    return tuple(nets["CE"]) if chosen == "CE" else None


def absorb_registers(design: dict[str, Any], top: str) -> int:
    """
    Move what can be moved of a design that Yosys has mapped.

    A register goes into its block if every word of the port goes to it and nowhere else, with the block's own
    clock and the very enable with which the block reads; it has neither reset nor set, and begins with zeros.

    Parameters
    ----------
    design : dict
      What Yosys' ``write_json`` writes, flat; changed in place.
    top : str
      Its module.

    Returns
    -------
    int
      Flip-flops that are no longer there.
    """
    module = design["modules"][top]
    cells = module["cells"]
    sinks: dict[int, list[tuple[str, str]]] = defaultdict(list)
    for name, cell in cells.items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] != "output":
                for bit in bits:
                    sinks[bit].append((name, port))
    for port in module["ports"].values():
        for bit in port["bits"]:
            sinks[bit].append(("", ""))
    absorbed = 0
    for block in [cell for cell in cells.values() if cell["type"] == BLOCK]:
        for side in "AB":
            absorbed += _absorb_side(block, side, cells, sinks)
    return absorbed


def _absorb_side(
    block: dict[str, Any], side: str, cells: dict[str, Any], sinks: Mapping[int, list[tuple[str, str]]]
) -> int:
    """One port of a block."""
    nets = block["connections"]
    if block["parameters"].get(f"REGMODE_{side}") == "OUTREG":
        return 0
    width = block["parameters"].get(f"DATA_WIDTH_{side}", "0")
    if (int(width, 2) if isinstance(width, str) else width) > WIDEST:
        return 0
    words = {port: nets[port][0] for port in nets if port.startswith(f"DO{side}") and nets[port]}
    found = {}
    for port, bit in words.items():
        users = sinks.get(bit, [])
        if not users:
            continue
        name, into = users[0]
        if len(users) > 1 or into != "DI" or cells[name]["type"] != FLIP_FLOP:
            return 0
        flip_flop = cells[name]
        if flip_flop["connections"]["CLK"] != nets[f"CLK{side}"]:
            return 0
        if _enable(flip_flop) != tuple(nets[f"CE{side}"]):
            return 0
        found[port] = name
    for port, name in found.items():
        nets[port] = cells.pop(name)["connections"]["Q"]
    if found:
        block["parameters"][f"REGMODE_{side}"] = "OUTREG"
        nets[f"OCE{side}"] = nets[f"CE{side}"]
    return len(found)


def absorb_in_file(path: Path, top: str) -> int:
    """:func:`absorb_registers` on a file of Yosys' JSON, which is written anew."""
    design = json.loads(path.read_text())
    absorbed = absorb_registers(design, top)
    path.write_text(json.dumps(design))
    return absorbed
