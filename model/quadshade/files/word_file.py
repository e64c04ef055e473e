# SPDX-License-Identifier: Apache-2.0
"""Set-up words as files for benches, ROMs and firmware, with tables beside them that say what they are."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from quadshade.contract.formats import (
    DIFFERENCES,
    DIFFERENCES_OF_ORDER,
    SECTIONS,
    SETUP_WORD_BITS,
    Formats,
)
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_bytes, write_text

DIFFERENCE_MEANINGS = (
    "at the first pixel",
    "a scanline down, along the major edge",
    "a pixel along the scanline",
    "second difference, scanline and scanline",
    "second difference, scanline and pixel",
    "second difference, pixel and pixel",
)


C_WORDS = frozenset(
    [
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "main",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
    ]
)
"""Names that an array of C cannot have."""


class Stream(NamedTuple):
    """
    What a file of words holds.

    Attributes
    ----------
    name : str
      An identifier of C and VHDL.
    words : (m,) uint32
      Whole packets.
    first : (n,) int64
      The first word of each packet.
    formats : Formats
    size : tuple of int
      Width and height of the screen in pixels.
    state : (s, 2) uint32 or None
      Addresses and data that load the shade unit's state.
    """

    name: str
    words: np.ndarray
    first: np.ndarray
    formats: Formats
    size: tuple[int, int]
    state: np.ndarray | None

    def beats(self) -> list[str]:
        """A beat each, in hexadecimal, the first word lowest, which is on the right."""
        rows = self.words.reshape(-1, self.formats.beat_words)[:, ::-1].tolist()
        return ["".join(f"{word:08x}" for word in row) for row in rows]

    def constants(self) -> dict[str, int]:
        """Generics that the core has to be built with, and the screen's size."""
        formats = self.formats
        generics = formats.generics() if formats.with_shade else formats.core_generics()
        return generics | {"screen_width": self.size[0], "screen_height": self.size[1]}

    @property
    def entity(self) -> str:
        """The core that these words are for."""
        return "render_core" if self.formats.with_shade else "raster_core"


def write_words(
    path: Path,
    words: np.ndarray,
    formats: Formats,
    size: tuple[int, int],
    state: np.ndarray | None,
    packets: Mapping[str, np.ndarray],
    pixels: Mapping[str, np.ndarray],
) -> None:
    """
    Write a set-up stream, and ``NAME.layout.csv``, ``NAME.packets.csv``, ``NAME.pixels.csv`` beside it.

    Parameters
    ----------
    path : Path
      Its ending says how: .hex a beat a line; .mem the same with comments, for ``$readmemh``; .bin words of
      32 bits, the low byte first; .c an array of ``uint32_t``; .vhd a package of beats.
    words : (m,) uint32
      Whole packets.
    formats : Formats
    size : tuple of int
      Width and height of the screen in pixels.
    state : (s, 2) uint32 or None
      Addresses and data that load the shade unit's state: in .c and .vhd themselves, and in
      ``NAME.state.csv``.
    packets, pixels : mapping of str to (n,) int
      Columns of the tables.

    Raises
    ------
    QuadshadeError
      Another ending, no words, or a file that cannot be written.
    """
    writer = writer_of(path)
    if not len(words):
        raise QuadshadeError(
            "no triangle covers a pixel: there are no words", "look at the scene with render"
        )
    tables = {"layout": layout_table(formats), "packets": _csv(packets), "pixels": _csv(pixels)}
    if state is not None:
        tables["state"] = _csv({"address": state[:, 0], "data": state[:, 1]})
    else:
        # One that is there is of words that were written before.
        table_path(path, "state").unlink(missing_ok=True)
    for name, text in tables.items():
        write_text(table_path(path, name), text)
    stream = Stream(_name(path), words, packets["first_word"], formats, size, state)
    write_bytes(path, writer(stream))


def table_path(path: Path, name: str) -> Path:
    """Where a table stands beside a file of words."""
    return path.with_name(f"{path.stem}.{name}.csv")


def layout_table(formats: Formats) -> str:
    """
    Where every field of a packet lies, as CSV.

    ``first_bit`` counts from the section's first beat. A packet is the section ``edge``, where ``has_second``
    says so ``second``, then every group of channels: of the six differences 1, 3 or 6, as the highest order
    in the group says.
    """
    rows = ["section,field,first_bit,bits,meaning"]
    for section, fields in SECTIONS:
        places = formats.section(section)
        rows += [f'{section},{name},{places[name][0]},{places[name][1]},"{text}"' for name, _, text in fields]
    beat_bits = formats.difference_beats * formats.stream_width
    for group, channels in enumerate(formats.channel_groups):
        for difference, (name, text) in enumerate(zip(DIFFERENCES, DIFFERENCE_MEANINGS, strict=True)):
            for index, channel in enumerate(channels):
                first = difference * beat_bits + index * formats.difference_words * SETUP_WORD_BITS
                order = next(order for order, sent in enumerate(DIFFERENCES_OF_ORDER) if sent > difference)
                rows.append(
                    f'group {group},channel {channel} {name},{first},{formats.word_width},"{text}; '
                    f'order {order} and above"'
                )
    return "\n".join(rows) + "\n"


def _csv(columns: Mapping[str, np.ndarray]) -> str:
    """A table of integers, a column each."""
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(str, row)) for row in rows)]) + "\n"


def _name(path: Path) -> str:
    """A file's name as an identifier of C and VHDL."""
    name = re.sub(r"[^a-z0-9]+", "_", path.stem.lower()).strip("_")
    usable = re.match("[a-z]", name) and name not in C_WORDS
    return name if usable else f"words_{name}".rstrip("_")


def _hex(stream: Stream) -> bytes:
    return ("\n".join(stream.beats()) + "\n").encode()


def _mem(stream: Stream) -> bytes:
    formats = stream.formats
    starts = {int(word) // formats.beat_words: packet for packet, word in enumerate(stream.first)}
    lines = [f"// Set-up stream of {stream.entity}, {formats.stream_width} bits a line"]
    lines += [f"// {name} = {value}" for name, value in stream.constants().items()]
    for index, beat in enumerate(stream.beats()):
        lines += [f"// packet {starts[index]}", beat] if index in starts else [beat]
    return ("\n".join(lines) + "\n").encode()


def _bin(stream: Stream) -> bytes:
    return stream.words.astype("<u4").tobytes()


def _c(stream: Stream) -> bytes:
    name, words, state = stream.name, stream.words, stream.state
    lines = [f"/* Set-up stream of {stream.entity}. */", "#include <stdint.h>", ""]
    lines += [f"#define {name.upper()}_{key.upper()} {value}" for key, value in stream.constants().items()]
    lines += [f"#define {name.upper()}_WORDS {len(words)}", "", f"const uint32_t {name}[] = {{"]
    texts = [f"0x{word:08x}u," for word in words.tolist()]
    lines += ["  " + " ".join(texts[at : at + 8]) for at in range(0, len(texts), 8)] + ["};"]
    if state is not None:
        lines += ["", "/* Address and data that load the shade unit. */"]
        lines += [f"#define {name.upper()}_STATE_WRITES {len(state)}", ""]
        lines += [f"const uint32_t {name}_state[][2] = {{"]
        lines += [f"  {{ {address}u, 0x{data:08x}u }}," for address, data in state.tolist()] + ["};"]
    return ("\n".join(lines) + "\n").encode()


def _vhd(stream: Stream) -> bytes:
    lines = [
        f"-- Set-up stream of {stream.entity}: its generics, and a beat an element.",
        "",
        "library ieee;",
        "use ieee.std_logic_1164.all;",
        "",
        f"package {stream.name}_pkg is",
        "",
    ]
    lines += [f"  constant {key} : natural := {value};" for key, value in stream.constants().items()]
    beats = [f'x"{beat}"' for beat in stream.beats()]
    lines += _vhdl_array("beats", "setup_beats", stream.formats.stream_width, beats)
    if stream.state is not None:
        writes = [f'x"{address:04x}{data:08x}"' for address, data in stream.state.tolist()]
        lines += ["", "  -- What loads the shade unit: an address of 16 bits, then 32 bits of data."]
        lines += _vhdl_array("writes", "state_writes", 48, writes)
    return ("\n".join([*lines, "", "end package;"]) + "\n").encode()


def _vhdl_array(kind: str, name: str, width: int, values: list[str]) -> list[str]:
    """An array's type and its constant; named association, as an array may have one element."""
    rows = [f"    {index} => {value}" for index, value in enumerate(values)]
    return [
        "",
        f"  type {kind}_t is array (natural range <>) of std_ulogic_vector({width - 1} downto 0);",
        f"  constant {name} : {kind}_t(0 to {len(values) - 1}) := (",
        ",\n".join(rows),
        "  );",
    ]


Writer = Callable[[Stream], bytes]

WRITERS: dict[str, Writer] = {".hex": _hex, ".mem": _mem, ".bin": _bin, ".c": _c, ".vhd": _vhd}


def writer_of(path: Path) -> Writer:
    """
    What writes a file of this ending.

    Raises
    ------
    QuadshadeError
      There is none.
    """
    if path.suffix.lower() not in WRITERS:
        raise QuadshadeError(f"the output is {str(path)!r}", f"give a name that ends in {', '.join(WRITERS)}")
    return WRITERS[path.suffix.lower()]
