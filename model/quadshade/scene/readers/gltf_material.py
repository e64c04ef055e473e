# SPDX-License-Identifier: Apache-2.0
"""Materials of glTF 2.0: base colour as a factor, a texture and the colours of vertices, multiplied."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from quadshade.errors import QuadshadeError
from quadshade.scene.readers.gltf_file import GltfFile, Item
from quadshade.scene.readers.part import check_colours
from quadshade.scene.readers.texture import CLAMP, MIRROR, REPEAT, Texture, read_texels

WRAPS = {10497: REPEAT, 33071: CLAMP, 33648: MIRROR}
LINEAR, NEAREST = 9729, 9728


@dataclass(frozen=True)
class Material:
    """
    What of a material is drawn.

    Attributes
    ----------
    factor : (3,) float64
    texture : Texture or None
    texture_set : int
      Which texture coordinates it takes.
    moved : (2, 3) float64
      Maps texture coordinates (u, v, 1) to the texture.
    double_sided, transparent : bool
    """

    factor: np.ndarray
    texture: Texture | None
    texture_set: int
    moved: np.ndarray
    double_sided: bool
    transparent: bool

    def colours(
        self, faces: np.ndarray, places: Callable[[int], np.ndarray], own: np.ndarray | None
    ) -> np.ndarray:
        """
        (n, 3, 3) colours at faces' corners.

        Parameters
        ----------
        faces : (n, 3) int
        places : callable
          (m, 2) texture coordinates of a set's number.
        own : (m, 3) float64, optional
          The vertices' own colours.
        """
        colours = np.broadcast_to(self.factor, (*faces.shape, 3))
        if self.texture is not None:
            at = places(self.texture_set)[faces]
            at = at @ self.moved[:, :2].T + self.moved[:, 2]
            colours = colours * self.texture.at_corners(at)[..., :3]
        return colours if own is None else colours * own[faces]


def read_material(file: GltfFile, index: int) -> Material:
    """
    A material.

    Raises
    ------
    QuadshadeError
      A factor outside 0 .. 1, or a texture that cannot be read.
    """
    item = file.pick("materials", index)
    glossy = item.extension("KHR_materials_pbrSpecularGlossiness")
    if glossy is not None:
        factor = glossy.numbers("diffuseFactor", (1.0, 1.0, 1.0, 1.0))
        source, key = glossy, "diffuseTexture"
    else:
        source, key = item.item("pbrMetallicRoughness"), "baseColorTexture"
        factor = source.numbers("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
    check_colours(np.array(factor), f"its {item.name} has a base colour")
    texture, texture_set, moved = None, 0, np.eye(2, 3)
    if key in source:
        info = source.item(key)
        texture = _read_texture(file, info.whole("index"))
        texture_set = info.whole("texCoord", 0)
        transform = info.extension("KHR_texture_transform")
        if transform is not None:
            moved = _moved(transform)
            texture_set = transform.whole("texCoord", texture_set)
    transparent = item.text("alphaMode", "OPAQUE") != "OPAQUE"
    return Material(np.array(factor[:3]), texture, texture_set, moved, item.flag("doubleSided"), transparent)


def _moved(transform: Item) -> np.ndarray:
    """(2, 3) map of KHR_texture_transform: scale, then turn, then move."""
    angle = transform.number("rotation", 0.0)
    across, down = transform.numbers("scale", (1.0, 1.0))
    offset = transform.numbers("offset", (0.0, 0.0))
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine * across, sine * down, offset[0]], [-sine * across, cosine * down, offset[1]]])


def _read_texture(file: GltfFile, index: int) -> Texture:
    """A texture with its sampler."""
    item = file.pick("textures", index)
    webp = item.extension("EXT_texture_webp")
    source = item if webp is None or "source" in item else webp
    if "source" not in source:
        names = ", ".join(item.item("extensions").keys()) or "no source"
        raise QuadshadeError(
            f"its {item.name} has {names}, which is not read", "save it with PNG or JPEG textures"
        )
    image = file.pick("images", source.whole("source"))
    name = image.text("uri", "")
    if "bufferView" in image:
        data = file.view(image.whole("bufferView"))[0]
    elif name:
        data = file.content(name)
    else:
        raise QuadshadeError(f"its {image.name} has no content", "repair the mesh")
    texels = read_texels(data, image.name if name.startswith("data:") or not name else name)
    if "sampler" not in item:
        return Texture(texels)
    sampler = file.pick("samplers", item.whole("sampler"))
    wraps = sampler.whole("wrapS", 10497), sampler.whole("wrapT", 10497)
    if not all(wrap in WRAPS for wrap in wraps):
        raise QuadshadeError(f"its {sampler.name} wraps as {wraps}", "repair the mesh")
    linear = sampler.whole("magFilter", NEAREST) == LINEAR
    return Texture(texels, (WRAPS[wraps[0]], WRAPS[wraps[1]]), linear)
