# SPDX-License-Identifier: Apache-2.0
"""Set-up words for a bench or a ROM, with the pixels that a core makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.engine import draw_words
from quadshade.files.triangle_file import open_triangles
from quadshade.files.word_file import write_words
from quadshade.golden.compiled import EmittedPixels
from quadshade.rendering.draw import adapt_note
from quadshade.rendering.groups import SetupChoice
from quadshade.rendering.levels import level_for_words, level_note
from quadshade.rendering.settings import RenderSettings, Reports
from quadshade.rendering.shade import default_count, shade_scene
from quadshade.setup import Primitives, pack, setup_triangles
from quadshade.setup.packet import packet_words
from quadshade.shading.sample import CHANNELS


@dataclass(frozen=True, eq=False)
class SetupWords:
    """
    A picture as a core takes it: the set-up stream, and what must come out.

    Attributes
    ----------
    words : (m,) uint32
      The stream, whole packets; a beat of ``formats.stream_width`` bits takes ``formats.beat_words`` of them,
      the first one lowest.
    triangles : ScreenTriangles
      What was set up.
    formats : Formats
      Generics of the core: ``raster_core``, with shade ``render_core``.
    primitives : Primitives
      What each packet says.
    pixels : EmittedPixels
      What the golden model makes of the words, in the order in which the core emits them.
    note : str
      What an error, a budget or a level of detail has chosen.
    """

    words: np.ndarray
    triangles: ScreenTriangles
    formats: Formats
    primitives: Primitives
    pixels: EmittedPixels
    note: str = ""

    @classmethod
    def of(
        cls, triangles: ScreenTriangles, formats: Formats, setup: SetupChoice | None = None, note: str = ""
    ) -> SetupWords:
        """
        Set triangles up.

        Parameters
        ----------
        triangles : ScreenTriangles
        formats : Formats
        setup : SetupChoice, optional
        note : str

        Returns
        -------
        SetupWords

        Raises
        ------
        QuadshadeError
          As :func:`quadshade.setup.setup_triangles`.
        """
        arguments = {} if setup is None else setup.arguments()
        primitives = setup_triangles(triangles, formats, **arguments)
        words = pack(primitives, formats)
        pixels = draw_words(words, formats, state=triangles.shade)
        return cls(words, triangles, formats, primitives, pixels, note)

    @property
    def lengths(self) -> np.ndarray:
        """(n,) words of each packet."""
        return packet_words(self.primitives.orders, self.primitives.header["has_second"], self.formats)

    @property
    def last(self) -> np.ndarray:
        """(pixels,) bool: the last pixel of its packet, as ``pixel_last``."""
        packet = self.pixels.packet
        return np.append(packet[1:] != packet[:-1], np.ones(min(1, len(packet)), dtype=np.bool_))

    def __repr__(self) -> str:
        return f"<SetupWords: {self.summary}>"

    @property
    def summary(self) -> str:
        """Counts, in a line."""
        return (
            f"{len(self.words)} words of {len(self.primitives)} packets for {len(self.triangles)} triangles, "
            f"{len(self.pixels.x)} pixels{self.note}"
        )

    def save(self, path: str | Path) -> None:
        """
        Write the words, and beside them layout, packets and pixels as CSV (``docs/guide/own_design.md``).

        Parameters
        ----------
        path : str or Path
          Ends in .hex, .mem, .bin, .c or .vhd, which says how they are written.

        Raises
        ------
        QuadshadeError
          Another ending, no words, or a file that cannot be written.
        """
        formats, pixels, state = self.formats, self.pixels, self.triangles.shade
        colours = CHANNELS if formats.with_shade else self.triangles.channels
        columns: dict[str, np.ndarray] = {"packet": pixels.packet, "x": pixels.x, "y": pixels.y}
        columns |= {name: pixels.value[:, index] for index, name in enumerate(colours)}
        if formats.with_depth:
            columns["depth"] = pixels.value[:, -1]
        lengths = self.lengths
        packets: dict[str, Any] = {
            "packet": np.arange(len(lengths)),
            "triangle": self.primitives.triangle,
            "first_word": np.cumsum(lengths) - lengths,
            "words": lengths,
        }
        write_words(
            Path(path),
            self.words,
            formats,
            (self.triangles.width, self.triangles.height),
            None if state is None else state.writes(),
            packets,
            columns | {"last": self.last.astype(np.int64)},
        )


def picture_words(settings: RenderSettings, reports: Reports | None = None) -> SetupWords:
    """
    Set-up words of what :func:`quadshade.rendering.draw.render_picture` draws.

    Parameters
    ----------
    settings : RenderSettings
      Style, engine and port are not looked at.
    reports : Reports, optional

    Returns
    -------
    SetupWords

    Raises
    ------
    QuadshadeError
      As for :func:`quadshade.rendering.draw.render_picture`, or Phong shading.
    """
    reports = reports or Reports()
    formats, scene = level_for_words(settings, "core", reports, default_count(settings))
    reports.step(f"setting {len(scene.projected)} triangles up")
    shaded = shade_scene(settings, scene, formats, reports)
    note = f"{level_note(scene)}{adapt_note(shaded)}"
    return SetupWords.of(shaded.triangles, shaded.formats, settings.setup, note)


def file_words(path: Path, generics: dict[str, int], setup: SetupChoice) -> SetupWords:
    """Set-up words of a triangles file; errors as of :func:`quadshade.rendering.draw.draw_triangles`."""
    triangles, formats = open_triangles(path, generics)
    return SetupWords.of(triangles, formats, setup)
