# SPDX-License-Identifier: Apache-2.0
"""Modules of GHDL's netlist that a device family has cells for, which Yosys does not find by itself."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from quadshade.synthesis.families import find_family


def with_cells(verilog: str, family: str, root: Path) -> str:
    """
    A netlist with the cells of a family in the place of the modules that do the same.

    Parameters
    ----------
    verilog : str
      From :func:`quadshade.engine.netlist.write_netlist`.
    family : str
      Of ``synth/families``, whose ``cells`` they are.
    root : Path
      Checkout of Quadshade.
    """
    for entity, entry in find_family(family).cells.items():
        cells = (root / "synth" / "cells" / f"{entity}.v").read_text()

        def named(
            found: re.Match[str],
            cells: str = cells,
            entity: str = entity,
            names: tuple[Any, ...] = tuple(entry["parameters"]),
        ) -> str:
            body = re.sub(rf"\bmodule {entity}\b", f"module {found[1]}", cells)
            for name, value in zip(names, found.groups()[1:], strict=True):
                body = re.sub(rf"\bparameter {name} = \d+", f"parameter {name} = {value}", body)
            return body

        module = re.compile(
            rf"^module ({entity}_{entry['named']})\b.*?^endmodule\n", re.MULTILINE | re.DOTALL
        )
        verilog = module.sub(named, verilog)
    return verilog
