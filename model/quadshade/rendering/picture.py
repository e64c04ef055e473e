# SPDX-License-Identifier: Apache-2.0
"""A picture with what it cost, and how far it is from another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from quadshade.choices import PHONG
from quadshade.contract.triangles import ScreenTriangles
from quadshade.errors import QuadshadeError
from quadshade.files.atomic import write_atomically
from quadshade.image import Comparison, compare, encode_png, read_picture, write_png

if TYPE_CHECKING:
    from quadshade.rendering.settings import RenderSettings
    from quadshade.rendering.words import SetupWords


@dataclass(frozen=True)
class Stats:
    """
    What a picture is of, and what it took.

    Attributes
    ----------
    engine : str or None
      What drew it; None for a board.
    clocks : int or None
      Of the core, from the first set-up word to the last pixel. None for Phong shading, of which the engine
      draws coverage and depth only, and for a board, which does not count them.
    pixels, triangles, triangles_drawn, packets : int or None
      All that were drawn, also where something nearer hides them; None for a board, as the next ones.
    words : int or None
      Set-up words of 32 bits; None for Phong shading as well.
    clocks_per_pixel, bound : float or None
      ``bound`` in grey levels: no pixel is further from the exact polynomial, before rounding.
    triangles_undefined : int or None
      Triangles that the set-up method could not set up, drawn as 0.
    generics : dict of str to int
      Of the core, or of the board.
    scene, shading : str
      ``shading`` is ``adaptive`` where an error or a budget chose it.
    width, height, faces, whole_faces : int
      Pixels; triangles of the mesh, as it is drawn and before ``--lod``.
    visible_pixels : int or None
      Pixels that show the scene, not the background.
    adaptive : dict or None
      What an error or a budget has chosen.
    gbuffer : dict or None
      The engine's counts of the pass that drew normals and depth.
    port : str or None
      The board's.
    line : dict or None
      What the board's line did: bytes, frames, time-outs, seconds.
    timing : dict or None
      With a frame time: what the picture takes of it, and the levers that gave it.
    """

    engine: str | None = None
    clocks: int | None = None
    pixels: int | None = None
    triangles: int | None = None
    triangles_drawn: int | None = None
    packets: int | None = None
    words: int | None = None
    clocks_per_pixel: float | None = None
    bound: float | None = None
    triangles_undefined: int | None = None
    generics: Mapping[str, int] = field(default_factory=dict)
    scene: str = ""
    shading: str = ""
    width: int = 0
    height: int = 0
    faces: int = 0
    whole_faces: int = 0
    visible_pixels: int | None = None
    adaptive: Mapping[str, Any] | None = None
    gbuffer: Mapping[str, Any] | None = None
    port: str | None = None
    line: Mapping[str, float] | None = None
    timing: Mapping[str, Any] | None = None

    def as_dict(self) -> dict[str, Any]:
        """What ``--stats`` writes."""
        if self.port is not None:
            names = ["scene", "shading", "width", "height", "adaptive", "faces", "whole_faces", "generics"]
            names.append("timing")
            content: dict[str, Any] = {"port": self.port, **(self.line or {})}
        else:
            names = [one.name for one in fields(self) if one.name not in ("port", "line")]
            content = {}
        optional = ("adaptive", "gbuffer", "timing")
        given = {name: getattr(self, name) for name in names}
        return content | {
            name: value for name, value in given.items() if value is not None or name not in optional
        }


@dataclass(frozen=True, eq=False, repr=False)
class Picture:
    """
    What :func:`quadshade.render` has drawn; a notebook shows it.

    Attributes
    ----------
    array : (height, width, 3) uint8
      Red, green and blue.
    stats : Stats
    triangles : ScreenTriangles
      What was drawn, for :func:`quadshade.draw` and :meth:`quadshade.Board.draw`.
    triangle : (height, width) int32 or None
      Index of the one of ``triangles`` that each pixel shows, -1 where nothing was drawn; None from a board,
      which does not say.
    depth : (height, width) uint32 or None
      0 (near) .. 2**depth_bits - 1, which it is where nothing was drawn too. None from a board, whose depth
      stays there (:meth:`quadshade.Board.read_depth`), and of a core without depth.
    notes : tuple of str
      What is not as it was asked for.
    summary : str
      Size, counts and costs, in a line.
    """

    array: np.ndarray
    stats: Stats
    triangles: ScreenTriangles
    triangle: np.ndarray | None
    depth: np.ndarray | None
    notes: tuple[str, ...]
    summary: str
    settings: RenderSettings
    shades: Callable[[], np.ndarray] | None = None
    """Phong shading of what the picture shows, where its own coverage is that of :meth:`phong`."""

    def __repr__(self) -> str:
        """One line, as the command line prints it."""
        return f"<Picture {self.stats.scene}: {self.summary}>".replace("\n", ";")

    @property
    def covered(self) -> np.ndarray | None:
        """(height, width) bool: where the scene is seen; None from a board, as ``triangle``."""
        return None if self.triangle is None else self.triangle >= 0

    def save(self, path: str | Path) -> None:
        """
        Write a PNG file, whole or not at all.

        Raises
        ------
        QuadshadeError
          A name that does not end in .png, or a file that cannot be written.
        """
        path = Path(path)
        check_png(path)
        write_atomically(path, lambda temporary: write_png(temporary, self.array))

    def error_to(self, reference: str | Path | Picture | np.ndarray) -> Comparison:
        """
        How far the picture is from another one.

        Parameters
        ----------
        reference : str, Path, Picture or (height, width, 3) uint8
          ``"phong"``: the same scene in the same light and style, shaded in float at every pixel over the
          coverage and depth of the same core. Else a picture of the same size, or its file.

        Returns
        -------
        Comparison
          PSNR in dB, SSIM, root mean square and largest error in grey levels.

        Raises
        ------
        QuadshadeError
          A picture of another size, a file that cannot be read, or a style that Phong shading does not have.
        """
        if isinstance(reference, Picture):
            other = reference.array
        elif isinstance(reference, np.ndarray):
            other = reference
        elif reference == PHONG:
            other = self.phong_array()
        elif not isinstance(reference, str | Path):
            raise QuadshadeError(
                f"the reference is of type {type(reference).__name__}",
                "give 'phong', a picture, an array or a file's name",
            )
        else:
            other = read_picture(Path(reference))
        return compare(self.array, other)

    def phong(self) -> Picture:
        """The same scene, shaded in float at every pixel, over the coverage and depth of the same core."""
        from quadshade.rendering.draw import render_picture
        from quadshade.rendering.settings import reference_settings

        height, width = self.array.shape[:2]
        return render_picture(reference_settings(self.settings, (width, height), self.stats.generics))

    def setup_words(self) -> SetupWords:
        """
        The picture as a core takes it, for a bench or a ROM: what ``quadshade words`` writes.

        Returns
        -------
        SetupWords
          The set-up stream of the picture's triangles and what the golden model makes of it; its ``save``
          writes both.
        """
        from quadshade.contract.formats import Formats
        from quadshade.rendering.words import SetupWords

        return SetupWords.of(self.triangles, Formats(**self.stats.generics), self.settings.setup)

    def phong_array(self) -> np.ndarray:
        """The pixels of :meth:`phong`, without drawing anew where that is not needed."""
        return self.phong().array if self.shades is None else self.shades()

    def _repr_png_(self) -> bytes:
        """What a notebook shows."""
        return encode_png(self.array)


def check_png(path: Path) -> None:
    """Refuse the name of a picture that does not end in .png; raises :class:`QuadshadeError`."""
    if path.suffix.lower() != ".png":
        raise QuadshadeError(f"the output is {str(path)!r}", "give a name that ends in .png")
