#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Write the mesh files of ``examples/``, each from a formula; ``--check`` only compares.

``part.stl`` is a gear, ``pawn.obj`` with ``pawn.mtl`` a chess piece of three materials, ``knot.glb`` a
trefoil knot with a colour at every vertex. ``triangles.json`` and ``cloth.py`` are written by hand.
"""

from __future__ import annotations

import sys
from pathlib import Path

import click
import numpy as np
import trimesh

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def scene_path(name: str) -> str:
    """A generated scene as it is named, or a file of the examples."""
    return name if ":" in name else str(EXAMPLES / name)


def strip(count: int, inner: int, outer: int) -> np.ndarray:
    """
    Triangles between two closed rings of vertices, seen counter-clockwise with ``outer`` on the right.

    Parameters
    ----------
    count : int
      Vertices of a ring.
    inner, outer : int
      Index of the first vertex of each ring.

    Returns
    -------
    (2 count, 3) int
    """
    here = np.arange(count)
    following = (here + 1) % count
    first = np.stack([inner + here, outer + here, outer + following], axis=1)
    second = np.stack([inner + here, outer + following, inner + following], axis=1)
    return np.concatenate([first, second])


def gear(teeth: int = 14, points_per_tooth: int = 6) -> trimesh.Trimesh:
    """A spur gear with a bore and a hub, closed, in units of its pitch radius; +z is its axis."""
    count = teeth * points_per_tooth
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # The outline of a tooth: root, root, flank, tip, tip, flank.
    tooth = np.array([0.84, 0.84, 0.94, 1.1, 1.1, 0.94])[:points_per_tooth]
    outline = circle * np.tile(tooth, teeth)[:, None]
    rings = [
        (circle * 0.25, 0.30),
        (circle * 0.45, 0.30),
        (circle * 0.50, 0.25),
        (circle * 0.50, 0.15),
        (outline, 0.15),
        (outline, -0.15),
        (circle * 0.25, -0.15),
    ]
    vertices = np.concatenate([np.column_stack([flat, np.full(count, z)]) for flat, z in rings])
    pairs = [(index, (index + 1) % len(rings)) for index in range(len(rings))]
    faces = np.concatenate([strip(count, a * count, b * count) for a, b in pairs])
    return trimesh.Trimesh(vertices, faces, process=False)


def revolve(profile: np.ndarray, sides: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Turn a profile around the y axis.

    Parameters
    ----------
    profile : (n, 2) float
      Radius and height, from the bottom up.
    sides : int
      Vertices of a ring.

    Returns
    -------
    vertices, normals : (n sides, 3) float
    faces : (2 (n - 1) sides, 3) int
    """
    angle = 2 * np.pi * np.arange(sides) / sides
    around = np.stack([np.sin(angle), np.zeros(sides), np.cos(angle)], axis=1)
    up = np.array([0.0, 1.0, 0.0])
    along = np.gradient(profile, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    vertices = np.concatenate([radius * around + height * up for radius, height in profile])
    normals = np.concatenate([rise * around - run * up for run, rise in along])
    rings = [strip(sides, row * sides, (row + 1) * sides)[:, ::-1] for row in range(len(profile) - 1)]
    return vertices, normals, np.concatenate(rings)


def pawn() -> str:
    """A pawn on four squares of a chess board, as the text of an OBJ file with three materials."""
    head = np.linspace(-0.9, np.pi / 2, 14)[:-1]
    body = np.linspace(0, 1, 14)
    profile = np.concatenate(
        [
            [(0.42, 0.0), (0.44, 0.06), (0.42, 0.12)],
            np.stack([0.40 - 0.27 * np.sin(np.pi / 2 * body), 0.16 + 0.62 * body], axis=1),
            [(0.26, 0.82), (0.26, 0.86)],
            np.stack([0.23 * np.cos(head), 1.06 + 0.23 * np.sin(head)], axis=1),
            [(0.004, 1.29)],
        ]
    )
    vertices, normals, faces = revolve(profile, 22)
    lines = ["# A pawn on four squares, written by scripts/examples.py; Apache-2.0", "mtllib pawn.mtl"]
    lines += ["v {:.4f} {:.4f} {:.4f}".format(*vertex) for vertex in vertices]
    lines += ["vn {:.4f} {:.4f} {:.4f}".format(*normal) for normal in normals]
    lines += ["o pawn", "usemtl ivory"]
    lines += ["f {0}//{0} {1}//{1} {2}//{2}".format(*face) for face in faces + 1]
    corners = [(x, z) for z in (-0.8, 0.0, 0.8) for x in (-0.8, 0.0, 0.8)]
    lines += ["o squares"] + [f"v {x} 0 {z}" for x, z in corners] + ["vn 0 1 0"]
    for name, squares in (("light", (0, 4)), ("dark", (1, 3))):
        lines.append(f"usemtl {name}")
        for corner in squares:
            ring = (corner, corner + 3, corner + 4, corner + 1)
            first = len(vertices) + 1
            lines.append("f " + " ".join(f"{first + index}//{len(normals) + 1}" for index in ring))
    return "\n".join(lines) + "\n"


PAWN_MATERIALS = """\
# Materials of pawn.obj; Apache-2.0
newmtl ivory
Ka 0 0 0
Ns 20
Kd 0.85 0.72 0.50
Ks 0.2 0.2 0.2
newmtl light
Ka 0 0 0
Ns 20
Kd 0.80 0.80 0.78
Ks 0 0 0
newmtl dark
Ka 0 0 0
Ns 20
Kd 0.25 0.30 0.42
Ks 0 0 0
"""


def knot(rings: int = 84, sides: int = 12, radius: float = 0.42) -> trimesh.Trimesh:
    """A tube along the knot (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t); its hue goes round once."""
    t = 2 * np.pi * np.arange(rings) / rings

    def point(t: np.ndarray) -> np.ndarray:
        return np.stack(
            [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1
        )

    tangent = point(t + 1e-4) - point(t - 1e-4)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    # The frame is that of the torus on which the knot lies, which closes: no twist is left at the seam.
    axis = np.stack([np.zeros(rings), np.zeros(rings), np.ones(rings)], axis=1)
    side = np.cross(tangent, axis)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other_side = np.cross(side, tangent)
    angle = 2 * np.pi * np.arange(sides) / sides
    normals = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * other_side[:, None]
    vertices = point(t)[:, None] + radius * normals
    hue = t[:, None] + np.array([0, 2, 4]) * np.pi / 3
    colours = np.repeat(np.rint(255 * (0.55 + 0.4 * np.cos(hue))).astype(np.uint8), sides, axis=0)
    faces = []
    for ring in range(rings):
        faces.append(strip(sides, ring * sides, (ring + 1) % rings * sides))
    return trimesh.Trimesh(
        vertices.reshape(-1, 3),
        np.concatenate(faces),
        vertex_normals=normals.reshape(-1, 3),
        vertex_colors=np.column_stack([colours, np.full(len(colours), 255)]),
        process=False,
    )


def files() -> dict[str, bytes]:
    """Every file's name and content."""
    return {
        "part.stl": gear().export(file_type="stl"),
        "pawn.obj": pawn().encode(),
        "pawn.mtl": PAWN_MATERIALS.encode(),
        "knot.glb": knot().export(file_type="glb", include_normals=True),
    }


@click.command(help=__doc__)
@click.option(
    "--check", is_flag=True, help="Write nothing; exit code 2 if a file is not what would be written."
)
def main(check: bool) -> None:
    if not check:
        EXAMPLES.mkdir(exist_ok=True)
        for name, content in files().items():
            (EXAMPLES / name).write_bytes(content)
        return
    for name, content in files().items():
        if not (EXAMPLES / name).is_file() or (EXAMPLES / name).read_bytes() != content:
            click.echo(f"examples: error: {name} is not what scripts/examples.py writes; run it", err=True)
            sys.exit(2)


if __name__ == "__main__":
    main()
