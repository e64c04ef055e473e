# SPDX-License-Identifier: Apache-2.0
"""
Where the scene is seen from.

``--camera`` takes ``key=value`` pairs: ``eye=x,y,z`` or ``from=x,y,z`` (a direction; the distance is fitted),
``target=x,y,z``, ``up=x,y,z``, ``fov=degrees`` (perspective) or ``ortho=height/2`` (orthographic) and
``near=distance``. What is left out is fitted to the scene.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.key_values import LARGEST, parse_settings
from quadshade.scene.mesh import Mesh

DEFAULT_FOV = 20.0
"""Degrees, the smaller of the picture's two angles."""

FIT_MARGIN = 1.05
"""The scene's bounding sphere, grown by this, touches the picture's border."""

DEFAULT_FROM = (0.7, 0.65, 1.0)
"""Where a picture is seen from if its user does not say: three quarters, from above."""

CAMERA_KEYS = {
    "eye": (3,),
    "from": (3,),
    "target": (3,),
    "up": (3,),
    "fov": (1,),
    "ortho": (1,),
    "near": (1,),
}


@dataclass(frozen=True)
class Camera:
    """
    A look-at camera.

    Attributes
    ----------
    eye, target, up : (3,) float64
      Scene units; ``up`` need not be at right angles to the view.
    fov : float or None
      Perspective: the angle in degrees that the smaller side of the picture shows.
    ortho : float or None
      Orthographic: half of what the smaller side of the picture shows, in scene units.
    near : float or None
      Distance along the view before which nothing is drawn; None: fitted to the scene.
    """

    eye: np.ndarray
    target: np.ndarray
    up: np.ndarray
    fov: float | None = DEFAULT_FOV
    ortho: float | None = None
    near: float | None = None

    def __post_init__(self) -> None:
        if (self.fov is None) == (self.ortho is None):
            raise QuadshadeError("a camera has either fov or ortho", "give one of the two")
        if self.fov is not None and not 0.01 <= self.fov <= 179:
            raise QuadshadeError(f"the camera's fov is {self.fov}", "give 0.01 to 179 degrees")
        if self.ortho is not None and not self.ortho >= 1 / LARGEST:
            raise QuadshadeError(
                f"the camera's ortho is {self.ortho}", "give half the visible height, above 0"
            )
        if self.near is not None and not self.near > 0 and self.ortho is None:
            raise QuadshadeError(f"the camera's near is {self.near}", "give a distance above 0")
        if not np.linalg.norm(np.subtract(self.target, self.eye)) > 0:
            raise QuadshadeError("the camera's eye and target are one point", "move one of them")

    @property
    def axes(self) -> np.ndarray:
        """
        Right, up and backward: the rows of the rotation from the scene to the camera.

        Returns
        -------
        (3, 3) float64

        Raises
        ------
        QuadshadeError
          ``up`` points along the view.
        """
        back = np.subtract(self.eye, self.target)
        back = back / np.linalg.norm(back)
        right = np.cross(self.up, back)
        length = np.linalg.norm(right)
        if not length > 1e-9 * np.linalg.norm(self.up):
            raise QuadshadeError("the camera's up points along the view", "give another up, e.g. up=0,0,1")
        right = right / length
        return np.stack([right, np.cross(back, right), back])


def fit_camera(
    mesh: Mesh,
    eye: np.ndarray | None = None,
    direction: np.ndarray | None = None,
    target: np.ndarray | None = None,
    up: np.ndarray | None = None,
    fov: float | None = None,
    ortho: float | None = None,
    near: float | None = None,
) -> Camera:
    """
    A camera that shows the whole mesh, as far as it is not given otherwise.

    Parameters
    ----------
    mesh : Mesh
    eye, direction : (3,) float, optional
      Where to look from, or only the direction from the target to there; by default from +z.
    target : (3,) float, optional
      By default the middle of the mesh.
    up : (3,) float, optional
      By default +y, or -z where the view is along y.
    fov, ortho, near : float, optional
      As in :class:`Camera`; by default perspective with 20 degrees.

    Returns
    -------
    Camera

    Raises
    ------
    QuadshadeError
      Settings that contradict each other or are out of range.
    """
    if eye is not None and direction is not None:
        raise QuadshadeError("the camera has both eye and from", "give one of the two")
    if ortho is None and fov is None:
        fov = DEFAULT_FOV
    centre, radius = mesh.bounds
    radius = (radius or 1.0) * FIT_MARGIN
    target = centre if target is None else np.asarray(target, dtype=np.float64)
    if eye is None:
        direction = (
            np.array([0.0, 0.0, 1.0]) if direction is None else np.asarray(direction, dtype=np.float64)
        )
        length = np.linalg.norm(direction)
        if not length > 0:
            raise QuadshadeError("the camera's from is 0,0,0", "give a direction")
        distance = 4 * radius if fov is None else radius / np.sin(np.radians(np.clip(fov, 0.01, 179) / 2))
        eye = target + direction / length * distance
    view = np.subtract(target, eye)
    if up is None:
        along_y = np.abs(view[1]) > 0.999 * np.linalg.norm(view)
        up = np.array([0.0, 0.0, -1.0]) if along_y else np.array([0.0, 1.0, 0.0])
    return Camera(
        np.asarray(eye, dtype=np.float64), target, np.asarray(up, dtype=np.float64), fov, ortho, near
    )


def parse_camera(text: str, mesh: Mesh) -> Camera:
    """
    The camera that ``--camera`` describes.

    Parameters
    ----------
    text : str
      For example ``eye=0,0,3,target=0,0,0,up=0,1,0,fov=40``, ``from=1,1,2,ortho=1.2`` or the empty string.
    mesh : Mesh
      What is left out is fitted to it; without an eye and a direction it is seen from ``DEFAULT_FROM``.

    Returns
    -------
    Camera

    Raises
    ------
    QuadshadeError
      A description that is malformed, contradicts itself or is out of range.
    """
    settings = parse_settings(text, "camera", CAMERA_KEYS) if text.strip() else {}
    vectors = {key: np.array(settings[key]) for key in ("eye", "target", "up", "from") if key in settings}
    numbers = {key: float(settings[key][0]) for key in ("fov", "ortho", "near") if key in settings}
    if "eye" not in settings:
        vectors.setdefault("from", np.array(DEFAULT_FROM))
    return fit_camera(
        mesh,
        eye=vectors.get("eye"),
        target=vectors.get("target"),
        up=vectors.get("up"),
        fov=numbers.get("fov"),
        ortho=numbers.get("ortho"),
        near=numbers.get("near"),
        direction=vectors.get("from"),
    )
