# SPDX-License-Identifier: Apache-2.0
"""
What a surface reflects: Phong's or Blinn's specular term, or a function of the user's.

``--material`` takes ``colour``, ``diffuse``, ``ambient`` and ``specular`` (one number or three),
``exponent=n`` and ``model=phong`` or ``model=blinn``; and the terms of Phong's equation 3: ``d=`` and
``w=`` (a constant, or a table over the incident angle) or ``fresnel=index`` (W as Fresnel's curve).
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.key_values import WORD, parse_settings
from quadshade.shading.incidence import LARGEST_TABLE, Incidence, fresnel_curve, table_curve
from quadshade.shading.lights import AmbientLight, Light, triple

Reflectance = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
MODELS = ("phong", "blinn")
MATERIAL_KEYS = {name: (1, 3) for name in ("colour", "diffuse", "ambient", "specular")} | {
    "exponent": (1,),
    "model": (WORD,),
    "d": (1,),
    "w": tuple(range(1, LARGEST_TABLE + 1)),
    "fresnel": (1,),
}


@dataclass(frozen=True)
class Material:
    """
    A surface's reflection.

    Attributes
    ----------
    colour : 3 floats
      Base colour, of the diffuse and ambient terms; a mesh's own colours take its place.
    diffuse, ambient, specular : 3 floats
      Factors of the three terms; by default their sum is at most 1, so that one white light cannot overflow.
    exponent : float
      Specular exponent, at least 0.
    model : str
      ``blinn`` (half vector) or ``phong`` (reflection vector; its highlight is as narrow as Blinn's at four
      times the exponent).
    reflectance : callable, optional
      (point, normal, to_light, to_viewer), all (m, 3) float64 and unit length but the point, to the share of
      the light that is reflected to the viewer, (m, 3) RGB, its cosine included. Takes the place of the
      diffuse and the specular term.
    incidence : callable, optional
      W(i) of Phong's equation 3: the cosine of the incident angle, (m,) float64 above 0, to the share of the
      light that is reflected specularly there, (m,). A factor of the specular term; without it W is 1.
    """

    colour: tuple[float, float, float] = (0.35, 0.60, 0.95)
    diffuse: tuple[float, float, float] = (0.60, 0.60, 0.60)
    ambient: tuple[float, float, float] = (0.08, 0.08, 0.08)
    specular: tuple[float, float, float] = (0.35, 0.35, 0.35)
    exponent: float = 20.0
    model: str = "blinn"
    reflectance: Reflectance | None = None
    incidence: Incidence | None = None

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise QuadshadeError(f"the material's model is {self.model!r}", f"give {' or '.join(MODELS)}")
        if not 0 <= self.exponent <= 1e6:
            raise QuadshadeError(f"the specular exponent is {self.exponent}", "give 0 to 1000000")
        if not all(0 <= part <= 1 for part in self.colour):
            colour = ",".join(f"{part:g}" for part in self.colour)
            raise QuadshadeError(f"the material's colour is {colour}", "give numbers from 0 to 1")

    def reflect(
        self,
        lights: Sequence[Light],
        point: np.ndarray,
        normal: np.ndarray,
        to_viewer: np.ndarray,
        base: np.ndarray | None = None,
    ) -> np.ndarray:
        """
        Light that leaves points towards the viewer (Phong, "Illumination for Computer Generated Pictures").

        Parameters
        ----------
        lights : sequence of lights
        point, normal : (m, 3) float
          The normals are unit length.
        to_viewer : (3,) or (m, 3) float
          Unit length.
        base : (m, 3) float, optional
          Base colour of each point instead of ``colour``.

        Returns
        -------
        (m, 3) float64
          1 is full intensity; not clamped.

        Raises
        ------
        QuadshadeError
          A user's reflectance that fails, or returns another shape or what is not finite.
        """
        base = np.asarray(self.colour) if base is None else base
        total = np.zeros_like(normal)
        toward = dot(normal, to_viewer)
        for light in lights:
            colour = np.asarray(light.colour)
            if isinstance(light, AmbientLight):
                total += colour * np.asarray(self.ambient) * base
                continue
            to_light, intensity = light.reach(point)
            if self.reflectance is not None:
                share = self._user_share(point, normal, to_light, to_viewer)
                total += share * colour * np.broadcast_to(intensity, toward.shape)[:, None]
                continue
            facing = dot(normal, to_light)
            diffuse = np.maximum(facing, 0) * intensity
            total += diffuse[:, None] * (colour * np.asarray(self.diffuse) * base)
            specular = self._specular(facing, toward, dot(to_light, to_viewer)) * intensity
            total += specular[:, None] * (colour * np.asarray(self.specular))
        return total

    def specular_cosine(self, facing: np.ndarray, toward: np.ndarray, between: np.ndarray) -> np.ndarray:
        """
        What is raised to the exponent: N.H (Blinn), or R.V (Phong).

        Parameters
        ----------
        facing, toward, between : (m,) or () float
          Cosines normal-light, normal-viewer and light-viewer.

        Returns
        -------
        (m,) float64
        """
        if self.model == "phong":
            return 2 * facing * toward - between
        return (facing + toward) / np.sqrt(np.maximum(2 + 2 * between, 1e-30))

    def _specular(self, facing: np.ndarray, toward: np.ndarray, between: np.ndarray) -> np.ndarray:
        """(m,) specular term from the cosines normal-light, normal-viewer and light-viewer."""
        cosine = self.specular_cosine(facing, toward, between)
        lit = np.flatnonzero((facing > 0) & (cosine > 0))
        out = np.zeros(len(facing))
        out[lit] = np.minimum(cosine[lit], 1.0) ** self.exponent
        if self.incidence is not None:
            out[lit] *= self.incidence(np.minimum(facing[lit], 1.0))
        return out

    def _user_share(
        self, point: np.ndarray, normal: np.ndarray, to_light: np.ndarray, to_viewer: np.ndarray
    ) -> np.ndarray:
        """What the user's function returns, checked."""
        assert self.reflectance is not None
        name = getattr(self.reflectance, "__name__", "reflectance")
        vectors = (np.broadcast_to(vector, normal.shape) for vector in (to_light, to_viewer))
        try:
            given = np.asarray(self.reflectance(point, normal, *vectors))
            if np.iscomplexobj(given):
                raise TypeError("complex numbers returned")
            share = given.astype(np.float64)
        except (Exception, SystemExit) as error:  # the user's function may raise anything
            raise QuadshadeError(
                f"reflectance {name} failed: {type(error).__name__}: {error}",
                "it is called with four arrays (n, 3): point, normal, to_light and to_viewer",
            ) from error
        if share.shape != normal.shape:
            raise QuadshadeError(f"reflectance {name} returned shape {share.shape}", f"return {normal.shape}")
        if not np.isfinite(share).all():
            raise QuadshadeError(f"reflectance {name} returned a value that is not finite")
        return share


PICTURE_MATERIAL = replace(Material(), diffuse=(0.7,) * 3, ambient=(0.3,) * 3, specular=(0.2,) * 3)
"""
What a picture's material starts from where the user says nothing: a part of a colour has that colour, and its
unlit sides stand out from a black background. The reports' material, ``Material()``, has a stronger
highlight.
"""


def dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Scalar products of (m, 3) with (3,) or (m, 3) vectors, or of two (3,)."""
    if first.ndim == second.ndim:
        return np.einsum("...i,...i->...", first, second)
    return first @ second if first.ndim > second.ndim else second @ first


def parse_material(
    text: str, exponent: float | None = None, reflectance: Reflectance | None = None
) -> Material:
    """
    The material that ``--material``, ``--exponent`` and ``--reflectance`` describe.

    Parameters
    ----------
    text : str
      For example ``colour=0.8,0.2,0.1,specular=0.4,model=blinn``, or empty.
    exponent : float, optional
    reflectance : callable, optional

    Returns
    -------
    Material

    Raises
    ------
    QuadshadeError
      A malformed description, an exponent given twice, or terms that exclude each other.
    """
    settings: dict[str, Any] = dict(parse_settings(text, "material", MATERIAL_KEYS)) if text.strip() else {}
    if exponent is not None and "exponent" in settings:
        raise QuadshadeError("the exponent is given twice", "give --exponent or the material's exponent")
    changes: dict[str, Any] = {
        name: triple(settings[name], f"material's {name}")
        for name in ("colour", "diffuse", "ambient", "specular")
        if name in settings
    }
    if "model" in settings:
        changes["model"] = settings["model"]
    if "exponent" in settings:
        changes["exponent"] = settings["exponent"][0]
    if exponent is not None:
        changes["exponent"] = exponent
    changes |= _phong_terms(settings)
    return replace(PICTURE_MATERIAL, reflectance=reflectance, **changes)


def _phong_terms(settings: dict[str, Any]) -> dict[str, Any]:
    """
    ``d`` and ``W(i)`` of Phong's equation 3, S = C [cos(i) (1 - d) + d] + W(i) cos(s)^n, as fields.

    With ``d`` the diffuse factor is 1 - d and the ambient one d; W is a factor of white's specular share.
    """
    terms: dict[str, Any] = {}
    if "d" in settings:
        (d,) = settings["d"]
        if {"diffuse", "ambient"} & settings.keys():
            raise QuadshadeError("the material has d and a diffuse or ambient factor", "give d, or these two")
        if not 0 <= d <= 1:
            raise QuadshadeError(f"the material's d is {d:g}", "give 0 to 1")
        terms |= {"diffuse": (1 - d,) * 3, "ambient": (d,) * 3}
    curves = {"w", "fresnel"} & settings.keys()
    if not curves:
        return terms
    if len(curves) == 2 or "specular" in settings:
        raise QuadshadeError("the material has W twice", "give one of w, fresnel and specular")
    if "w" in settings and len(settings["w"]) == 1:
        return terms | {"specular": triple(settings["w"], "material's w")}
    curve = fresnel_curve(settings["fresnel"][0]) if "fresnel" in settings else table_curve(settings["w"])
    return terms | {"specular": (1.0, 1.0, 1.0), "incidence": curve}


def load_reflectance(text: str) -> Reflectance:
    """
    The user's function that ``--reflectance module:function`` names.

    Parameters
    ----------
    text : str
      An importable module, or a path of a Python file, then a colon and the function's name.

    Returns
    -------
    callable

    Raises
    ------
    QuadshadeError
      No such module or function, or a module that fails.
    """
    module_name, colon, function_name = text.rpartition(":")
    if not colon or not module_name or not function_name:
        raise QuadshadeError(
            f"--reflectance {text!r} is not module:function", "write for example my_brdf.py:cloth"
        )
    try:
        module = (
            _load_file(Path(module_name))
            if module_name.endswith(".py")
            else importlib.import_module(module_name)
        )
        function = getattr(module, function_name)
    except (Exception, SystemExit) as error:  # a user's module may raise anything
        reason = " ".join(str(error).split())
        raise QuadshadeError(
            f"cannot load {text}: {type(error).__name__}: {reason}", "check the module"
        ) from error
    if not callable(function):
        raise QuadshadeError(
            f"{text} is not a function", "name a callable of point, normal, to_light, to_viewer"
        )
    return function


def _load_file(path: Path) -> object:
    """A module from a Python file."""
    from importlib.util import module_from_spec, spec_from_file_location

    spec = spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise QuadshadeError(f"{path} is not a Python file", "give a file whose name ends in .py")
    module = module_from_spec(spec)
    sys.modules.setdefault(path.stem, module)
    spec.loader.exec_module(module)
    return module
