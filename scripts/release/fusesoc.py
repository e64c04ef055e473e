# SPDX-License-Identifier: Apache-2.0
"""
Write ``quadshade.core``, the RTL for FuseSoC (CAPI2), from ``rtl/files.f``. ``--check`` only compares.

A fileset is a folder of ``rtl/`` in a library of its own, so that ``uart_rx`` or ``crc32`` meet no other
entity of that name.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import yaml

import quadshade
from quadshade.engine.sources import rtl_files
from quadshade.files.atomic import write_text

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "quadshade.core"
LIBRARY = "quadshade"
DESCRIPTION = "Quadratic shading for small FPGAs: an exact rasteriser, one pixel per clock"

SETS = {
    "core": ("generated", "common", "core"),
    "shade": ("shade",),
    "screen": ("screen",),
    "link": ("link",),
}
"""Filesets and the folders of ``rtl/`` that they hold; each builds on those before it."""

TOPS = {
    "core": ("raster_core", ["core"], "the rasteriser"),
    "core_shade": ("render_core", ["core", "shade"], "the rasteriser with the shade unit"),
    "axis": ("quadshade_axis", ["core", "shade", "axis"], "the core between AXI streams"),
    "screen": ("screen", ["core", "shade", "screen"], "z-buffer, picture, monitor"),
    "board": ("board", ["core", "shade", "screen", "link", "board"], "all of it behind a UART"),
}
"""Targets: the entity, its filesets, and what it is."""

FAMILIES = ("ecp5", "ice40", "gowin")
"""Yosys' names of the families that a target maps the core to."""

HEADER = """\
CAPI=2:
# SPDX-License-Identifier: Apache-2.0
# Written by `make rtl` from rtl/files.f.

"""


def content() -> dict[str, Any]:
    """The core file's keys."""
    paths = [path.relative_to(ROOT) for path in rtl_files(ROOT)]
    filesets: dict[str, Any] = {}
    for name, folders in SETS.items():
        filesets[name] = _fileset([path for path in paths if path.parts[1] in folders])
    for name, stem in (("axis", "quadshade_axis"), ("board", "board")):
        filesets[name] = _fileset([path for path in paths if path.parts[1:] == (f"{stem}.vhd",)])
    filesets["bench"] = {
        "files": [
            {"examples/design/core_tb.vhd": {"file_type": "vhdlSource-2008"}},
            {"examples/design/words.hex": {"file_type": "user", "copyto": "words.hex"}},
            {"examples/design/words.pixels.csv": {"file_type": "user", "copyto": "words.pixels.csv"}},
        ]
    }
    filesets["synth"] = {"files": [{"synth/fusesoc/cells.py": {"file_type": "user", "copyto": "cells.py"}}]}
    targets: dict[str, Any] = {"default": {"filesets": ["core"], "toplevel": f"{LIBRARY}.raster_core"}}
    for name, (entity, sets, text) in TOPS.items():
        targets[name] = {"description": text, "filesets": sets, "toplevel": f"{LIBRARY}.{entity}"}
        targets[f"lint_{name}"] = {
            "description": f"analyse and elaborate {entity} with GHDL, warnings are errors",
            "filesets": sets,
            "toplevel": f"{LIBRARY}.{entity}",
            "flow": "sim",
            "flow_options": {
                "tool": "ghdl",
                "analyze_options": ["-Werror"],
                "sim_options": ["--no-run"],
            },
        }
    for family in FAMILIES:
        targets[f"synth_{family}"] = {
            "description": f"raster_core in cells of {family}, by GHDL and the Yosys that YOSYS names",
            "filesets": ["core", "synth"],
            "toplevel": f"{LIBRARY}.raster_core",
            "flow": "sim",
            "flow_options": {"tool": "ghdl", "sim_options": ["--no-run"]},
            "hooks": {"post_build": [f"cells_{family}"]},
        }
    targets["sim"] = {
        "description": "send words.hex to raster_core with GHDL, compare words.pixels.csv",
        "filesets": ["core", "bench"],
        "toplevel": "core_tb",
        "flow": "sim",
        "flow_options": {"tool": "ghdl", "sim_options": ["--ieee-asserts=disable"]},
    }
    scripts = {
        f"cells_{family}": {"cmd": ["python3", "cells.py", "raster_core", family], "filesets": ["synth"]}
        for family in FAMILIES
    }
    return {
        "name": f"{LIBRARY}::{LIBRARY}:{quadshade.__version__}",
        "description": DESCRIPTION,
        "filesets": filesets,
        "scripts": scripts,
        "targets": targets,
    }


def _fileset(paths: list[Path]) -> dict[str, Any]:
    """VHDL files of the library, in their order."""
    return {
        "files": [str(path) for path in paths],
        "file_type": "vhdlSource-2008",
        "logical_name": LIBRARY,
    }


def text() -> str:
    """The core file."""
    return HEADER + yaml.safe_dump(content(), sort_keys=False, width=110)


def main() -> int:
    """Write the core file, or check it; the exit code."""
    if "--check" in sys.argv[1:]:
        if CORE.exists() and CORE.read_text() == text():
            return 0
        print("quadshade.core is not what rtl/files.f says: run `make rtl`", file=sys.stderr)
        return 1
    write_text(CORE, text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
