# SPDX-License-Identifier: Apache-2.0
"""
Mesh to picture as a library: what ``quadshade.render`` and the command line call.

``face`` has the keywords, of which ``settings`` are made (in ``groups``); ``shade`` looks at a scene and
shades it, ``draw`` lets an engine draw it and ``board`` a board; ``picture`` is what comes out. ``pack``
stops before the board.
"""

from quadshade.rendering.draw import draw_triangles, render_picture
from quadshade.rendering.groups import (
    AdaptChoice,
    EngineChoice,
    PortChoice,
    SceneChoice,
    SetupChoice,
    StyleChoice,
)
from quadshade.rendering.picture import Picture, Stats
from quadshade.rendering.settings import RenderSettings, Reports

__all__ = [
    "AdaptChoice",
    "EngineChoice",
    "Picture",
    "PortChoice",
    "RenderSettings",
    "Reports",
    "SceneChoice",
    "SetupChoice",
    "Stats",
    "StyleChoice",
    "draw_triangles",
    "render_picture",
]
