# SPDX-License-Identifier: Apache-2.0
"""Options and file writing that several commands share."""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

import click

from quadshade.contract.formats import GENERIC_HELP, Formats
from quadshade.engine import ENGINES
from quadshade.errors import QuadshadeError

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


def parse_generics(values: Iterable[str]) -> dict[str, int]:
    """
    Values of ``--generic`` as a dictionary for :meth:`quadshade.contract.formats.Formats.with_generics`.

    Parameters
    ----------
    values : iterable of str
      ``name=value``, the value a decimal integer.

    Returns
    -------
    dict of str to int

    Raises
    ------
    QuadshadeError
      No ``=``, a value that is no integer, or a name given twice. Whether the core has such a generic is
      checked by ``with_generics``.
    """
    settings: dict[str, int] = {}
    for text in values:
        name, equals, value = text.partition("=")
        name = name.strip().lower()
        if not equals or not name:
            raise QuadshadeError(
                f"--generic {text!r} is not name=value", "write for example stream_width=128"
            )
        if name in settings:
            raise QuadshadeError(f"generic {name} is given twice", "give it once")
        if not re.fullmatch(r"\s*[+-]?[0-9]{1,18}\s*", value):
            raise QuadshadeError(f"generic {name} is {value[:40]!r}", "give a whole number")
        settings[name] = int(value)
    return settings


def _is_device(path: Path) -> bool:
    """Whether a path is a device or a pipe: something to write to, not to replace."""
    return path.exists() and not path.is_file() and not path.is_dir()


def check_writable(*paths: Path | None, inputs: Iterable[Path] = ()) -> None:
    """
    Fail before the work, not after it: raise :class:`QuadshadeError` where a file cannot be written.

    Parameters
    ----------
    *paths : Path or None
      Files that the command will write, all different.
    inputs : iterable of Path
      Files that it reads, which it must not overwrite.
    """
    taken = {os.path.realpath(path): "is read as well" for path in inputs}
    for path in paths:
        if path is None or (_is_device(path) and os.access(path, os.W_OK)):
            continue
        folder = path.parent
        if not folder.is_dir():
            raise QuadshadeError(f"cannot write {path}: there is no folder {folder}", "make it first")
        place = os.path.realpath(path)
        # The file is made beside the old one, which it then takes the place of.
        needed = [os.path.dirname(place), *([path] if path.exists() else [])]
        if path.is_dir() or not all(os.access(one, os.W_OK) for one in needed):
            raise QuadshadeError(f"cannot write {path}", "choose another path")
        if place in taken:
            raise QuadshadeError(f"cannot write {path}: it {taken[place]}", "choose another path")
        taken[place] = "is given for two outputs"


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """
    Let ``write`` fill a temporary file beside ``path``, then move it there, so that no half file remains.

    A link stays one, and the file that it points to is replaced; a device or a pipe is written directly.

    Parameters
    ----------
    path : Path
    write : callable
      Gets the temporary path, which has the suffix of ``path``.

    Raises
    ------
    QuadshadeError
      The file cannot be written.
    """
    temporary = None
    try:
        if _is_device(path):
            with tempfile.TemporaryDirectory() as folder:
                filled = Path(folder) / path.name
                write(filled)
                path.write_bytes(filled.read_bytes())
            return
        path = Path(os.path.realpath(path))
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix)
        os.close(handle)
        temporary = Path(name)
        write(temporary)
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
    except OSError as error:
        raise QuadshadeError(
            f"cannot write {path}: {error.strerror or error}", "choose another path"
        ) from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def write_json(path: Path, content: dict) -> None:
    """Write ``content`` as indented JSON, atomically; raises :class:`QuadshadeError` where it cannot."""
    write_atomically(path, lambda temporary: temporary.write_text(json.dumps(content, indent=2) + "\n"))
