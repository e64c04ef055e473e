# SPDX-License-Identifier: Apache-2.0
"""Scenes that move: poses, frames, and the file that shows them."""

from quadshade.animation.animate import Animation
from quadshade.animation.motion import Motion, Pose
from quadshade.animation.record import FrameRow

__all__ = ["Animation", "FrameRow", "Motion", "Pose"]
