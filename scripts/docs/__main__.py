# SPDX-License-Identifier: Apache-2.0
"""Build the documentation as a static site: ``python -m scripts.docs``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import click

from quadshade.errors import QuadshadeError
from scripts.docs.entity import ROOT
from scripts.docs.site import build_site
from scripts.docs.timing_diagram import diagram


@click.command()
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=ROOT / "build" / "docs",
    help="Folder of the site.",
)
def main(output: Path) -> None:
    """Build the documentation from docs/, the RTL, the docstrings and the command line."""
    try:
        build_site(output, diagram)
    except (QuadshadeError, FileNotFoundError) as problem:
        click.echo(f"docs: error: {problem}", err=True)
        sys.exit(2)
    served = shlex.quote(str(output))
    click.echo(f"{output}: python3 -m http.server -d {served} 8000, then http://localhost:8000/")


if __name__ == "__main__":
    main()
