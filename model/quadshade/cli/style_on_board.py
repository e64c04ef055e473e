# SPDX-License-Identifier: Apache-2.0
"""Styles of a picture that a board drew: its edges come from the board's edge map where it has one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quadshade.cli.style_options import StyleChoice
from quadshade.contract.formats import Formats
from quadshade.errors import QuadshadeError

if TYPE_CHECKING:
    from quadshade.board import Board
    from quadshade.cli.scene_options import ShownScene
    from quadshade.style import EdgeMaps


def can_draw_gbuffer(formats: Formats) -> bool:
    """Whether a board with these generics can draw normals and depth."""
    from quadshade.style.gbuffer import check_gbuffer

    try:
        check_gbuffer(formats, "linear")
    except QuadshadeError:
        return False
    return True


def style_on_board(
    choice: StyleChoice,
    picture: np.ndarray,
    scene: ShownScene,
    board: Board,
    verify: bool,
    pack_error: float,
) -> np.ndarray:
    """
    What a style makes of a picture that a board has drawn; its edges are drawn by the same board.

    Parameters
    ----------
    choice : StyleChoice
    picture : (h, w, 3) uint8
    scene : ShownScene
    board : Board
    verify : bool
      What is read must be what the golden model predicts.
    pack_error : float

    Returns
    -------
    (h, w, 3) uint8
    """
    from quadshade.style import draw_edges, hatch

    height, width = picture.shape[:2]
    if choice.style == "hatch":
        if board.formats.with_depth:
            drawn = board.read_depth(width, height, verify) < (1 << board.formats.depth_bits) - 1
        else:
            drawn = (picture != np.array(scene.ground)).any(axis=2)
        picture = hatch(picture, drawn, scene.ground)
    if not choice.kinds:
        return picture
    return draw_edges(picture, _edges(choice, scene, board, verify, pack_error), choice.kinds, choice.colours)


def _edges(choice: StyleChoice, scene: ShownScene, board: Board, verify: bool, pack_error: float) -> EdgeMaps:
    """The edge map: the board's, that of the board's G-buffer, or the host's own."""
    from quadshade.golden.screen.edge_map import edge_map
    from quadshade.style import EdgeMaps, draw_gbuffer, find_edges, sample_normals
    from quadshade.style.edges import VARIANTS
    from quadshade.style.gbuffer import background_normal, check_gbuffer, with_view_depth

    projected, formats = scene.projected, board.formats
    try:
        check_gbuffer(formats, choice.order)
    except QuadshadeError as reason:
        board.notice(f"edges drawn by the host, as the board can draw no G-buffer: {reason.message}")
        return find_edges(
            draw_gbuffer(projected, Formats(), "model", choice.order, choice.space)[0], choice.variant
        )
    placed, _ = with_view_depth(projected, formats)
    board.clear(tuple(background_normal(projected.axes, choice.space).tolist()))
    board.draw(sample_normals(placed, choice.order, choice.space, formats), pack_error)
    plane, size = f"edges_{choice.variant}", (projected.width, projected.height)
    if board.has_plane(plane):
        read = board.read_plane(plane, *size, verify)
        return EdgeMaps(read[..., 0], read[..., 1], choice.variant)
    board.notice("edges found by the host in the board's G-buffer, as the board has no edge map")
    normal, depth = board.read_plane("colour", *size, verify), board.read_depth(*size, verify)
    maps = edge_map(normal, depth.astype(np.int64), formats.depth_bits, VARIANTS[choice.variant])
    return EdgeMaps(*maps, choice.variant)
