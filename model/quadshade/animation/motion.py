# SPDX-License-Identifier: Apache-2.0
"""How a scene moves: what is where in each frame of an animation."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from quadshade.contract.arrays import Floats
from quadshade.errors import QuadshadeError

FULL_TURN = 360.0
MOST_FRAMES = 100_000
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
ANGLES = ("turn", "light_orbit")
CAMERA_VECTORS = ("eye", "from", "target", "up")
CAMERA_NUMBERS = ("fov", "ortho")
KEYED = {name: 1 for name in (*ANGLES, *CAMERA_NUMBERS, "exponent")} | dict.fromkeys(CAMERA_VECTORS, 3)
"""What a key frame may set, and how many numbers it takes."""


@dataclass(frozen=True)
class Pose:
    """
    One frame's state.

    Attributes
    ----------
    turn, light_orbit : float
      Degrees that the object, and its lights, have turned about the axis.
    camera : mapping of str to tuple of float
      Keys of ``--camera`` that the frame sets.
    exponent : float or None
      Specular exponent; None: as it is asked for.
    """

    turn: float
    light_orbit: float
    camera: Mapping[str, tuple[float, ...]]
    exponent: float | None


@dataclass(frozen=True)
class Motion:
    """
    How a scene moves from frame to frame.

    Attributes
    ----------
    frames : int
    fps : float
      Frames a second that the file is played with.
    axis : str or 3 floats
      ``x``, ``y``, ``z`` or a direction, through the middle of the scene.
    degrees : float, optional
      By how much the object turns in all frames together. 360; 0 where only the lights or key frames move.
    light_orbit : float, optional
      By how much the lights do; 0.
    keyframes : str, Path or sequence of mappings, optional
      A JSON file with a list of key frames, or the list: each a ``frame`` and what is set there (``KEYED``);
      between two of them it changes evenly.
    """

    frames: int = 60
    fps: float = 25.0
    axis: str | Sequence[float] = "y"
    degrees: float | None = None
    light_orbit: float | None = None
    keyframes: str | Path | Sequence[Mapping[str, Any]] | None = None
    _tracks: dict[str, tuple[Floats, Floats]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not 1 <= self.frames <= MOST_FRAMES:
            raise QuadshadeError(f"the number of frames is {self.frames}", f"give 1 to {MOST_FRAMES}")
        if not 0.01 <= self.fps <= 1000:
            raise QuadshadeError(f"the fps are {self.fps:g}", "give 0.01 to 1000 frames a second")
        for name, value in (("--turn", self.degrees), ("--light-orbit", self.light_orbit)):
            if value is not None and not abs(value) <= 1e6:
                raise QuadshadeError(f"{name} is {value:g}", "give degrees, up to 1000000")
        _ = self.direction
        object.__setattr__(self, "_tracks", _tracks(self.keyframes, self.frames))
        for name, value in (("turn", self.degrees), ("light_orbit", self.light_orbit)):
            if value is not None and name in self._tracks:
                option = f"--{name.replace('_', '-')}"
                raise QuadshadeError(
                    f"{option} is given, and the key frames set {name}", "leave one of them out"
                )

    @property
    def direction(self) -> Floats:
        """(3,) float64 unit vector along the axis."""
        given = self.axis
        try:
            if isinstance(given, str):
                numbers = AXES.get(given) or tuple(float(part) for part in given.split(","))
            else:
                numbers = tuple(float(part) for part in given)
            vector = np.array(numbers)
            length = float(np.linalg.norm(vector))
        except (TypeError, ValueError):
            vector, length = np.zeros(0), 0.0
        if vector.shape != (3,) or not 0 < length < math.inf:
            raise QuadshadeError(f"the axis is {given!r}", "give x, y, z or a direction such as 1,1,0")
        return vector / length

    def pose(self, frame: int) -> Pose:
        """The state of a frame, counted from 0; the first one is the scene as it stands."""
        at = {name: self._at(name, frame) for name in self._tracks}
        moving = self.light_orbit is not None or bool(self._tracks)
        degrees = self.degrees if self.degrees is not None else (0.0 if moving else FULL_TURN)
        share = frame / self.frames
        turn = at["turn"][0] if "turn" in at else degrees * share
        orbit = at["light_orbit"][0] if "light_orbit" in at else (self.light_orbit or 0.0) * share
        exponent = at["exponent"][0] if "exponent" in at else None
        camera = {name: at[name] for name in (*CAMERA_VECTORS, *CAMERA_NUMBERS) if name in at}
        return Pose(turn, orbit, camera, exponent)

    def _at(self, name: str, frame: int) -> tuple[float, ...]:
        """A keyed value at a frame."""
        frames, values = self._tracks[name]
        return tuple(float(np.interp(frame, frames, column)) for column in values.T)

    def content(self) -> dict[str, Any]:
        """All that the poses depend on, for JSON."""
        tracks = {name: [one.tolist() for one in track] for name, track in self._tracks.items()}
        poses = {"degrees": self.degrees, "light_orbit": self.light_orbit, "tracks": tracks}
        return poses | {"frames": self.frames, "axis": self.direction.tolist()}


def rotation(direction: Floats, degrees: float) -> Floats:
    """
    Right-handed rotation about an axis (Rodrigues' formula).

    Parameters
    ----------
    direction : (3,) float64
      Unit vector.
    degrees : float

    Returns
    -------
    (3, 3) float64
      To be multiplied from the left with a column; exactly the identity for a whole number of turns.
    """
    radians = math.radians(math.remainder(degrees, FULL_TURN))
    x, y, z = direction
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(radians) * cross + (1 - math.cos(radians)) * (cross @ cross)


def _tracks(
    given: str | Path | Sequence[Mapping[str, Any]] | None, frames: int
) -> dict[str, tuple[Floats, Floats]]:
    """Of every keyed name its frames, (k,), and values, (k, numbers)."""
    if given is None:
        return {}
    where = str(given) if isinstance(given, str | Path) else "keyframes"
    content = _read(Path(given)) if isinstance(given, str | Path) else given
    if not isinstance(content, Sequence) or isinstance(content, str) or not content:
        raise QuadshadeError(f"{where} is not a list of key frames", 'write [{"frame": 0, "turn": 0}, ...]')
    rows: dict[str, list[tuple[float, Floats]]] = {}
    before = -1
    for number, key in enumerate(content):
        place = f"{where}, key frame {number}"
        if not isinstance(key, Mapping):
            raise QuadshadeError(f"{place} is no object", 'write {"frame": 0, "turn": 0}')
        frame = key.get("frame")
        if not isinstance(frame, int) or isinstance(frame, bool) or not before < frame < frames:
            raise QuadshadeError(
                f"{place} has the frame {frame!r}", f"give rising whole numbers from 0 to {frames - 1}"
            )
        before = frame
        for name, value in key.items():
            if name != "frame":
                rows.setdefault(name, []).append((frame, _numbers(name, value, place)))
    if "eye" in rows and "from" in rows:
        raise QuadshadeError(f"{where} sets both eye and from", "set one of the two")
    return {
        name: (np.array([frame for frame, _ in track], dtype=float), np.array([value for _, value in track]))
        for name, track in rows.items()
    }


def _read(path: Path) -> Any:
    """What a JSON file holds; a list may stand under "keyframes"."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise QuadshadeError(f"cannot read {path}: {error.strerror or error}", "give a JSON file") from None
    except (ValueError, RecursionError) as error:
        raise QuadshadeError(f"{path} is not JSON: {error}", 'write [{"frame": 0, "turn": 0}, ...]') from None
    return content.get("keyframes") if isinstance(content, dict) else content


def _numbers(name: str, value: Any, place: str) -> Floats:
    """A key frame's value as (1,) or (3,) float64."""
    if name not in KEYED:
        raise QuadshadeError(f"{place} has an unknown key {name!r}", f"it takes frame, {', '.join(KEYED)}")
    row = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
    numeric = all(isinstance(one, int | float) and not isinstance(one, bool) for one in row)
    if not numeric or len(row) != KEYED[name] or not all(abs(one) <= 1e9 for one in row):
        raise QuadshadeError(f"{place} has {name} {value!r}", f"give {KEYED[name]} finite numbers")
    return np.array(row, dtype=np.float64)
