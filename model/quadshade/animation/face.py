# SPDX-License-Identifier: Apache-2.0
"""The function of ``import quadshade`` that moves a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from quadshade.animation.animate import Animation
from quadshade.animation.motion import Motion
from quadshade.choices import AUTO
from quadshade.rendering.settings import RenderSettings, Reports

if TYPE_CHECKING:
    import trimesh

    from quadshade.scene import Mesh


def turn(
    scene: str | Path | Mesh | trimesh.Trimesh | trimesh.Scene,
    *,
    frames: int = 60,
    fps: float = 25.0,
    axis: str | Sequence[float] = "y",
    degrees: float | None = None,
    light_orbit: float | None = None,
    keyframes: str | Path | Sequence[Mapping[str, Any]] | None = None,
    frame_time: float | str | None = None,
    errors: bool = True,
    jobs: int = 1,
    reports: Reports | None = None,
    **render: Any,
) -> Animation:
    """
    Move a scene: what ``quadshade turn`` does, under the names of its options.

    Parameters
    ----------
    scene : str, Path, Mesh, trimesh.Trimesh or trimesh.Scene
      As for :func:`quadshade.render`.
    frames : int
    fps : float
      Frames a second.
    axis : str or 3 floats
      ``x``, ``y``, ``z`` or a direction, through the middle of the scene.
    degrees : float, optional
      By how much the object turns in all frames together; 360, or 0 where something else moves.
    light_orbit : float, optional
      By how much the lights turn about the same axis; 0.
    keyframes : str, Path or sequence of mappings, optional
      A JSON file or a list of key frames, such as ``{"frame": 0, "turn": 0, "fov": 20}``
      (``docs/guide/turn.md``).
    frame_time : float or str, optional
      Milliseconds in which a board has to have each frame, as of :func:`quadshade.render`; ``auto``: as long
      as it is shown.
    errors : bool
      Measure each frame against Phong shading.
    jobs : int
      Processes that draw frames.
    reports : Reports, optional
      As for :func:`quadshade.render`.
    **render
      Its other keywords.

    Returns
    -------
    Animation
      ``animation[3]`` is the picture of a frame, ``animation.save("turn.gif")`` draws and writes them all.

    Raises
    ------
    QuadshadeError
      What cannot be drawn as it is asked for: the message says what is wrong, the hint what to do.
    """
    motion = Motion(frames, fps, axis, degrees, light_orbit, keyframes)
    if isinstance(frame_time, str) and frame_time == AUTO:
        frame_time = 1000 / fps
    settings = RenderSettings.collect({"scene": scene, "frame_time": frame_time, **render})
    return Animation(settings, motion, errors, jobs, reports)
