# SPDX-License-Identifier: Apache-2.0
"""Write the tables of README.md from what the commands measured; ``--check`` only compares."""

from __future__ import annotations

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
REPORTS = ROOT / "docs" / "reports"


def replace_block(text: str, name: str, block: str) -> str:
    """
    Replace what stands between ``<!-- name begin -->`` and ``<!-- name end -->``.

    Raises
    ------
    ValueError
      The markers are not there.
    """
    begin, end = f"<!-- {name} begin -->\n", f"<!-- {name} end -->"
    head, found, rest = text.partition(begin)
    _, closed, tail = rest.partition(end)
    if not (found and closed):
        raise ValueError(f"README.md has no block {name}")
    return f"{head}{begin}{block}{end}{tail}"


def markdown(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    lines = [header, ("---",) * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def throughput() -> str:
    """Clocks per covered pixel: random triangles, linear and quadratic side by side with the peer."""
    rows = json.loads((REPORTS / "throughput.json").read_text())["rows"]
    random = [row for row in rows if row["case"] == "random"]
    by_order = {order: [row for row in random if row["order"] == order] for order in ("linear", "quadratic")}
    table = [
        (
            f"{linear['mean_pixels']:.1f} / {quadratic['mean_pixels']:.1f}",
            f"{linear['clocks_per_pixel']:.4f}",
            f"{quadratic['clocks_per_pixel']:.4f}",
            f"{linear['peer']}",
        )
        for linear, quadratic in zip(by_order["linear"], by_order["quadratic"], strict=True)
    ]
    return markdown(("mean pixels", "linear", "quadratic", "RasterIX, linear"), table)


def demo() -> str:
    """What ``make demo`` measured."""
    rows = json.loads((REPORTS / "demo.json").read_text())["rows"]
    table = [
        (
            str(row["triangles"]),
            str(row["exponent"]),
            str(row["pixels"]),
            str(row["clocks"]),
            f"{row['psnr_gouraud']:.1f} dB",
            f"**{row['psnr_quadratic']:.1f} dB**",
        )
        for row in rows
    ]
    return markdown(
        ("triangles", "exponent", "pixels", "clocks", "Gouraud to Phong", "quadratic to Phong"), table
    )


BLOCKS = {"throughput": throughput, "demo": demo}


def main() -> int:
    """Rewrite README.md, or with ``--check`` say whether that would change it."""
    path = ROOT / "README.md"
    old = path.read_text()
    new = old
    for name, block in BLOCKS.items():
        new = replace_block(new, name, block())
    if "--check" in sys.argv[1:]:
        if new != old:
            print("readme: error: README.md is older than docs/reports; run `make readme`", file=sys.stderr)
            return 2
        return 0
    path.write_text(new)
    return 0


if __name__ == "__main__":
    sys.exit(main())
