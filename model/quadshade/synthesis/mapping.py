# SPDX-License-Identifier: Apache-2.0
"""Yosys' commands from a netlist to the cells of a device."""

from __future__ import annotations

from quadshade.synthesis.devices import Device

CHECKED = ("proc", "select -assert-none t:$dlatch t:$adlatch t:$dlatchsr", "check -assert")
"""What a netlist must pass: no latch, no loop, no second driver, nothing undriven."""


LANES = "channel_lane*"
"""Modules that are mapped each by itself: in one piece, logic shared between them would be far from both."""


UNORDERED = "block_ram*/m:*words"
"""Memories whose users never need what is read in the clock of its writing (``make formal``): without this,
Yosys adds registers and comparators that make it the old word."""


LIBRARY = {"ecp5": ("read_verilog -lib +/lattice/cells_sim_ecp5.v",), "ice40": ()}
"""By family, what declares the cells that a netlist holds before it is mapped (``cells.py``)."""


LONGEST_COMPARED = 10
"""Bits of a number that is compared with a constant by LUTs, on iCE40."""

LONGEST_SHORT = 8
"""Bits of a sum or a difference that is made of LUTs, on iCE40."""

LEAST_SHARED = 6
"""Flip-flops behind logic that an enable or a reset of their own is kept for, on iCE40."""

FLIP_FLOPS = "t:$_DFF_* t:$_DFFE_* t:$_SDFF_* t:$_SDFFE_* t:$_SDFFCE_*"
"""Yosys' flip-flops of one bit."""

ICE40_FLIP_FLOPS = (
    "$_DFF_?_",
    "$_DFFE_?P_",
    "$_DFF_?P?_",
    "$_DFFE_?P?P_",
    "$_SDFF_?P?_",
    "$_SDFFCE_?P?P_",
)


def _legal_flip_flops(cells: tuple[str, ...], options: str) -> str:
    return " ".join(["dfflegalize", *(f"-cell {cell} 0" for cell in cells), options])


def _ice40_commands(run: str) -> list[str]:
    """
    Yosys' own passes for iCE40, with some between them that fill logic tiles better.

    A carry chain begins a tile of its own, and all flip-flops of a tile share enable and reset. So short
    sums, and comparisons with constants, are made of LUTs alone. A flip-flop that takes what another one or
    an input holds leaves the LUT beside it free: its enable and reset are made of that LUT, and it may stand
    anywhere. Of the others, an enable or a reset of fewer than ``LEAST_SHARED`` is made of the LUTs before
    them. Without it nextpnr finds no place for the last cells of a device that is nine tenths full, and puts
    what belongs together far apart on others.
    """
    shared = f"-mince {LEAST_SHARED} -minsrst {LEAST_SHARED}"
    return [
        f"{run} begin:coarse",
        "opt_expr",
        "opt -nodffe -nosdff",
        "wreduce",
        f"techmap -map +/cmp2lut.v -D LUT_WIDTH={LONGEST_COMPARED}",
        "simplemap t:$lut",
        "opt_expr",
        "opt_clean",
        f"{run} coarse:map_ram",
        f"select -set short t:$alu r:Y_WIDTH<={LONGEST_SHORT} %i",
        "techmap -map +/techmap.v @short",
        "opt_clean",
        f"{run} map_ram:map_ffs",
        # Bit by bit: a vector may be driven by both.
        "splitnets",
        f"select -set flip_flops {FLIP_FLOPS}",
        "select -set behind_logic t:* @flip_flops %d %co1 %co1:+[D] @flip_flops %i",
        "select -set behind_none @flip_flops @behind_logic %d",
        _legal_flip_flops(ICE40_FLIP_FLOPS[:1], "@behind_none"),
        _legal_flip_flops(ICE40_FLIP_FLOPS, shared),
        f"{run} map_ffs:check",
    ]


def mapping_commands(device: Device, top: str) -> list[str]:
    """
    Yosys commands that map a design to a device's cells, lane by lane, then make it flat and check it.

    Parameters
    ----------
    device : Device
    top : str
      The module on top.
    """
    run = f"{device.yosys} -top {top} -run"
    passes = _ice40_commands(run) if device.family == "ice40" else [f"{run} begin:check"]
    return [
        *LIBRARY[device.family],
        f"hierarchy -check -top {top}",
        f"setattr -mod -set keep_hierarchy 1 {LANES}",
        f"setattr -set no_rw_check 1 {UNORDERED}",
        *passes,
        f"setattr -mod -unset keep_hierarchy {LANES}",
        "flatten",
        "clean",
        "autoname",
        "delete t:$scopeinfo",
        "check -mapped -assert",
        "blackbox =A:whitebox",
    ]
