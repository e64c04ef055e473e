# SPDX-License-Identifier: Apache-2.0
"""``quadshade dump``: what a .qs file says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from quadshade.cli.interrupts import leave_at_once
from quadshade.cli.options import PATH


@click.command(short_help="Show what a packed picture (FRAME.qs) holds.")
@click.argument("path", metavar="FRAME.qs", type=PATH)
@click.option("--packets", type=click.IntRange(0), help="Show no more packets than this.  [default: all]")
def dump(path: Path, packets: int | None) -> None:
    """Show what a packed picture holds: header, shading state, and every packet with its fields and bits."""
    with leave_at_once():
        from quadshade.packing.frame_dump import packet_lines, summary_lines
        from quadshade.packing.frame_file import read_frame_file

    frame = read_frame_file(path)
    for line in summary_lines(frame, str(path)):
        click.echo(line)
    shown: Iterator[str] = packet_lines(frame, packets)
    for line in shown:
        click.echo(line)
