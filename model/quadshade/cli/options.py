# SPDX-License-Identifier: Apache-2.0
"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path

import click

from quadshade.contract.formats import GENERIC_HELP, Formats
from quadshade.engine import ENGINES

PATH = click.Path(dir_okay=False, path_type=Path)

GENERICS_EPILOG = "\b\nGenerics, and their defaults:\n" + "\n".join(
    f"{name}={value}".ljust(21) + GENERIC_HELP[name] for name, value in Formats().generics().items()
)
"""What the help of a command with ``--generic`` ends with."""

generic_option = click.option(
    "--generic",
    "generics",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a generic of the core for this run, under its VHDL name (repeatable), e.g. stream_width=128.",
)
engine_option = click.option(
    "--engine",
    type=click.Choice(ENGINES),
    envvar="QUADSHADE_ENGINE",
    help="What draws: the golden model, the VHDL in GHDL, or its netlist in Verilator.  "
    "[default: verilator where it and a C++ compiler are installed, else model]",
)
stats_option = click.option("--stats", type=PATH, help="Write clocks, pixels, triangles and words as JSON.")
waves_option = click.option(
    "--waves", type=PATH, help="Keep the simulation's waveforms (GHDL only), e.g. out.ghw."
)
