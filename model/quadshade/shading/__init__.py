# SPDX-License-Identifier: Apache-2.0
"""Lights, materials, six-point sampling and the float references."""

from quadshade.choices import SHADING_ORDERS, SPECULAR_ORDERS
from quadshade.shading.lights import (
    DEFAULT_LIGHTS,
    AmbientLight,
    DirectionalLight,
    Light,
    PointLight,
    default_lights,
    parse_light,
)
from quadshade.shading.material import Material, load_reflectance, parse_material
from quadshade.shading.sample import sample
from quadshade.shading.specular import (
    UnsuitedError,
    sample_specular,
    specular_formats,
)
from quadshade.shading.toon import toon_curves

__all__ = [
    "DEFAULT_LIGHTS",
    "SHADING_ORDERS",
    "SPECULAR_ORDERS",
    "AmbientLight",
    "DirectionalLight",
    "Light",
    "Material",
    "PointLight",
    "UnsuitedError",
    "default_lights",
    "load_reflectance",
    "parse_light",
    "parse_material",
    "sample",
    "sample_specular",
    "specular_formats",
    "toon_curves",
]
