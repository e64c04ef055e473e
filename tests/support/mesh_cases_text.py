# SPDX-License-Identifier: Apache-2.0
"""Cases of OBJ, PLY, OFF and STL."""

from __future__ import annotations

import struct

import numpy as np

from tests.support.mesh_cases import BLUE, GIVEN, GREEN, RED, WHITE, Case, Colour, png

GIVEN_FILES = (
    Case("01-mtl.obj", {RED: 256}),
    Case("02-uv.obj", {RED: 136}, given=RED),
    Case("02-colours.obj", {GREEN: 136}),
    Case("03-nofactor.glb", {WHITE: 136}),
    Case("03-factor.glb", {RED: 136}),
    Case("03-colour-and-material.glb", {GREEN: 136}),
    Case("04-negative.obj", {WHITE: 768}),
    Case("05-concave.obj", {WHITE: 768}),
    Case("05-concave.ply", {WHITE: 768}),
    Case("06-tab.obj", {WHITE: 136}, b"v 0 0 0\nv\t1 0 0\nv 1 1 0\nv 0 1 0\nf 1\t2 3\n"),
    Case("07-sparse.glb", {WHITE: 392}),
    Case("08-draco.glb", None, refused="requires KHR_draco_mesh_compression"),
    Case("09-quantised.glb", {WHITE: 136}),
    Case("10-colours16.glb", {(128, 64, 255): 136}),
    Case("11-cut.ply", None, refused="cut short"),
    Case("12-mixed.ply", {WHITE: 376}),
    Case("12-mixed-text.ply", {WHITE: 376}),
    Case("13-colours.off", {GREEN: 136}),
    Case("14-fan.glb", {WHITE: 392}),
    Case("15-repeat.glb", {RED: 136}),
    Case("15-repeat.obj", {RED: 136}),
    Case("19-near.ply", {GREEN: 1296, RED: 2800}, camera="eye=0,0,5,target=0,0,0,fov=20"),
    Case("20-plane.obj", {WHITE: 2048}, camera="eye=0,0,1,target=0,1,1,up=0,0,1,fov=20,near=0.01"),
)

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
COLOURS = b"newmtl red\nKd 1 0 0\nnewmtl dark blue\nKd 0 0 1\nnewmtl clear\nKd 0 1 0\nd 0.5\nnewmtl none\n"
UV = "vt 0.125 0.5\n"
FLAG = png(RED, GREEN, BLUE, WHITE)


def obj(
    name: str, text: str, lit: dict[Colour, int] | None, refused: str = "", note: str = "", **beside: bytes
) -> Case:
    """An OBJ; files beside it are given as ``name_suffix``; without materials it shows the given colour."""
    files = {key.replace("__", " ").replace("_", "."): content for key, content in beside.items()}
    return Case(f"{name}.obj", lit, text.encode(), files, refused, note, given=GIVEN)


OBJ = (
    obj("comment_behind_data", "v 0 0 0 # origin\nv 1 0 0#x\nv 1 1 0\nf 1 2 3 # first\n", {GIVEN: 136}),
    obj("continued_line", SQUARE + "f 1 2 \\\n 3 4\n", {GIVEN: 256}),
    obj("continued_line_crlf", (SQUARE + "f 1 2 \\\n 3 4\n").replace("\n", "\r\n"), {GIVEN: 256}),
    obj("mixed_corners", SQUARE + "vt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3\n", {GIVEN: 136}),
    obj("some_normals", SQUARE + "vn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4\n", {GIVEN: 256}),
    obj("carriage_returns", (SQUARE + "f 1 2 3 4\n").replace("\n", "\r"), {GIVEN: 256}),
    obj("byte_order_mark", "\ufeff" + SQUARE + "f 1 2 3\n", {GIVEN: 136}),
    Case("utf16.obj", {GIVEN: 136}, (SQUARE + "f 1 2 3\n").encode("utf-16"), given=GIVEN),
    obj("negative_everywhere", SQUARE + "vt 0 0\nvn 0 0 1\nf -4/-1/-1 -3/-1/-1 -2/-1/-1\n", {GIVEN: 136}),
    obj("negative_too_far", SQUARE + "f -1 -2 -5\n", None, "names vertex -5 where there are 4"),
    obj("negative_normal_too_far", SQUARE + "vn 0 0 1\nf 1//-2 2//-1 3//-1\n", None, "names normal -2"),
    obj("zero", SQUARE + "f 1 2 0\n", None, "names vertex 0"),
    obj("beyond", SQUARE + "f 1 2 9\n", None, "vertex that does not exist"),
    obj("word_in_face", SQUARE + "f 1 two 3\n", None, "line 5"),
    obj("word_in_vertex", "v 0 0 x\n", None, "line 1"),
    obj("two_coordinates", "v 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", None, "line 1 has 2 numbers"),
    obj("weights", SQUARE.replace(" 0\n", " 0 1.0\n") + "f 1 2 3\n", {GIVEN: 136}),
    obj("groups", "o a\ng b c\ns 1\n" + SQUARE + "f 1 2 3\no d\ns off\nf 1 3 4\n", {GIVEN: 256},
        note="smoothing"),
    obj("points_and_lines", SQUARE + "p 1 2\nl 1 2 3\nf 1 2 3\n", {GIVEN: 136},
        note="1 line element not drawn"),
    obj("points_alone", SQUARE + "p 1\n", None, "no triangles"),
    obj("two_corners", SQUARE + "f 1 2\nf 1 2 3\n", {GIVEN: 136}, note="fewer than three"),
    obj("surface", SQUARE + "f 1 2 3\ncstype bezier\nsurf 0 1 0 1 1 2 3 4\nend\n", None, "free-form surface"),
    obj("unknown_statement", SQUARE + "f 1 2 3\nfoo 1\n", {GIVEN: 136}, note="'foo'"),
    obj(
        "two_materials",
        "mtllib m.mtl\n" + SQUARE + "v 2 0 0\nv 2 1 0\nusemtl red\nf 1 2 3 4\nusemtl dark blue\nf 2 5 6 3\n",
        {RED: 256, BLUE: 256}, m_mtl=COLOURS,
    ),
    obj("before_usemtl", "mtllib m.mtl\n" + SQUARE + "f 1 2 3\nusemtl red\nf 1 3 4\n", {WHITE: 136, RED: 120},
        note="drawn white", m_mtl=COLOURS),
    obj("no_colour", "mtllib m.mtl\n" + SQUARE + "usemtl none\nf 1 2 3\n", {GIVEN: 136}, m_mtl=COLOURS),
    obj("missing_library", "mtllib no.mtl\n" + SQUARE + "usemtl red\nf 1 2 3\n", None, "there is no no.mtl"),
    obj("missing_material", "mtllib m.mtl\n" + SQUARE + "usemtl pink\nf 1 2 3\n", None, "'pink'",
        m_mtl=COLOURS),
    obj("names_without_library", SQUARE + "usemtl red\nf 1 2 3\n", {GIVEN: 136}, note="no mtllib"),
    obj("library_unused", "mtllib no.mtl\n" + SQUARE + "f 1 2 3\n", {GIVEN: 136}),
    obj("transparent", "mtllib m.mtl\n" + SQUARE + "usemtl clear\nf 1 2 3\n", {GREEN: 136},
        note="transparent",
        m_mtl=COLOURS),
    obj("library_with_blank", "mtllib my file.mtl\n" + SQUARE + "usemtl red # the red one\nf 1 2 3\n",
        {RED: 136},
        my__file_mtl=COLOURS),
    obj("two_libraries", "mtllib a.mtl b.mtl\n" + SQUARE + "usemtl red\nf 1 2 3\nusemtl c\nf 1 3 4\n",
        {RED: 136, BLUE: 120}, a_mtl=COLOURS, b_mtl=b"newmtl c\nKd 0 0 1\n"),
    obj("kd_above_one", "mtllib m.mtl\n" + SQUARE + "usemtl c\nf 1 2 3\n", None, "from 0 to 1",
        m_mtl=b"newmtl c\nKd 2 0 0\n"),
    obj("kd_spectral", "mtllib m.mtl\n" + SQUARE + "usemtl c\nf 1 2 3\n", None, "spectral",
        m_mtl=b"newmtl c\nKd spectral a.rfl\n"),
    obj("kd_grey", "mtllib m.mtl\n" + SQUARE + "usemtl c\nf 1 2 3\n", {(102, 102, 102): 136},
        m_mtl=b"newmtl c\nKd 0.4\n"),
    obj("vertex_colour_times_kd",
        "mtllib m.mtl\nv 0 0 0 1 1 0\nv 1 0 0 1 1 0\nv 1 1 0 1 1 0\nusemtl red\nf 1 2 3\n",
        {RED: 136}, m_mtl=COLOURS),
    obj("vertex_colour_above_one", "v 0 0 0 255 0 0\nv 1 0 0 0 0 0\nv 1 1 0 0 0 0\nf 1 2 3\n", None,
        "colour of 255"),
    obj("texture_times_kd", "mtllib m.mtl\n" + SQUARE + UV + "usemtl t\nf 1/1 2/1 3/1\n", {(51, 0, 0): 136},
        m_mtl=b"newmtl t\nKd 0.2 1 1\nmap_Kd t.png\n", t_png=FLAG),
    obj("texture_clamped", "mtllib m.mtl\n" + SQUARE + "vt 1.125 .5\nusemtl t\nf 1/1 2/1 3/1\n", {WHITE: 136},
        m_mtl=b"newmtl t\nmap_Kd -clamp on t.png\n", t_png=FLAG),
    obj("texture_moved", "mtllib m.mtl\n" + SQUARE + UV + "usemtl t\nf 1/1 2/1 3/1\n", {GREEN: 136},
        m_mtl=b"newmtl t\nmap_Kd -s 1 1 1 -o 0.25 0 0 t.png\n", t_png=FLAG),
    obj("texture_negated", "mtllib m.mtl\n" + SQUARE + UV + "usemtl t\nf 1/1 2/1 3/1\n", None, "-mm",
        m_mtl=b"newmtl t\nmap_Kd -mm 1 -1 t.png\n", t_png=FLAG),
    obj("texture_missing", "mtllib m.mtl\n" + SQUARE + UV + "usemtl t\nf 1/1 2/1 3/1\n", None, "no t.png",
        m_mtl=b"newmtl t\nmap_Kd t.png\n"),
    obj("texture_broken", "mtllib m.mtl\n" + SQUARE + UV + "usemtl t\nf 1/1 2/1 3/1\n", None,
        "cannot read the texture",
        m_mtl=b"newmtl t\nmap_Kd t.png\n", t_png=FLAG[:40]),
    obj("texture_without_places", "mtllib m.mtl\n" + SQUARE + "usemtl t\nf 1 2 3\n", None,
        "no texture coordinates",
        m_mtl=b"newmtl t\nmap_Kd t.png\n", t_png=FLAG),
    obj("texture_to_the_seam", "mtllib m.mtl\n" + SQUARE + "vt .75 0\nvt 1 0\nvt 1 1\nvt .75 1\nusemtl t\n"
        "f 1/1 2/2 3/3 4/4\n", {WHITE: 256}, m_mtl=b"newmtl t\nmap_Kd t.png\n", t_png=FLAG),
    obj("concave_backwards_first", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 4 5 6 1 2 3\n",
        {GIVEN: 768}),
    obj("star", "v 1 2 0\nv .75 1.25 0\nv 0 1 0\nv .75 .75 0\nv 1 0 0\nv 1.25 .75 0\nv 2 1 0\nv 1.25 1.25 0\n"
        "f 1 2 3 4 5 6 7 8\n", {GIVEN: 256}),
    obj("crossing", SQUARE + "f 1 3 2 4\n", {GIVEN: 136}, note="sides that cross"),
)  # fmt: skip


def ply(
    name: str, body: str | bytes, lit: dict[Colour, int] | None, refused: str = "", note: str = "",
    vertex: str = "", face: str = "property list uchar int vertex_indices\n", faces: int = 1,
        vertices: int = 4,
    kind: str = "ascii", more: str = "", **beside: bytes,
) -> Case:  # fmt: skip
    """A PLY with x, y, z and the properties given."""
    header = f"ply\nformat {kind} 1.0\n{more}element vertex {vertices}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz") + vertex
    header += f"element face {faces}\n{face}end_header\n"
    content = header.encode() + (body.encode() if isinstance(body, str) else body)
    files = {key.replace("_", "."): data for key, data in beside.items()}
    return Case(f"{name}.ply", lit, content, files, refused, note, given=GIVEN)


CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
BODY = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
RGB = "".join(f"property {{}} {name}\n" for name in ("red", "green", "blue"))


def rgb(kind: str) -> str:
    """Three properties of colour."""
    return "".join(f"property {kind} {name}\n" for name in ("red", "green", "blue"))


def binary(order: str, kind: str = "", colour: tuple = ()) -> bytes:
    """The square as vertices, then a quad and a triangle, in a byte order."""
    out = b"".join(struct.pack(f"{order}fff{kind}", *corner, *colour) for corner in CORNERS)
    return out + struct.pack(f"{order}B4iB3i", 4, 0, 1, 2, 3, 3, 0, 1, 2)


PLY = (
    ply("little", binary("<"), {GIVEN: 256}, faces=2, kind="binary_little_endian"),
    ply("big", binary(">"), {GIVEN: 256}, faces=2, kind="binary_big_endian"),
    ply("big_cut", binary(">")[:-1], None, "cut short", faces=2, kind="binary_big_endian"),
    ply("binary_no_faces", binary("<")[:48], None, "cut short", faces=2, kind="binary_little_endian"),
    ply("binary_more", binary("<") + b"more", {GIVEN: 256}, note="behind", faces=2,
        kind="binary_little_endian"),
    ply("colours16", binary("<", "HHH", (32768, 16384, 65535)), {(128, 64, 255): 256}, vertex=rgb("ushort"),
        faces=2, kind="binary_little_endian"),
    ply("colours_float", binary(">", "fff", (0, 1, 0)), {GREEN: 256}, vertex=rgb("float"), faces=2,
        kind="binary_big_endian"),
    ply("colours_float_above_one", binary(">", "fff", (0, 255, 0)), None, "colour of 255",
        vertex=rgb("float"),
        faces=2, kind="binary_big_endian"),
    ply("colours_of_faces", BODY + "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n", {RED: 136, BLUE: 120}, faces=2,
        face="property list uchar int vertex_indices\n" + rgb("uchar")),
    ply("colours_of_faces_before", BODY + "255 0 0 4 0 1 2 3\n", {RED: 256},
        face=rgb("uchar") + "property list uchar int vertex_index\n"),
    ply("lists_of_faces", BODY + "4 0 1 2 3 2 7 8\n3 0 1 2 1 9\n", {GIVEN: 256}, faces=2,
        face="property list uchar int vertex_indices\nproperty list uchar float other\n"),
    ply("more_of_vertices", "".join(f"{x} {y} {z} 7 2 1 1\n" for x, y, z in CORNERS) + "4 0 1 2 3\n",
        {GIVEN: 256},
        vertex="property double confidence\nproperty list uchar int neighbours\n"),
    ply("other_element", "9 9\n" + BODY + "4 0 1 2 3\n", {GIVEN: 256}, note="'camera'",
        more="element camera 1\nproperty float a\nproperty float b\n"),
    ply("concave", "0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n6 1 2 3 4 5 0\n", {GIVEN: 768}, vertices=6),
    ply("strange_header", BODY + "3 0 1 2\n", {GIVEN: 136}, note="'Created by", more="Created by nobody\n"),
    ply("damaged_header", BODY + "3 0 1 2\n", None, "propxrty", vertex="propxrty float w\n"),
    ply("long_word", BODY + "3 0 1 " + "2" * 100, None, "more than 64"),
    ply("opaque", BODY.replace("\n", " 255 0 0 255\n") + "4 0 1 2 3\n", {RED: 256},
        vertex=rgb("uchar") + "property uchar alpha\n"),
    ply("transparent", BODY.replace("\n", " 255 0 0 9\n") + "4 0 1 2 3\n", {RED: 256}, note="transparent",
        vertex=rgb("uchar") + "property uchar alpha\n"),
    ply("beyond", BODY + "3 0 1 4\n", None, "vertex that does not exist"),
    ply("negative", BODY + "3 0 1 -1\n", None, "vertex that does not exist"),
    ply("huge_count", BODY + "3 0 1 2\n", None, "cut short", vertices=999999999),
    ply("list_too_long", BODY + "9 0 1 2\n", None, "cut short"),
    ply("float_in_uchar", BODY.replace("\n", " 0.5 0 0\n") + "3 0 1 2\n", None, "which is no uint8",
        vertex=rgb("uchar")),
    ply("no_number", BODY + "3 0 one 2\n", None, "no number"),
    ply("textured", "".join(f"{x} {y} {z} 0.375 0.5\n" for x, y, z in CORNERS) + "4 0 1 2 3\n", {GREEN: 256},
        vertex="property float s\nproperty float t\n", more="comment TextureFile t.png\n", t_png=FLAG),
    ply("textured_corners", BODY + "3 0 1 2 6 .6 .5 .6 .5 .6 .5\n", {BLUE: 136},
        more="comment TextureFile t.png\n",
        face="property list uchar int vertex_indices\nproperty list uchar float texcoord\n", t_png=FLAG),
    Case("strips.ply", {GIVEN: 256}, (
        b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        b"element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
        b"8 0 1 2 -1 2 1 3 -1\n"), given=GIVEN),
    Case("crlf.ply", {GIVEN: 136}, b"\r\n".join((
        b"ply", b"format ascii 1.0", b"element vertex 3", b"property float x", b"property float y",
        b"property float z", b"element face 1", b"property list uchar int vertex_indices", b"end_header",
        b"0 0 0", b"1 0 0", b"1 1 0", b"3 0 1 2", b"")), given=GIVEN),
    Case("points.ply", None, b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         b"property float z\nend_header\n0 0 0\n", refused="no triangles"),
)  # fmt: skip


def off(name: str, text: str, lit: dict[Colour, int] | None, refused: str = "", note: str = "") -> Case:
    """An OFF file."""
    return Case(f"{name}.off", lit, text.encode(), {}, refused, note, given=GIVEN)


OFF = (
    off("plain", "OFF\n4 1 0\n" + BODY + "4 0 1 2 3\n", {GIVEN: 256}),
    off("one_line_header", "# a\nOFF 4 1 0\n\n" + BODY + "4 0 1 2 3 # b\n", {GIVEN: 256}),
    off("crlf", ("OFF\n4 1 0\n" + BODY + "4 0 1 2 3\n").replace("\n", "\r\n"), {GIVEN: 256}),
    off("colours_of_faces", "OFF\n4 2 0\n" + BODY + "3 0 1 2 255 0 0\n3 0 2 3 0 0 255 255\n", {RED: 136,
        BLUE: 120}),
    off("float_colours_of_faces", "OFF\n4 1 0\n" + BODY + "4 0 1 2 3 0.0 1.0 0.0\n", {GREEN: 256}),
    off("some_colours_of_faces", "OFF\n4 2 0\n" + BODY + "3 0 1 2 255 0 0\n3 0 2 3\n", {RED: 136, WHITE: 120},
        note="drawn white"),
    off("float_colours", "COFF\n4 1 0\n" + BODY.replace("\n", " 0 1 0 1\n") + "4 0 1 2 3\n", {GREEN: 256}),
    off("three_colours", "COFF\n4 1 0\n" + BODY.replace("\n", " 0 0 255\n") + "4 0 1 2 3\n", {BLUE: 256}),
    off("transparent", "COFF\n4 1 0\n" + BODY.replace("\n", " 0 255 0 128\n") + "4 0 1 2 3\n", {GREEN: 256},
        note="transparent"),
    off("transparent_face", "OFF\n4 1 0\n" + BODY + "4 0 1 2 3 0.0 1.0 0.0 0.5\n", {GREEN: 256},
        note="transparent"),
    off("colours_above_255", "COFF\n4 1 0\n" + BODY.replace("\n", " 0 300 0 255\n") + "4 0 1 2 3\n", None,
        "outside 0 .. 1"),
    off("normals", "NOFF\n4 1 0\n" + BODY.replace("\n", " 0 0 1\n") + "4 0 1 2 3\n", {GIVEN: 256}),
    off("normals_and_colours", "CNOFF\n4 1 0\n" + BODY.replace("\n", " 0 0 1 255 0 0 255\n") + "4 0 1 2 3\n",
        {RED: 256}),
    off("places_and_colours", "STCOFF\n4 1 0\n" + BODY.replace("\n", " 255 0 0 255 .5 .5\n") + "4 0 1 2 3\n",
        {RED: 256}),
    off("places", "STOFF\n4 1 0\n" + BODY.replace("\n", " .5 .5\n") + "4 0 1 2 3\n", {GIVEN: 256}),
    off("colour_map", "OFF\n4 1 0\n" + BODY + "4 0 1 2 3 5\n", None, "counts in a map"),
    off("four_dimensions", "4OFF\n4 1 0\n" + BODY.replace("\n", " 1\n") + "4 0 1 2 3\n", None,
        "three coordinates"),
    off("binary", "OFF BINARY\n", None, "binary OFF"),
    off("headless", "4 1 0\n" + BODY + "4 0 1 2 3\n", None, "not with OFF"),
    off("cut", "OFF\n4 2 0\n" + BODY + "4 0 1 2 3\n", None, "cut short"),
    off("cut_face", "OFF\n4 1 0\n" + BODY + "4 0 1 2\n", None, "cut short"),
    off("colours_not_announced", "OFF\n4 1 0\n" + BODY.replace("\n", " 0 1 0 1\n") + "4 0 1 2 3\n", None,
        "vertex 0"),
    off("concave", "OFF\n6 1 0\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n6 1 2 3 4 5 0\n", {GIVEN: 768}),
    off("beyond", "OFF\n4 1 0\n" + BODY + "3 0 1 4\n", None, "vertex that does not exist"),
)  # fmt: skip


def facet(*corners: tuple[float, ...]) -> str:
    """A facet of a text STL."""
    inner = "".join(f"      vertex {x} {y} {z}\n" for x, y, z in corners)
    return f"  facet normal 0 0 1\n    outer loop\n{inner}    endloop\n  endfacet\n"


def stl(*attributes: int, header: bytes = b"") -> bytes:
    """A binary STL of the square's two halves."""
    faces = np.array([CORNERS[:3], [CORNERS[0], *CORNERS[2:]]], dtype="<f4")
    out = header.ljust(80) + struct.pack("<I", 2)
    return out + b"".join(
        bytes(12) + face.tobytes() + struct.pack("<H", n) for face, n in zip(faces, attributes, strict=True)
    )


FIRST, SECOND = facet(*CORNERS[:3]), facet(CORNERS[0], *CORNERS[2:])
STL = (
    Case("plain.stl", {GIVEN: 256}, stl(0, 0), given=GIVEN),
    Case("solid_binary.stl", {GIVEN: 256}, stl(0, 0, header=b"solid part"), given=GIVEN),
    Case("solid_binary_cut.stl", None, stl(0, 0, header=b"solid part\0")[:-1], refused="cut short"),
    Case("cut.stl", None, stl(0, 0)[:-10], refused="cut short"),
    Case("header_only.stl", None, stl(0, 0)[:60], refused="cut short"),
    Case("longer.stl", {GIVEN: 256}, stl(0, 0) + b"more", note="4 bytes behind", given=GIVEN),
    Case("viscam.stl", {RED: 136, BLUE: 120}, stl(0x8000 | 31 << 10, 0x8000 | 31), given=GIVEN),
    Case("viscam_some.stl", {RED: 136, WHITE: 120}, stl(0x8000 | 31 << 10, 0), note="drawn white",
        given=GIVEN),
    Case("magics.stl", {RED: 136, GREEN: 120}, stl(31, 0x8000, header=b"COLOR=\0\xff\0\xff"), given=GIVEN),
    Case("text.stl", {GIVEN: 256}, f"solid a\n{FIRST}{SECOND}endsolid a\n".encode(), given=GIVEN),
    Case("text_capitals.stl", {GIVEN: 136}, f"solid a\n{FIRST}endsolid a\n".upper().encode(), given=GIVEN),
    Case("two_solids.stl", {GIVEN: 256}, f"solid a\n{FIRST}endsolid\nsolid b\n{SECOND}endsolid b\n".encode(),
        given=GIVEN),
    Case("no_endsolid.stl", {GIVEN: 256}, f"solid a\n{FIRST}{SECOND}".encode(), note="may be cut short",
        given=GIVEN),
    Case("cut_in_second_solid.stl", None, f"solid a\n{FIRST}endsolid a\nsolid b\n{SECOND[:60]}".encode(),
        refused="facet 2 is not complete"),
    Case("cut_after_loop.stl", None, f"solid a\n{FIRST}{SECOND[:-12]}".encode(), refused="cut short"),
    Case("two_corners.stl", None, f"solid a\n{facet(*CORNERS[:2])}endsolid a\n".encode(),
        refused="out of its place"),
    Case("four_corners.stl", {GIVEN: 256}, f"solid a\n{facet(*CORNERS)}endsolid a\n".encode(), given=GIVEN),
    Case("word.stl", None, f"solid a\n{FIRST.replace('1 1 0', '1 x 0')}endsolid a\n".encode(),
        refused="not numbers"),
    Case("empty.stl", None, b"", refused="cut short"),
)  # fmt: skip
