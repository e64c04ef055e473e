# SPDX-License-Identifier: Apache-2.0
"""Devices that the core is synthesised for, and the boards that carry them (``synth/boards``)."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
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


def _is_text(value: object) -> bool:
    """Something is written there."""
    return isinstance(value, str) and value != ""


def _is_texts(value: object) -> bool:
    """A list of such."""
    return isinstance(value, list) and all(_is_text(one) for one in value)


def _is_commands(value: object) -> bool:
    """A list of lists of words, none of them empty."""
    return isinstance(value, list) and all(_is_texts(one) and one for one in value)


def _is_clocks(value: object) -> bool:
    """Megahertz by name, that of the system clock among them."""
    return (
        isinstance(value, dict)
        and "clk" in value
        and all(isinstance(mhz, int | float) and mhz > 0 for mhz in value.values())
    )


def _is_generics(value: object) -> bool:
    """Whole numbers by name."""
    return isinstance(value, dict) and all(type(one) is int for one in value.values())


ENTRIES: Mapping[str, tuple[Callable[[object], bool], str]] = {
    "top": (_is_text, "the name of a file"),
    "constraints": (_is_text, "the name of a file"),
    "parts": (_is_texts, "a list of names of files"),
    "more_constraints": (_is_texts, "a list of names of files"),
    "clocks": (_is_clocks, "a table of megahertz, clk among them"),
    "generics": (_is_generics, "a table of whole numbers"),
    "program": (_is_commands, "a list of commands, each a list of words"),
    "pack": (_is_texts, "a list of options"),
}
"""What a board's file has beside its device: what an entry may be, and in words."""


def check_entries(name: str, settings: Mapping[str, Any]) -> None:
    """
    Every entry of a board's file is one that boards have, and of its kind.

    Raises
    ------
    QuadshadeError
      One is not.
    """
    for key, value in settings.items():
        if key != "device" and key not in ENTRIES:
            raise QuadshadeError(
                f"{name}.toml has {key}, which no board has", f"there are {', '.join(ENTRIES)}"
            )
        if key in ENTRIES and not ENTRIES[key][0](value):
            raise QuadshadeError(f"{name}.toml: {key} is {value!r}", f"write {ENTRIES[key][1]}")


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
