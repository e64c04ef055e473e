# SPDX-License-Identifier: Apache-2.0
"""Triangles to a VHDL package: the core's generics and its set-up words. ``make_words.py IN.json OUT.vhd``"""

from __future__ import annotations

import sys
from pathlib import Path

from quadshade.files.triangle_file import open_triangles
from quadshade.setup.packet import pack
from quadshade.setup.triangle_setup import setup_triangles

GENERICS = {"coord_bits": 7, "subpixel_bits": 4, "word_width": 28, "frac_bits": 18}
"""A core for a small screen: 128 x 128 pixels at most, vertices in 1/16 pixel, fewer bits of fraction."""

PACKAGE = """-- Written by make_words.py from {source}.

library ieee;
use ieee.std_logic_1164.all;

package picture_pkg is

  constant screen_width : positive := {width};
  constant screen_height : positive := {height};

  -- Generics of raster_core; those that are not here have their defaults.
{generics}

  type words_t is array (natural range <>) of std_ulogic_vector(31 downto 0);
  constant setup_words : words_t(0 to {last}) := (
{words}
  );

end package;
"""


def main(source: Path, output: Path) -> None:
    """Read triangles, compute their set-up words, write the package."""
    triangles, formats = open_triangles(source, GENERICS)
    words = pack(setup_triangles(triangles, formats), formats)
    names = ("num_channels", "with_depth", *GENERICS)
    constants = [f"  constant {name} : natural := {int(getattr(formats, name))};" for name in names]
    rows = [f'    x"{word:08x}"' for word in words.tolist()]
    text = PACKAGE.format(
        source=source.name,
        width=triangles.width,
        height=triangles.height,
        generics="\n".join(constants),
        last=len(rows) - 1,
        words=",\n".join(rows),
    )
    output.write_text(text)
    print(f"{output}: {len(rows)} words for {len(triangles)} triangles")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
