# SPDX-License-Identifier: Apache-2.0
"""Cases of glTF and GLB."""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.support.mesh_cases import BLUE, GIVEN, GREEN, RED, WHITE, Case, Colour, Gltf, png

FLAG = png(RED, GREEN, BLUE, WHITE)
TRIANGLE = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def _case(
    name: str,
    build: Callable[[Gltf], Any],
    lit: dict[Colour, int] | None = None,
    refused: str = "",
    note: str = "",
    camera: str = "",
) -> Case:
    """A GLB that a function builds."""
    gltf = Gltf()
    build(gltf)
    case = Case(f"{name}.glb", lit, gltf.glb(), {}, refused, note, given=GIVEN)
    return case if not camera else Case(f"{name}.glb", lit, gltf.glb(), {}, refused, note, camera, GIVEN)


def _two_faces(gltf: Gltf, double_sided: bool) -> None:
    """A triangle that is seen from behind."""
    gltf.primitive(TRIANGLE[::-1], material=gltf.material(factor=[1, 0, 0, 1], doubleSided=double_sided))
    gltf.primitive([(x + 1, y, z) for x, y, z in TRIANGLE], material=gltf.material(factor=[0, 0, 1, 1]))


def _textured(
    gltf: Gltf, places: list, sampler: dict | None = None, info: dict | None = None, **more: Any
) -> None:
    """A textured triangle."""
    texture = {"index": gltf.texture(FLAG, sampler)} | (info or {})
    primitive = gltf.primitive(TRIANGLE, material=gltf.material(texture, **more))
    primitive["attributes"]["TEXCOORD_0"] = gltf.accessor(places)


def _coloured(gltf: Gltf, colours: list, dtype: str = "f4", material: bool = False, **more: Any) -> None:
    """A triangle with COLOR_0."""
    primitive = gltf.primitive()
    primitive["attributes"]["COLOR_0"] = gltf.accessor([colours] * 3, dtype, **more)
    if material:
        primitive["material"] = gltf.material(factor=[1, 0.6, 0.2, 1])


def _indexed(gltf: Gltf, indices: list[int], dtype: str, mode: int = 4) -> None:
    """A square with indices."""
    gltf.primitive(SQUARE, mode=mode)["indices"] = gltf.accessor(indices, dtype)


def _strided(gltf: Gltf) -> None:
    """Positions and colours in one buffer view."""
    rows = np.zeros(3, [("p", "<f4", 3), ("c", "u1", 4)])
    rows["p"], rows["c"] = TRIANGLE, (0, 0, 255, 255)
    view = gltf.view(rows.tobytes(), byteStride=16)
    shared = {"bufferView": view, "count": 3}
    gltf.root["accessors"] += [
        shared | {"componentType": 5126, "type": "VEC3"},
        shared | {"componentType": 5121, "type": "VEC4", "byteOffset": 12, "normalized": True},
    ]
    gltf.root["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0, "COLOR_0": 1}}]


def _nodes(gltf: Gltf, *nodes: dict, first: tuple[int, ...] = (0,)) -> None:
    """A triangle placed by nodes."""
    gltf.primitive()
    gltf.root["nodes"], gltf.root["scenes"] = list(nodes), [{"nodes": list(first)}]


def _sparse_alone(gltf: Gltf) -> None:
    """An accessor without a buffer view: zeros, but for sparse rows."""
    rows = gltf.view(np.array([1, 2], "u1").tobytes())
    values = gltf.view(np.array(TRIANGLE[1:], "<f4").tobytes())
    sparse = {
        "count": 2,
        "indices": {"bufferView": rows, "componentType": 5121},
        "values": {"bufferView": values},
    }
    gltf.root["accessors"].append({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse})
    gltf.root["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0}}]


def _morphed(gltf: Gltf, weight: float) -> None:
    """A target that moves the triangle by two units."""
    primitive = gltf.primitive()
    primitive["targets"] = [{"POSITION": gltf.accessor([(2, 0, 0)] * 3)}]
    gltf.root["meshes"][0]["weights"] = [weight]


def _skinned(gltf: Gltf) -> None:
    """A triangle that follows a joint up by one unit; its own node's place has no effect."""
    primitive = gltf.primitive()
    primitive["attributes"]["JOINTS_0"] = gltf.accessor([(0, 0, 0, 0)] * 3, "u1")
    primitive["attributes"]["WEIGHTS_0"] = gltf.accessor([(1, 0, 0, 0)] * 3)
    inverse = np.eye(4)
    inverse[3, 0] = 1
    gltf.root["skins"] = [{"joints": [1], "inverseBindMatrices": gltf.accessor([inverse.ravel()])}]
    gltf.root["nodes"] = [{"mesh": 0, "skin": 0, "translation": [50, 0, 0]}, {"translation": [0, 1, 0]}]
    gltf.root["scenes"] = [{"nodes": [0, 1]}]


def _edited(path: str, value: Any) -> Callable[[Gltf], None]:
    """A triangle with one member of its JSON changed, e.g. ``accessors.0.count``."""

    def build(gltf: Gltf) -> None:
        gltf.primitive()
        *keys, last = path.split(".")
        at: Any = gltf.root
        for key in keys:
            at = at[int(key)] if key.isdecimal() else at[key]
        at[int(last) if last.isdecimal() else last] = value

    return build


AT = [(0.375, 0.5)] * 3
GLTF = (
    _case("triangle", lambda g: g.primitive(), {GIVEN: 136}),
    _case("bytes", lambda g: _indexed(g, [0, 1, 2, 0, 2, 3], "u1"), {GIVEN: 256}),
    _case("words", lambda g: _indexed(g, [0, 1, 2, 0, 2, 3], "u4"), {GIVEN: 256}),
    _case("fan", lambda g: _indexed(g, [0, 1, 2, 3], "u2", 6), {GIVEN: 256}),
    _case("strip", lambda g: _indexed(g, [0, 1, 3, 2], "u2", 5), {GIVEN: 256}),
    _case("strip_not_indexed", lambda g: g.primitive([SQUARE[i] for i in (0, 1, 3, 2)], mode=5),
        {GIVEN: 256}),
    _case("lines", lambda g: (g.primitive(mode=1), g.primitive()), {GIVEN: 136}, note="points or lines"),
    _case("mode_seven", lambda g: g.primitive(mode=7), refused="mode 7"),
    _case("index_beyond", lambda g: _indexed(g, [0, 1, 4], "u2"), refused="does not exist"),
    _case("index_signed", lambda g: _indexed(g, [0, 1, 2], "i2"), refused="unsigned"),
    _case("corners_left", lambda g: _indexed(g, [0, 1, 2, 3], "u2"), refused="4 corners"),
    _case("strided", _strided, {BLUE: 136}),
    _case("sparse_alone", _sparse_alone, {GIVEN: 136}),
    _case("single_sided", lambda g: _two_faces(g, False), {BLUE: 136}),
    _case("double_sided", lambda g: _two_faces(g, True), {RED: 136, BLUE: 136}),
    _case("two_materials", lambda g: [g.primitive([(x, y + dy, 0) for x, y, _ in TRIANGLE],
          material=g.material(factor=f)) for dy, f in ((0, [1, 0, 0, 1]), (1, [0, 0, 1, 1]))], {RED: 136,
              BLUE: 136}),
    _case("colours_bytes", lambda g: _coloured(g, [255, 0, 0], "u1", normalized=True), {RED: 136}),
    _case("colours_times_factor", lambda g: _coloured(g, [0.2, 1, 1, 1], material=True), {(51, 153,
        51): 136}),
    _case("colours_above_one", lambda g: _coloured(g, [0.2, 3, 1, 1]), refused="colour of 3"),
    _case("factor_above_one", lambda g: g.primitive(material=g.material(factor=[1.5, 0, 0, 1])),
        refused="1.5"),
    _case("beside_no_material", lambda g: (g.primitive(material=g.material(factor=[1, 0, 0, 1])),
          g.primitive([(x + 1, y, z) for x, y, z in TRIANGLE])), {RED: 136, WHITE: 136}, note="drawn white"),
    _case("glossy", lambda g: (g.primitive(material=0), g.root.update(materials=[{"extensions": {
          "KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0, 1, 0, 1]}}}])), {GREEN: 136}),
    _case("transparent", lambda g: g.primitive(material=g.material(factor=[1, 0, 0, 0.5], alphaMode="BLEND")),
          {RED: 136}, note="transparent"),
    _case("texture", lambda g: _textured(g, AT), {GREEN: 136}),
    _case("texture_times_factor", lambda g: _textured(g, AT, factor=[1, 0.4, 1, 1]), {(0, 102, 0): 136}),
    _case("texture_clamped", lambda g: _textured(g, [(1.125, 0.5)] * 3, {"wrapS": 33071}), {WHITE: 136}),
    _case("texture_mirrored", lambda g: _textured(g, [(1.375, 0.5)] * 3, {"wrapS": 33648}), {BLUE: 136}),
    _case("texture_negative", lambda g: _textured(g, [(-0.125, 0.5)] * 3), {WHITE: 136}),
    _case("texture_linear", lambda g: _textured(g, [(0.25, 0.5)] * 3, {"magFilter": 9729}), {(128, 128,
        0): 136}),
    _case("texture_moved", lambda g: _textured(g, AT, None, {"extensions": {"KHR_texture_transform":
          {"offset": [0.25, 0]}}}), {BLUE: 136}),
    _case("texture_turned", lambda g: _textured(g, [(0.5, 0.375)] * 3, None, {"extensions": {
          "KHR_texture_transform": {"rotation": np.pi / 2}}}), {GREEN: 136}),
    _case("texture_other_set", lambda g: _textured(g, AT, None, {"texCoord": 1}), refused="no TEXCOORD_1"),
    _case("texture_bytes", lambda g: g.primitive(material=g.material({"index": g.texture(FLAG)}))[
          "attributes"].update(TEXCOORD_0=g.accessor([(96, 128)] * 3, "u1", normalized=True)), {GREEN: 136}),
    _case("texture_broken", lambda g: g.primitive(material=g.material({"index": g.texture(b"no picture")}))[
          "attributes"].update(TEXCOORD_0=g.accessor(AT)), refused="cannot read the texture"),
    _case("texture_basis", lambda g: (_textured(g, AT), g.root.update(textures=[{"extensions": {
          "KHR_texture_basisu": {"source": 0}}}])), refused="KHR_texture_basisu"),
    _case("moved", lambda g: _nodes(g, {"children": [1], "scale": [2, 2, 2]}, {"mesh": 0, "translation": [0.5,
        0, 0]}),
          {GIVEN: 528}),
    _case("matrix", lambda g: _nodes(g, {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, -1, 0, 0,
        1]}),
          {GIVEN: 528}),
    _case("turned", lambda g: _nodes(g, {"mesh": 0, "rotation": [0, 0, 1, 0], "translation": [1, 1, 0]}),
        {GIVEN: 120}),
    _case("mirrored", lambda g: _nodes(g, {"mesh": 0, "scale": [-1, 1, 1], "translation": [1, 0, 0]}),
        {GIVEN: 120}),
    _case("instances", lambda g: _nodes(g, {"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0]}, first=(0, 1)),
        {GIVEN: 272}),
    _case("other_scene", lambda g: _nodes(g, {"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0]}),
        {GIVEN: 136}),
    _case("hidden", lambda g: _nodes(g, {"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0], "extensions": {
          "KHR_node_visibility": {"visible": False}}}, first=(0, 1)), {GIVEN: 136}),
    _case("node_loop", lambda g: _nodes(g, {"mesh": 0, "children": [1]}, {"children": [0]}),
        refused="two parents"),
    _case("gpu_instances", lambda g: _nodes(g, {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}),
          refused="EXT_mesh_gpu_instancing"),
    _case("morphed", lambda g: _morphed(g, 0.5), {GIVEN: 136}),
    _case("morphed_out", lambda g: _morphed(g, 2.0), {}),
    _case("skinned", _skinned, {GIVEN: 136}),
    _case("version_1", _edited("asset.version", "1.0"), refused="version is 1.0"),
    _case("meshopt", _edited("extensionsRequired", ["EXT_meshopt_compression"]),
        refused="EXT_meshopt_compression"),
    _case("meshopt_used", _edited("bufferViews.0.extensions", {"EXT_meshopt_compression": {}}),
        refused="EXT_meshopt"),
    _case("unlit", _edited("extensionsRequired", ["KHR_materials_unlit"]), {GIVEN: 136}),
    _case("count_too_large", _edited("accessors.0.count", 4), refused="cut short"),
    _case("count_huge", _edited("accessors.0.count", 10**12), refused="cut short"),
    _case("count_negative", _edited("accessors.0.count", -3), refused="count -3"),
    _case("count_text", _edited("accessors.0.count", "3"), refused="count '3'"),
    _case("view_too_long", _edited("bufferViews.0.byteLength", 400), refused="cut short"),
    _case("accessor_beyond", _edited("meshes.0.primitives.0.attributes.POSITION", 7),
        refused="number 7 of 1 accessors"),
    _case("mesh_beyond", _edited("nodes.0.mesh", 3), refused="number 3 of 1 meshes"),
    _case("position_scalar", _edited("accessors.0.type", "SCALAR"), refused="is SCALAR"),
    _case("no_positions", _edited("meshes.0.primitives.0.attributes", {}), refused="no triangles"),
    _case("animated", _edited("animations", [{}]), {GIVEN: 136}, note="animations"),
)  # fmt: skip


def _files() -> tuple[Case, ...]:
    """The triangle as text, with its buffer and texture beside it or in it."""
    plain, textured = Gltf(), Gltf()
    plain.primitive()
    _textured(textured, AT)
    data = base64.b64encode(plain.binary).decode()
    image = base64.b64encode(FLAG).decode()
    textured.root["images"] = [{"uri": f"data:image/png;base64,{image}"}]
    inside = textured.gltf(
        f"data:application/octet-stream;base64,{base64.b64encode(textured.binary).decode()}"
    )
    textured.root["images"] = [{"uri": "my%20flag.png"}]
    beside = {"a b.bin": textured.binary, "my flag.png": FLAG}
    return (
        Case("data_uri.gltf", {GIVEN: 136}, plain.gltf(f"data:;base64,{data}"), given=GIVEN),
        Case("external.gltf", {GREEN: 136}, textured.gltf("a%20b.bin"), beside),
        Case("images_inside.gltf", {GREEN: 136}, inside),
        Case("missing_bin.gltf", None, plain.gltf("a.bin"), refused="there is no a.bin beside it"),
        Case(
            "missing_png.gltf",
            None,
            textured.gltf("a.bin"),
            {"a.bin": textured.binary},
            "no my flag.png beside it",
        ),
        Case("short_bin.gltf", None, plain.gltf("a.bin"), {"a.bin": b"1234"}, "cut short"),
        Case("remote.gltf", None, plain.gltf("https://example.org/a.bin"), refused="not fetched"),
        Case("bad_base64.gltf", None, plain.gltf("data:;base64,@@@"), refused="no base64"),
        Case("cut.glb", None, plain.glb()[:-4], refused="cut short"),
        Case("longer.glb", {GIVEN: 136}, plain.glb() + b"more", note="4 bytes behind", given=GIVEN),
        Case("list.gltf", None, b"[1, 2]", refused="no object"),
        Case("nan.gltf", None, b'{"asset": NaN}', refused="no JSON"),
        Case("deep.gltf", None, b"[" * 100_000, refused="no JSON"),
    )


FILES = _files()
