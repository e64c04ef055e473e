# SPDX-License-Identifier: Apache-2.0
"""Synthesis for FPGAs: GHDL's netlist through Yosys and nextpnr, and the table of what it costs."""

from quadshade.synthesis.devices import find_board, find_device
from quadshade.synthesis.families import Device, devices, find_family
from quadshade.synthesis.flow import Implementation, implement
from quadshade.synthesis.harness import module_ports, write_harness

__all__ = [
    "Device",
    "Implementation",
    "devices",
    "find_board",
    "find_device",
    "find_family",
    "implement",
    "module_ports",
    "write_harness",
]
