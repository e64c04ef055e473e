# SPDX-License-Identifier: Apache-2.0
"""
Colour across edges: how far the first derivative jumps there, and what stepping at fractional edges costs.

The eye sees a jump of the intensity's derivative as a Mach band (Phong, "Illumination for Computer Generated
Pictures"). It is measured along shared edges, at right angles to them, in grey levels per pixel. The loop of
Abbas et al., section 5, takes a scanline's first colour at the fractional edge instead of the first pixel's
centre: its error, and its flicker while a sphere turns slowly, stand beside those of pixel centres.
Writes docs/reports/continuity.md, .json and .png.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from quadshade.contract.formats import Formats
from quadshade.contract.triangles import Pixels
from quadshade.engine import draw
from quadshade.files.markdown import markdown_table
from quadshade.image import visible
from quadshade.shading import sample
from quadshade.shading.reference import interpolated, phong
from scripts.experiments.continuity.mach_bands import (
    ALLOWED,
    EXPONENTS,
    PLACES,
    SCENES,
    SHADINGS,
    barycentric,
    mach_bands,
    material_of,
    shades,
    view,
)
from scripts.experiments.report_writer import (
    REPORTS,
    command_line,
    output_option,
    paragraph,
    write_report,
)
from scripts.one_line_errors import one_line_errors

REPORT = REPORTS / "continuity.md"
STEPPINGS = ("centre", "fractional")


def decibels(off: np.ndarray) -> float:
    """PSNR of errors in grey levels."""
    return float(10 * np.log10(255**2 / np.mean(off**2)))


def on_screen(pixels: Pixels, value: np.ndarray, size: int) -> np.ndarray:
    """(size, size) one channel of the visible pixels, NaN where there is none."""
    shown = visible(pixels, size, size)
    picture = np.full((size, size), np.nan)
    picture[shown >= 0] = value[shown[shown >= 0], 0]
    return picture


def frames(scene: str, exponent: float, size: int, count: int, degrees: float) -> dict[str, np.ndarray]:
    """(count, size, size) of every stepping, of the float references, of Phong shading rounded."""
    material = material_of(exponent)
    found: dict[str, list] = {name: [] for name in (*STEPPINGS, "quadratic in float", "phong")}
    for frame in range(count):
        projected = view(scene, size, frame * degrees)
        triangles = sample(projected, "quadratic", None, material)
        for stepping in STEPPINGS:
            pixels = draw(triangles, Formats(), fractional=stepping == "fractional").pixels
            found[stepping].append(on_screen(pixels, pixels.value, size))
        place = pixels.triangle, pixels.x, pixels.y
        found["quadratic in float"].append(on_screen(pixels, interpolated(triangles, *place), size))
        found["phong"].append(on_screen(pixels, phong(projected, *place, None, material), size))
    stacks = {name: np.array(pictures) for name, pictures in found.items()}
    return stacks | {"phong, rounded": np.rint(stacks["phong"])}


def steppings(size: int, count: int, degrees: float) -> list[dict]:
    """Records of what stepping costs: PSNR against both references, flicker against Phong shading."""
    rows = []
    for scene in SCENES:
        for exponent in EXPONENTS:
            stacks = frames(scene, exponent, size, count, degrees)
            for name in (*STEPPINGS, "quadratic in float", "phong, rounded"):
                off = {
                    reference: stacks[name] - stacks[reference]
                    for reference in ("quadratic in float", "phong")
                }
                seen = np.isfinite(off["phong"])
                # Second difference in time, of pixels that are covered in three frames.
                shaken = np.diff(off["phong"], n=2, axis=0)
                shaken = shaken[np.isfinite(shaken)]
                exact = name == "quadratic in float"
                rows.append(
                    {
                        "scene": scene,
                        "exponent": exponent,
                        "stepping": name,
                        "size": size,
                        "frames": count,
                        "degrees": degrees,
                        "psnr_quadratic": None if exact else decibels(off["quadratic in float"][seen]),
                        "psnr_phong": decibels(off["phong"][seen]),
                        "largest_quadratic": float(np.abs(off["quadratic in float"][seen]).max()),
                        "flicker": float(np.sqrt(np.mean(shaken**2))),
                        "flicker_p99": float(np.percentile(np.abs(shaken), 99)),
                    }
                )
    return rows


def plot(path: Path) -> None:
    """What the eye makes of it: the Laplacian of each shading over one sphere, and of both steppings."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from scipy.ndimage import laplace

    size, scene, exponent = 300, "sphere:168", 50.0
    projected = view(scene, size)
    material = material_of(exponent)
    drawn = draw(sample(projected, "flat", None, material), Formats()).pixels
    corners = projected.vertices[drawn.triangle] / 256.0
    centres = np.stack([drawn.x, drawn.y], axis=1) + 0.5
    weights = barycentric(corners, centres)
    pictures = {
        name: on_screen(drawn, shade(drawn.triangle, weights)[:, None], size)
        for name, shade in shades(projected, exponent).items()
    }
    figure, axes = pyplot.subplots(2, 3, figsize=(12, 8.2), layout="constrained")
    for axis, (name, picture) in zip(axes.ravel(), pictures.items(), strict=False):
        curved = axis.imshow(laplace(picture), cmap="RdBu", vmin=-3, vmax=3)
        axis.set_title(name, fontsize=10)
    triangles = sample(projected, "quadratic", None, material)
    for axis, stepping in zip(axes[1, 1:], STEPPINGS, strict=True):
        pixels = draw(triangles, Formats(), fractional=stepping == "fractional").pixels
        off = pixels.value - interpolated(triangles, pixels.triangle, pixels.x, pixels.y)
        shown = axis.imshow(on_screen(pixels, off, size), cmap="PuOr", vmin=-5, vmax=5)
        axis.set_title(f"quadratic as drawn, {stepping}: error", fontsize=10)
    for axis in axes.ravel():
        axis.set_axis_off()
    figure.colorbar(curved, ax=axes[0], shrink=0.8, label="Laplacian, grey levels per square pixel")
    figure.colorbar(shown, ax=axes[1], shrink=0.8, label="off the float quadratic, grey levels")
    figure.suptitle(f"{scene}, exponent {exponent:g}: lines in the Laplacian are Mach bands")
    figure.savefig(path, dpi=90, metadata={"Software": None})
    pyplot.close(figure)


def jump_table(rows: list[dict]) -> str:
    """RMS and largest jump, a row a scene and exponent, a column a shading."""
    found = {(row["scene"], row["exponent"], row["shading"]): row for row in rows}
    lines = []
    for scene, exponent in dict.fromkeys((row["scene"], row["exponent"]) for row in rows):
        own = [found[scene, exponent, shading] for shading in SHADINGS]
        cells = (f"{row['rms']:.3f} / {row['largest']:.2f}" for row in own)
        lines.append((scene, f"{exponent:g}", *cells, str(own[SHADINGS.index("adaptive")]["triangles"])))
    return markdown_table(("scene", "exponent", *SHADINGS, "triangles, adaptive"), lines)


def stepping_table(rows: list[dict]) -> str:
    """PSNR and flicker, a row a scene and exponent and way of drawing."""
    lines = [
        (
            row["scene"],
            f"{row['exponent']:g}",
            row["stepping"],
            "" if row["psnr_quadratic"] is None else f"{row['psnr_quadratic']:.1f} dB",
            f"{row['psnr_phong']:.1f} dB",
            f"{row['largest_quadratic']:.1f}",
            f"{row['flicker']:.2f}",
            f"{row['flicker_p99']:.2f}",
        )
        for row in rows
    ]
    header = (
        "scene",
        "exponent",
        "drawn",
        "to float quadratic",
        "to Phong",
        "largest off quadratic",
        "flicker, RMS",
        "99 %",
    )
    return markdown_table(header, lines)


def span(values: list[float], form: str = ".1f") -> str:
    """Least and largest of some numbers."""
    return f"{min(values):{form}} to {max(values):{form}}"


def less(bands: list[dict], shading: str, place: int) -> str:
    """Gouraud's RMS jump over that of a shading, its range over the scenes, at one of ``EXPONENTS``."""
    own, other = (
        [row["rms"] for row in bands if (row["shading"], row["exponent"]) == (name, EXPONENTS[place])]
        for name in ("gouraud", shading)
    )
    return span([one / two for one, two in zip(own, other, strict=True)])


def report(results: dict) -> str:
    """The report's text, from nothing but the numbers of the JSON file."""
    bands, drawn = results["mach_bands"], results["steppings"]
    by = {name: [row for row in drawn if row["stepping"] == name] for name in (*STEPPINGS, "phong, rounded")}
    pairs = list(zip(by["centre"], by["fractional"], strict=True))
    first, second = bands[0], drawn[0]
    head = f"""
Written by `{results["command"]}` (`make continuity`). Grey material, default light, orthographic view.
"""
    bands_text = f"""
At {len(PLACES)} places of every edge that two triangles share (whose normals agree there and lie within 60°
of the viewer: towards the silhouette any shading is as steep as the surface), the derivative at right angles
to the edge is taken on both sides, {first["size"]} x {first["size"]} pixels, unrounded; its jump is
in grey levels per pixel. RMS weighted by length / largest. All shadings are continuous in value.
`quadratic-specular` interpolates N·L and N·H and takes the power at the pixel; `adaptive` divides where the
centre is off by more than {ALLOWED:g} grey levels (Abbas et al., section 4), drawn as quadratics.
"""
    found = f"""
Times less than Gouraud's, at exponent {EXPONENTS[0]:g} and {EXPONENTS[1]:g}: quadratic
{less(bands, "quadratic", 0)} and {less(bands, "quadratic", 1)} (below 1 it is worse: a quadratic through a
highlight narrower than its triangle overshoots), adaptive {less(bands, "adaptive", 0)} and
{less(bands, "adaptive", 1)}, power at the pixel {less(bands, "quadratic-specular", 0)} and
{less(bands, "quadratic-specular", 1)}, Phong {less(bands, "phong", 0)} and {less(bands, "phong", 1)}: Phong
shading is no zero either, its normals are continuous across an edge, their derivatives are not, and the line
where the light sets is a jump in any shading but Gouraud's and the quadratic, which smear it.
"""
    steps_text = f"""
`quadshade render --stepping fractional` is the paper's own loop: a scanline's first pixel takes the colour at
the fractional major edge, so a pixel is off by up to one step along the scanline. {second["frames"]} frames,
{second["degrees"]:g}° apart, {second["size"]} x {second["size"]} pixels, 8 bits, golden model. Flicker is
the second difference in time of the error against Phong shading, where a pixel is covered in three frames;
rounding to 8 bits alone makes the last row of each scene.
"""
    loss = [one["psnr_phong"] - other["psnr_phong"] for one, other in pairs]
    own_loss = [one["psnr_quadratic"] - other["psnr_quadratic"] for one, other in pairs]
    shake = [other["flicker"] / one["flicker"] for one, other in pairs]
    cost = f"""
Against the float quadratic the fractional loop loses {span(own_loss)} dB, against Phong shading
{span(loss)} dB, and it flickers {span(shake)} times as much. Pixel centres are the default.
"""
    return "\n\n".join(
        [
            "# Colour across edges, and at them",
            paragraph(head),
            "![Laplacian of every shading, and the error of both steppings](continuity.png)",
            "## Mach bands",
            paragraph(bands_text),
            jump_table(bands),
            paragraph(found),
            "## Stepping at the fractional edge",
            paragraph(steps_text),
            stepping_table(drawn),
            paragraph(cost) + "\n",
        ]
    )


@click.command()
@click.option("--size", default=512, show_default=True, help="Pixels of the Mach-band measure's screen.")
@click.option("--frames", "count", default=8, show_default=True, help="Frames of the turning scenes.")
@click.option("--frame-size", default=256, show_default=True, help="Pixels of these frames.")
@click.option("--degrees", default=0.25, show_default=True, help="Turn between two frames.")
@output_option(REPORT)
@one_line_errors(REPORT.stem)
def main(size: int, count: int, frame_size: int, degrees: float, output: Path) -> None:
    """Measure Mach bands, and what the paper's fractional-edge stepping costs."""
    command = command_line(
        "continuity.report", size=size, frames=count, frame_size=frame_size, degrees=degrees
    )
    results = {
        "command": command,
        "mach_bands": mach_bands(size, SCENES),
        "steppings": steppings(frame_size, count, degrees),
    }
    write_report(output, report(results), results)
    plot(output.with_suffix(".png"))


if __name__ == "__main__":
    main()
