# SPDX-License-Identifier: Apache-2.0
"""Settings of one frame: the scene turned, its lights moved, its camera where the frame has it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from quadshade.animation.motion import Motion, Pose, rotation
from quadshade.contract.arrays import Floats
from quadshade.errors import QuadshadeError
from quadshade.rendering.settings import RenderSettings
from quadshade.scene import Camera, Mesh, parse_camera
from quadshade.scene.camera import CAMERA_KEYS
from quadshade.scene.key_values import parse_settings
from quadshade.scene.turned import Detail, Turn
from quadshade.shading import DirectionalLight, Light, PointLight, default_lights, parse_light


class Stage:
    """
    A scene that stands still, from which every frame is made.

    Parameters
    ----------
    settings : RenderSettings
    mesh : Mesh
      Its scene, read once.
    motion : Motion
    name : str or Path, optional
      The scene's.
    """

    def __init__(
        self, settings: RenderSettings, mesh: Mesh, motion: Motion, name: str | Path | None = None
    ) -> None:
        self._settings, self._mesh, self._motion = settings, mesh, motion
        self._detail = Detail(mesh, name)
        self._centre = mesh.bounds[0]
        self._camera = settings.scene.camera
        self._check()

    def _check(self) -> None:
        """Refuse what no frame can be, before the first one is drawn."""
        given = self._camera
        if not isinstance(given, str) and self._motion.pose(0).camera:
            raise QuadshadeError("the key frames move a camera that is an object", "give the camera as text")
        for frame in {0, self._motion.frames - 1}:
            self.frame(frame)

    def frame(self, number: int) -> RenderSettings:
        """Settings of a frame, counted from 0."""
        pose, scene = self._motion.pose(number), self._settings.scene
        camera = self._camera_at(pose)
        turned = Turn(rotation(self._motion.direction, pose.turn), self._centre, self._detail)
        lights = self._lights_at(pose, camera)
        exponent = scene.exponent if pose.exponent is None else pose.exponent
        return self._settings.of_scene(scene=turned, camera=camera, lights=lights, exponent=exponent)

    def _camera_at(self, pose: Pose) -> Camera:
        """The camera, fitted to the scene as it stood: an object that turns does not make it move."""
        if not isinstance(self._camera, str):
            return self._camera
        if not pose.camera:
            return parse_camera(self._camera, self._mesh)
        given = parse_settings(self._camera, "camera", CAMERA_KEYS) if self._camera.strip() else {}
        rivals = {"eye": "from", "from": "eye", "fov": "ortho", "ortho": "fov"}
        kept = {k: v for k, v in given.items() if k not in pose.camera and rivals.get(k) not in pose.camera}
        pairs = [*kept.items(), *pose.camera.items()]
        text = ",".join(f"{key}={','.join(map(repr, value))}" for key, value in pairs)
        return parse_camera(text, self._mesh)

    def _lights_at(self, pose: Pose, camera: Camera) -> Sequence[str | Light] | str | Light:
        """The lights, turned about the scene's middle; the default ones leave the viewer's side for that."""
        given = self._settings.scene.lights
        by = rotation(self._motion.direction, pose.light_orbit)
        if (by == np.eye(3)).all():
            return given
        texts = (given,) if isinstance(given, str) or not isinstance(given, Sequence) else given
        lights = [parse_light(one) if isinstance(one, str) else one for one in texts]
        return [self._light(light, by) for light in lights or default_lights(camera.axes)]

    def _light(self, light: Light, by: Floats) -> Light:
        """One light, turned; ambient light comes from everywhere."""
        if isinstance(light, DirectionalLight):
            x, y, z = (float(part) for part in by @ np.asarray(light.direction, dtype=np.float64))
            return replace(light, direction=(x, y, z))
        if isinstance(light, PointLight):
            place = by @ (np.asarray(light.position) - self._centre) + self._centre
            x, y, z = (float(part) for part in place)
            return replace(light, position=(x, y, z))
        return light
