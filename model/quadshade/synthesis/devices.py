# SPDX-License-Identifier: Apache-2.0
"""Devices that the core is synthesised for, and the boards that carry them (``synth/boards``)."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from quadshade.errors import QuadshadeError
from quadshade.synthesis.families import Device, devices, find_family


def find_device(name: str) -> Device:
    """
    A device by name.

    Raises
    ------
    QuadshadeError
      There is no such device, or no family of it.
    """
    known = devices()
    if name not in known:
        if "-" in name:
            find_family(name.split("-")[0])
        raise QuadshadeError(f"unknown device {name!r}", f"the devices are {', '.join(known)}")
    return known[name]


def board_file(name: str, root: Path) -> dict[str, Any]:
    """
    What ``synth/boards/<name>.toml`` holds.

    Raises
    ------
    QuadshadeError
      There is no such board, or its file is no TOML.
    """
    boards = {path.stem: path for path in sorted((root / "synth" / "boards").glob("*.toml"))}
    if name not in boards:
        raise QuadshadeError(f"unknown board {name!r}", f"the boards are {', '.join(boards)}")
    try:
        return tomllib.loads(boards[name].read_text())
    except tomllib.TOMLDecodeError as problem:
        raise QuadshadeError(f"{boards[name]}: {problem}") from None


def find_board(name: str, root: Path) -> Device:
    """
    The device on a board, from ``synth/boards/<name>.toml``.

    Raises
    ------
    QuadshadeError
      There is no such board, or its file does not name a device.
    """
    settings = board_file(name, root)
    if "device" not in settings:
        raise QuadshadeError(f"synth/boards/{name}.toml names no device", 'write device = "..."')
    return find_device(str(settings["device"]))
