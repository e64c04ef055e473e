# SPDX-License-Identifier: Apache-2.0
"""
Quadratic shading on small FPGAs, and a picture in one line.

    import quadshade

    quadshade.render("sphere:690", exponent=50).save("sphere.png")

``render`` draws a mesh with the golden model, the VHDL itself, or a board, and gives a ``Picture``; ``turn``
moves it and gives an ``Animation``; ``draw`` draws triangles that are on the screen already; ``load_scene``
reads a mesh; ``Board`` is a board; ``Formats`` are the generics of the core. Nothing of numba, scipy or an
engine is imported before it is needed.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from quadshade.errors import QuadshadeError

if TYPE_CHECKING:
    from quadshade.animation.animate import Animation as Animation
    from quadshade.animation.face import turn as turn
    from quadshade.board import Board as Board
    from quadshade.contract.formats import Formats as Formats
    from quadshade.rendering.face import draw as draw
    from quadshade.rendering.face import render as render
    from quadshade.rendering.picture import Picture as Picture
    from quadshade.scene import load_scene as load_scene

    __version__: str

_PLACES = {
    "Animation": "quadshade.animation.animate",
    "Board": "quadshade.board",
    "Formats": "quadshade.contract.formats",
    "Picture": "quadshade.rendering.picture",
    "draw": "quadshade.rendering.face",
    "load_scene": "quadshade.scene",
    "render": "quadshade.rendering.face",
    "turn": "quadshade.animation.face",
}
"""Where each public name is defined; it is imported from there when it is first asked for."""

__all__ = [
    "Animation",
    "Board",
    "Formats",
    "Picture",
    "QuadshadeError",
    "__version__",
    "draw",
    "load_scene",
    "render",
    "turn",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        value: Any = _version()
    elif name in _PLACES:
        value = getattr(import_module(_PLACES[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__


def _version() -> str:
    """Version of the installed package, which stands in ``pyproject.toml``."""
    from importlib import metadata

    try:
        return metadata.version("quadshade")
    except metadata.PackageNotFoundError:
        return "unknown, not installed"
