#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
Edge maps against the mesh's own edges: precision, recall, thickness and smoothness of both variants.

Writes docs/reports/edges.md, edges.json and edges.png, and docs/images/styles.png. The real meshes are those
of the package pyvista, which pip fetches at run time, or files given with --mesh.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates, maximum_filter
from skimage.morphology import skeletonize

from quadshade.contract.formats import Formats
from quadshade.files.markdown import markdown_table
from quadshade.image import write_png
from quadshade.scene import fit_camera, load_scene, project
from quadshade.scene.mesh import Mesh
from quadshade.shading import parse_material
from quadshade.style import draw_edges, draw_gbuffer, find_edges, illustrate
from quadshade.style.edges import PROFILE_RANGE, VARIANTS
from scripts.experiments.edges.classify import (
    BORDER,
    CREASE,
    CREASE_DEGREES,
    SILHOUETTE,
    classify_edges,
    edge_points,
    visible_edges,
)
from scripts.experiments.real_meshes import PACKAGE, real_meshes
from scripts.experiments.report_writer import (
    LICENCE,
    REPORTS,
    ROOT,
    command_line,
    output_option,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "edges.md"
GENERATED = ("sphere:690", "torus:1152", "cube:2")
DRAWN = 0.5
"""A pixel counts as an edge from this strength on."""
TOLERANCE = 1.5
"""Pixels between an edge of the map and one of the mesh that count as the same: also a diagonal neighbour."""
VIEW = (1.0, 0.8, 1.0)


def share(part: np.ndarray, near: np.ndarray) -> float:
    """Which share of the pixels of one set lies within ``TOLERANCE`` of another; 1 of none."""
    if not part.any():
        return 1.0
    if not near.any():
        return 0.0
    return float((distance_transform_edt(~near)[part] <= TOLERANCE).mean())


def smoothness(strength: np.ndarray, place: np.ndarray, edge: np.ndarray, seen: np.ndarray) -> float:
    """Mean change of strength from pixel to pixel along the mesh's edges that are seen: lower is smoother."""
    value = map_coordinates(strength, (place - 0.5).T[::-1], order=1, mode="nearest")
    column, row = np.floor(place).astype(np.int64).T
    inside = (column >= 0) & (column < seen.shape[1]) & (row >= 0) & (row < seen.shape[0])
    shown = inside.copy()
    shown[inside] = seen[row[inside], column[inside]]
    follows = (edge[1:] == edge[:-1]) & shown[1:] & shown[:-1]
    length = np.linalg.norm(place[1:] - place[:-1], axis=1)[follows]
    return float(np.abs(np.diff(value))[follows].sum() / length.sum()) if length.sum() > 0 else 0.0


def thickness(edge: np.ndarray, low: float) -> float:
    """Mean width of edges in pixels at half of their own height: pixels for each pixel of the skeleton."""
    wide = (edge >= low) & (edge >= maximum_filter(edge, size=5) / 2)
    return float(wide.sum() / max(skeletonize(wide).sum(), 1))


def measure(mesh: Mesh, size: int) -> tuple[list[dict], np.ndarray]:
    """Figures of both variants on a mesh, and the pictures: truth, then both maps."""
    camera = fit_camera(mesh, direction=np.array(VIEW))
    formats = Formats()
    projected = project(mesh, camera, size, size, formats, cull=False)
    gbuffer, _ = draw_gbuffer(projected, formats)
    edges = classify_edges(mesh, camera)
    truth = {
        name: visible_edges(edges, chosen, camera, gbuffer, projected) for name, chosen in edges.kind.items()
    }
    outline, everything = truth[SILHOUETTE] | truth[BORDER], np.logical_or.reduce(list(truth.values()))
    chosen = np.logical_or.reduce(list(edges.kind.values()))
    place, _, edge = edge_points(edges, chosen, camera, size, size)
    white = np.full((size, size, 3), 255, np.uint8)
    shown = white.copy()
    for name, ink in ((CREASE, (200, 60, 0)), (BORDER, (0, 120, 40)), (SILHOUETTE, (0, 0, 0))):
        shown[truth[name]] = ink
    rows, pictures = [], [shown]
    for variant in VARIANTS:
        maps = find_edges(gbuffer, variant)
        profile, inner = maps.strength("profile"), maps.strength("inner")
        strength = np.maximum(profile, inner)
        drawn = strength >= DRAWN
        rows.append(
            {
                "variant": variant,
                "precision": share(drawn, everything),
                "recall": share(everything, drawn),
                "profile_precision": share(profile >= DRAWN, outline),
                "profile_recall": share(outline, profile >= DRAWN),
                "inner_recall_of_creases": share(truth[CREASE], inner >= DRAWN),
                "truth_pixels": int(everything.sum()),
                "map_pixels": int(drawn.sum()),
                "profile_thickness": thickness(maps.intensity("profile"), PROFILE_RANGE[variant][0]),
                "profile_roughness": smoothness(profile, place, edge, outline),
            }
        )
        pictures.append(draw_edges(white, maps, colours={"inner": (0.8, 0.25, 0.0)}))
    return rows, np.hstack(pictures)


def illustration(mesh: Mesh, style: str, size: int) -> np.ndarray:
    """A mesh in a style, with both kinds of edges."""
    projected = project(mesh, fit_camera(mesh, direction=np.array(VIEW)), size, size)
    return illustrate(projected, style, parse_material("colour=0.9,0.45,0.2", None, None))


def styles_picture() -> np.ndarray:
    """Gooch's tones, a cartoon and hatching of a torus, for the README."""
    mesh = load_scene("torus:1152")
    return np.hstack([illustration(mesh, style, 300) for style in ("gooch", "cartoon", "hatch")])


HEADER = (
    "mesh",
    "variant",
    "precision",
    "recall",
    "profile: precision",
    "recall",
    "inner: recall of creases",
    "pixels of the mesh's edges",
    "of the map",
    "profile: thickness",
    "roughness",
)
SHARES = ("precision", "recall", "profile_precision", "profile_recall", "inner_recall_of_creases")


def table(scenes: list[dict]) -> str:
    """The report's table."""
    rows = [
        (
            scene["mesh"],
            row["variant"],
            *(f"{row[name]:.3f}" for name in SHARES),
            row["truth_pixels"],
            row["map_pixels"],
            f"{row['profile_thickness']:.2f}",
            f"{row['profile_roughness']:.3f}",
        )
        for scene in scenes
        for row in scene["rows"]
    ]
    return markdown_table(HEADER, rows)


def claim(scenes: list[dict]) -> str:
    """What the figures say about the source's claim."""
    pairs = [{row["variant"]: row for row in scene["rows"]} for scene in scenes]
    finer = sum(p["diagonal"]["profile_thickness"] < p["eight"]["profile_thickness"] for p in pairs)
    smoother = sum(p["diagonal"]["profile_roughness"] < p["eight"]["profile_roughness"] for p in pairs)
    return (
        f"The source calls the diagonal variant's edges finer and smoother than the eight neighbours'."
        f" They are finer on {finer} of {len(pairs)} meshes and smoother on {smoother}."
    )


def text(scenes: list[dict], command: str, size: int, missing: bool) -> str:
    """The report."""
    lines = [
        LICENCE,
        "# Edge maps against the mesh's edges",
        "",
        f"Written by `{command}` (`make edges`):",
        f"{size}x{size}, seen from {VIEW[0]:g}, {VIEW[1]:g}, {VIEW[2]:g}.",
        "",
        "Truth: silhouette, border and crease edges of the mesh (a dihedral angle from",
        f"{CREASE_DEGREES:g} degrees on), projected, where they are seen (`{classify_edges.__module__}`).",
        f"A pixel of the map is an edge from a strength of {DRAWN:g} on; both count as the same up",
        f"to {TOLERANCE:g} pixels. *Precision* is the share of the map's pixels that lie at an edge of the",
        "mesh, *recall* the share of the mesh's that the map found. *Profile* is the depth's map",
        "alone, against silhouettes and borders. *Thickness* is its edges' width in pixels at half",
        "of their own height, whatever the threshold; *roughness* how much their strength changes",
        "from pixel to pixel along an edge that is seen.",
        "",
        table(scenes),
        "",
        claim(scenes),
        "",
        "![the mesh's edges, the diagonal map, the eight neighbours' map](edges.png)",
        "",
        "Left the truth (silhouettes black, borders green, creases red), then both maps (profile",
        "black, inner red).",
    ]
    if missing:
        lines += ["", f"The real meshes are missing: pip could not fetch {PACKAGE}."]
    return "\n".join(lines) + "\n"


@click.command(help=__doc__)
@click.option(
    "--size", default=400, show_default=True, type=click.IntRange(16, 4096), help="Pixels each way."
)
@click.option("--mesh", "files", multiple=True, type=click.Path(exists=True, path_type=Path))
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(size: int, files: tuple[Path, ...], output: Path) -> None:
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        real = list(files) or real_meshes(Path(folder))
        scenes, pictures = [], []
        for name, source in [*((n, n) for n in GENERATED), *((path.name, str(path)) for path in real)]:
            rows, picture = measure(load_scene(source, CREASE_DEGREES if "." in source else None), size)
            scenes.append({"mesh": name, "rows": rows})
            pictures.append(picture)
        # A technical illustration and a cartoon of real meshes, or of what is there without them.
        for style, name in (("gooch", "nut.ply"), ("cartoon", "ant.ply")):
            mesh = next((load_scene(str(path), CREASE_DEGREES) for path in real if path.name == name), None)
            picture = illustration(mesh or load_scene("torus:1152"), style, size)
            write_png(output.with_name(f"{output.stem}_{style}.png"), picture)
    command = command_line("edges.report", size=size, mesh=[path.name for path in files])
    write_png(output.with_suffix(".png"), np.vstack(pictures))
    if output == REPORT:
        write_png(ROOT / "docs" / "images" / "styles.png", styles_picture())
    written = text(scenes, command, size, not real)
    write_report(output, written, {"command": command, "scenes": scenes})
    click.echo(written)


if __name__ == "__main__":
    main()
