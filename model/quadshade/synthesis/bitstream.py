# SPDX-License-Identifier: Apache-2.0
"""From a board's file in ``synth/boards`` to its packed bitstream, with the clocks that it has to keep."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from quadshade.contract.formats import Formats
from quadshade.engine.build_cache import build_key, build_once
from quadshade.engine.netlist import write_netlist
from quadshade.engine.tool_runner import package_version, run_tool
from quadshade.errors import QuadshadeError
from quadshade.synthesis.cells import with_cells
from quadshade.synthesis.devices import board_file, check_entries, find_board
from quadshade.synthesis.families import Device, filled
from quadshade.synthesis.flow import YOSYS, run_nextpnr, write_mapped
from quadshade.synthesis.mapping import mapping_commands

ENTITY = "board"
TOP = "top"
RESET = "power_on_reset.v"
BAUD = 1_000_000
ROUTED = "routed"
"""File of what nextpnr has routed, for the packer."""

NEEDED = ("top", "constraints", "clocks", "generics", "program")
"""What a board's file has beside its device, to be built."""


@dataclass(frozen=True)
class BoardFile:
    """
    A board that a bitstream is built for.

    Attributes
    ----------
    name : str
    device : Device
    top, constraints : Path
      Verilog with clock and pins, and where these are.
    clocks : dict of str to float
      Megahertz that the clocks of the design must reach, by a part of their name.
    generics : dict of str to int
      Of the entity ``board``.
    program : tuple of tuple of str
      Commands that load a bitstream, the preferred first; its path follows.
    pack : tuple of str
      Options of the packer.
    parts : tuple of Path
      Further Verilog of the top.
    more_constraints : tuple of Path
      Further files of pins.
    """

    name: str
    device: Device
    top: Path
    constraints: Path
    clocks: dict[str, float]
    generics: dict[str, int]
    program: tuple[tuple[str, ...], ...]
    pack: tuple[str, ...] = ()
    parts: tuple[Path, ...] = ()
    more_constraints: tuple[Path, ...] = ()

    @property
    def family(self) -> str:
        """A file in ``synth/families``."""
        return self.device.family

    @property
    def sources(self) -> list[Path]:
        """Verilog around the entity ``board``."""
        return [self.top, *self.parts, self.top.with_name(RESET)]

    def pins(self) -> str:
        """Text of all files of pins."""
        return "".join(path.read_text() for path in (self.constraints, *self.more_constraints))

    @property
    def formats(self) -> Formats:
        """The core's formats."""
        known = Formats().generics()
        return Formats(**{name: value for name, value in self.generics.items() if name in known})

    def bitstream(self, root: Path) -> Path:
        """Where the bitstream is."""
        return root / "build" / "bitstream" / f"{self.name}{self.device.described.suffix}"


@dataclass(frozen=True)
class Built:
    """
    A bitstream that was built.

    Attributes
    ----------
    path : Path
    seed : int
      Of nextpnr.
    clocks : dict of str to (float, float)
      Megahertz reached and required, by clock.
    area : dict of str to (int, int)
      Used and available.
    """

    path: Path
    seed: int
    clocks: dict[str, tuple[float, float]]
    area: dict[str, tuple[int, int]]

    @property
    def too_slow(self) -> dict[str, tuple[float, float]]:
        """Clocks that miss what they must reach."""
        return {name: pair for name, pair in self.clocks.items() if pair[0] < pair[1]}


def read_board(name: str, root: Path) -> BoardFile:
    """
    A board by the name of its file.

    Raises
    ------
    QuadshadeError
      There is no such board, its file lacks an entry, has a wrong one or names a file that is not there,
      or no bitstream is built for it.
    """
    device, settings = find_board(name, root), board_file(name, root)
    folder = root / "synth" / "boards"
    missing = [key for key in NEEDED if key not in settings]
    if missing:
        raise QuadshadeError(
            f"no bitstream is built for {name}: its file has no {missing[0]}",
            "write it as synth/boards/ulx3s-85f.toml has it",
        )
    check_entries(name, settings)
    more = settings.get("more_constraints", ())
    named = [settings["top"], settings["constraints"], *settings.get("parts", ()), *more]
    if lost := [file for file in named if not (folder / file).is_file()]:
        raise QuadshadeError(f"{name}.toml names synth/boards/{lost[0]}, which is not there", "write it")
    return BoardFile(
        name,
        device,
        folder / settings["top"],
        folder / settings["constraints"],
        {clock: float(mhz) for clock, mhz in settings["clocks"].items()},
        dict(settings["generics"]),
        tuple(tuple(command) for command in settings["program"]),
        tuple(settings.get("pack", ())),
        tuple(folder / part for part in settings.get("parts", ())),
        tuple(folder / file for file in more),
    )


def ports_of(top: Path) -> list[str]:
    """Every bit of the ports of a board's top, as pins are named."""
    text = re.sub(r"//.*", "", top.read_text())
    header = re.search(rf"module {TOP} \((.*?)\);", text, re.DOTALL)
    found: list[str] = []
    for high, name in re.findall(
        r"(?:input|output|inout)\s+(?:\[(\d+):0\]\s+)?(\w+)", header[1] if header else ""
    ):
        found += [f"{name}[{index}]" for index in range(int(high) + 1)] if high else [name]
    return found


def check_pins(board: BoardFile) -> None:
    """
    Every port of a board's top has a pin of its own.

    Raises
    ------
    QuadshadeError
      One has none, or one that another has.
    """
    pins = board.device.described.pins(board.pins())
    where = board.constraints.name
    owners: dict[str, str] = {}
    for port, pin in pins:
        if owners.setdefault(pin, port) != port:
            raise QuadshadeError(f"{where}: {port} has the pin {pin} of {owners[pin]}", "give it its own")
    ports = ports_of(board.top)
    if missing := [port for port in ports if port not in dict(pins)]:
        raise QuadshadeError(f"{where} has no pin for {missing[0]}", f"{board.top.name} has that port")
    if unknown := [port for port, _ in pins if port not in ports]:
        raise QuadshadeError(f"{where} has a pin for {unknown[0]}", f"{board.top.name} has no such port")


def missing_packages(board: BoardFile) -> list[str]:
    """Python packages of the board's family that are not installed."""
    missing = []
    for package in board.device.described.packages:
        try:
            package_version(package)
        except QuadshadeError:
            missing.append(package)
    return missing


def clocks_of(report: Mapping[str, Any], required: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """
    Clocks of nextpnr's report: reached and required.

    Raises
    ------
    QuadshadeError
      A required clock is not in the report, or one of the report is not required: nothing watches it.
    """
    found = {}
    for net, entry in report.get("fmax", {}).items():
        names = [name for name in required if name in net]
        if not names:
            raise QuadshadeError(f"clock {net} has no limit", "name it in the board's file, under clocks")
        # The longest name that fits: clk is a part of clk_pixel.
        name = max(names, key=len)
        found[name] = (float(entry["achieved"]), required[name])
    lost = set(required) - set(found)
    if lost:
        raise QuadshadeError(f"nextpnr reports no clock {min(lost)}", "has the design lost it?")
    return found


def build(
    board: BoardFile,
    root: Path,
    seeds: range = range(1, 4),
    progress: Callable[[str], None] = lambda text: None,
) -> Built:
    """
    Synthesise, place, route and pack a board, with one seed after another until its clocks are reached.

    Parameters
    ----------
    board : BoardFile
    root : Path
      Checkout of Quadshade.
    seeds : range
      Of nextpnr.
    progress : callable
      Called with a line of text for every step.

    Returns
    -------
    Built
      With the first seed that meets all clocks; the fastest one if none does. Its bitstream is then not
      written.

    Raises
    ------
    QuadshadeError
      A tool is missing or fails, a pin is missing, or the design does not fit.
    """
    check_pins(board)
    if missing := missing_packages(board):
        raise QuadshadeError(f"{missing[0]} is not installed", "run `make bitstream`, which installs it")
    folder = root / "build" / "bitstream" / board.name
    folder.mkdir(parents=True, exist_ok=True)
    progress(f"{board.name}: synthesis")
    netlist = write_netlist(board.generics, ENTITY)
    (folder / "board.v").write_text(with_cells(netlist.read_text(), board.family, root))
    for source in board.sources:
        shutil.copyfile(source, folder / source.name)
    names = " ".join(["board.v", *(source.name for source in board.sources)])
    # The tops hold cells of the device, which only synthesis itself knows: it checks the hierarchy.
    commands = [line for line in mapping_commands(board.device, TOP) if not line.startswith("hierarchy")]
    commands = [f"read_verilog {names}", *commands]
    if moved := write_mapped(commands, folder / "mapped.json", TOP, board.device):
        progress(f"{board.name}: {moved} flip-flops are those of block RAM")
    tries = []
    for seed in seeds:
        progress(f"{board.name}: seed {seed}: place and route, which takes minutes")
        tries.append(_route(board, folder, seed, root))
        told = ", ".join(
            f"{name} {mhz:.1f} of {least:g} MHz" for name, (mhz, least) in tries[-1].clocks.items()
        )
        progress(f"{board.name}: seed {seed}: {told}")
        if not tries[-1].too_slow:
            _pack(board, folder, root)
            return tries[-1]
    return max(tries, key=lambda one: min(mhz / least for mhz, least in one.clocks.values()))


def _route(board: BoardFile, folder: Path, seed: int, root: Path) -> Built:
    """One run of nextpnr; its result goes to the folder, and is kept for the same design on another board."""
    family, pins = board.device.described, board.constraints
    command = [*board.device.place, *filled(family.routed, routed=ROUTED), "--json", "mapped.json"]
    command += filled(family.constrained, pins=pins.name, mhz=board.clocks["clk"])
    command += ["--seed", str(seed), "--timing-allow-fail"]

    def make(place: Path) -> None:
        shutil.copyfile(folder / "mapped.json", place / "mapped.json")
        (place / pins.name).write_text(board.pins())
        run_nextpnr(command, place, board.device)
        (place / "mapped.json").unlink()

    texts = ((folder / "mapped.json").read_text(), board.pins())
    key = build_key(*texts, *command, package_version(family.packages[0]))
    placed = build_once(root / "build" / "routed", key, make)
    for name in (ROUTED, "report.json", "nextpnr.log"):
        shutil.copyfile(placed / name, folder / name)
    report = json.loads((folder / "report.json").read_text())
    cells = report["utilization"]
    area = {name: (cells[cell]["used"], cells[cell]["available"]) for name, cell in family.area.items()}
    return Built(board.bitstream(root), seed, clocks_of(report, board.clocks), area)


def _pack(board: BoardFile, folder: Path, root: Path) -> None:
    """The bitstream from nextpnr's result, moved to its place."""
    packed = f"packed{board.device.described.suffix}"
    packer, *options = filled(board.device.described.packer, routed=ROUTED, packed=packed)
    run_tool([packer, *board.device.pack, *board.pack, *options], folder)
    (folder / packed).replace(board.bitstream(root))


def program(board: BoardFile, root: Path) -> list[str]:
    """
    Load a bitstream that was built into a board.

    Returns
    -------
    list of str
      The command that did it.

    Raises
    ------
    QuadshadeError
      There is no bitstream, no tool that loads it, or the tool fails.
    """
    path = board.bitstream(root)
    if not path.is_file():
        raise QuadshadeError(
            f"there is no {path.relative_to(root)}", f"run `make bitstream BOARD={board.name}`"
        )
    for command in board.program:
        if shutil.which(command[0]) is None:
            continue
        done = subprocess.run([*command, str(path)], check=False)
        if done.returncode != 0:
            raise QuadshadeError(
                f"{command[0]} failed with exit code {done.returncode}",
                "is the board connected, and yours to use?",
            )
        return [*command, str(path)]
    tools = " or ".join(command[0] for command in board.program)
    raise QuadshadeError(
        f"{tools} is not installed", f"`apt install {board.program[0][0].lower()}`, for example"
    )


def tools_of(board: BoardFile) -> list[str]:
    """Versions of what builds a board."""
    return [package_version(package) for package in (YOSYS, *board.device.described.packages)]
