# SPDX-License-Identifier: Apache-2.0
"""``quadshade compare``: how much two pictures differ."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path

import click

from quadshade.cli.options import PATH


@click.command(short_help="Compare two pictures: PSNR, SSIM, the largest error.")
@click.argument("first", type=PATH)
@click.argument("second", type=PATH)
@click.option("--heatmap", type=PATH, help="Write the error at every pixel as a PNG with a legend.")
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON.")
def compare(first: Path, second: Path, heatmap: Path | None, as_json: bool) -> None:
    """
    Compare two pictures of one size: PSNR, SSIM and the largest error.

    \b
    quadshade compare quadratic.png phong.png
    quadshade compare quadratic.png phong.png --heatmap error.png
    quadshade compare quadratic.png phong.png --json
    """
    from quadshade.files.atomic import check_writable, write_atomically
    from quadshade.image import compare as compare_pictures
    from quadshade.image import read_picture, write_heatmap

    check_writable(heatmap, inputs=[first, second])
    one, other = read_picture(first), read_picture(second)
    result = compare_pictures(one, other)
    if heatmap is not None:
        write_atomically(heatmap, lambda temporary: write_heatmap(temporary, one, other))
    if as_json:
        # JSON has no infinity: identical pictures have no PSNR.
        click.echo(
            json.dumps({**asdict(result), "psnr": result.psnr if math.isfinite(result.psnr) else None})
        )
        return
    click.echo(f"PSNR           {'identical' if math.isinf(result.psnr) else f'{result.psnr:.2f} dB'}")
    click.echo(f"SSIM           {'picture too small' if result.ssim is None else f'{result.ssim:.5f}'}")
    at = f" at {result.largest_at[0]},{result.largest_at[1]}" if result.largest_error else ""
    click.echo(f"largest error  {result.largest_error} of 255{at}")
    click.echo(f"pixels         {result.differing} of {result.pixels} differ")
