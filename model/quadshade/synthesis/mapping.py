# SPDX-License-Identifier: Apache-2.0
"""Yosys' commands from a netlist to the cells of a device."""

from __future__ import annotations

from quadshade.synthesis.families import Device, filled

CHECKED = ("proc", "select -assert-none t:$dlatch t:$adlatch t:$dlatchsr", "check -assert")
"""What a netlist must pass: no latch, no loop, no second driver, nothing undriven."""


LANES = "channel_lane*"
"""Modules that are mapped each by itself: in one piece, logic shared between them would be far from both."""


UNORDERED = "block_ram*/m:*words"
"""Memories whose users never need what is read in the clock of its writing (``make formal``): without this,
Yosys adds registers and comparators that make it the old word."""


def mapping_commands(device: Device, top: str) -> list[str]:
    """
    Yosys commands that map a design to a device's cells, lane by lane, then make it flat and check it.

    Parameters
    ----------
    device : Device
    top : str
      The module on top.
    """
    family = device.described
    return [
        *family.library,
        f"hierarchy -check -top {top}",
        f"setattr -mod -set keep_hierarchy 1 {LANES}",
        f"setattr -set no_rw_check 1 {UNORDERED}",
        *filled(family.passes, run=f"{device.yosys} -top {top} -run", **family.numbers),
        f"setattr -mod -unset keep_hierarchy {LANES}",
        "flatten",
        "clean",
        *filled(family.finish, top=top),
        "autoname",
        "delete t:$scopeinfo",
        "check -mapped -assert",
        "blackbox =A:whitebox",
    ]
