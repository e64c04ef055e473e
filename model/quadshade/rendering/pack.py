# SPDX-License-Identifier: Apache-2.0
"""What a board would draw, as the words that go over its line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.choices import parse_pack_error
from quadshade.packing.frame_file import FrameFile, encode_frame_file, pack_frame
from quadshade.rendering.draw import adapt_note
from quadshade.rendering.levels import level_for_words, level_note
from quadshade.rendering.settings import RenderSettings, Reports
from quadshade.rendering.shade import default_count, shade_scene


@dataclass(frozen=True)
class PackedPicture:
    """
    A packed picture.

    Attributes
    ----------
    frame : FrameFile
    content : bytes
      Of its file.
    summary : str
      Size and counts, in a line.
    """

    frame: FrameFile
    content: bytes
    summary: str


def pack_picture(
    settings: RenderSettings, pack_error: float, reports: Reports | None = None, vertices: bool = False
) -> PackedPicture:
    """
    Pack what :func:`quadshade.rendering.draw.render_picture` draws.

    Parameters
    ----------
    settings : RenderSettings
      Style, engine and port are not looked at.
    pack_error : float
      Grey levels that shorter words may add.
    reports : Reports, optional
    vertices : bool
      As for :func:`quadshade.packing.frame_file.pack_frame`.

    Returns
    -------
    PackedPicture

    Raises
    ------
    QuadshadeError
      As for :func:`quadshade.rendering.draw.render_picture`, or Phong shading.
    """
    reports = reports or Reports()
    count = default_count(settings, parse_pack_error(pack_error))
    formats, scene = level_for_words(settings, "board", reports, count)
    reports.step(f"packing {len(scene.projected)} triangles")
    shaded = shade_scene(settings, scene, formats, reports, count)
    frame, batch = pack_frame(
        shaded.triangles,
        shaded.formats,
        scene.ground,
        parse_pack_error(pack_error),
        vertices=vertices,
        **settings.setup.arguments(),
    )
    size = frame.line_bytes() / max(1, frame.triangles)
    undefined = int(np.count_nonzero(batch.primitives.undefined))
    note = adapt_note(shaded)
    summary = (
        f"{frame.width}x{frame.height}, {frame.triangles} triangles in {frame.packets} packets"
        f"{level_note(scene)}, "
        f"{size:.1f} bytes a triangle on the line, at most {batch.added:.4f} grey levels added"
        + (f", {undefined} packets undefined and drawn as 0" if undefined else "")
        + (f"; before packing:{note}" if note else "")
    )
    return PackedPicture(frame, encode_frame_file(frame), summary)
