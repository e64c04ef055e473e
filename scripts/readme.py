# SPDX-License-Identifier: Apache-2.0
"""Write the tables of README and pages from what the commands measured; ``--check`` only compares."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from quadshade.contract.formats import Formats
from quadshade.files.markdown import markdown_table
from quadshade.synthesis import table
from scripts.generate_vhdl import axis

ROOT = Path(__file__).resolve().parents[1]
REPORTS = ROOT / "docs" / "reports"
STREAM_WIDTHS = (32, 64, 128)
SUMMARY_WIDTHS = (32, 128)
"""Those of which synth/resources.json has a row on this device."""
SUMMARY_DEVICE = "ecp5-25k-6"


def replace_block(text: str, name: str, block: str, page: str) -> str:
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
        raise ValueError(f"{page} has no block {name}")
    return f"{head}{begin}{block}\n{end}{tail}"


def throughput() -> str:
    """Clocks per covered pixel: random triangles, linear and quadratic, by the stream's width."""
    rows = json.loads((REPORTS / "throughput.json").read_text())["rows"]
    random = [row for row in rows if row["case"] == "random"]
    orders = ("linear", "quadratic")
    head = [f"{order}, {width} bits" for order in orders for width in STREAM_WIDTHS]

    def column(order: str, width: int) -> list[dict]:
        return [row for row in random if (row["order"], row["stream_width"]) == (order, width)]

    columns = [column(order, width) for order in orders for width in STREAM_WIDTHS]
    lines = []
    for sizes in zip(*columns, strict=True):
        means = f"{sizes[0]['mean_pixels']:.1f} / {sizes[-1]['mean_pixels']:.1f}"
        clocks = [f"{row['clocks_per_pixel']:.4f}" for row in sizes]
        lines.append((means, *clocks, f"{sizes[0]['peer']}"))
    return markdown_table(("mean pixels", *head, "RasterIX, linear"), lines)


def resources() -> str:
    """What place-and-route measured."""
    header, rows = table.cells(table.read_table(ROOT))
    return markdown_table(header, rows, right=header[3:])


def summary() -> str:
    """The quadratic core on one device: clocks a pixel, area and clock by the stream's width."""
    clocks = json.loads((REPORTS / "throughput.json").read_text())["rows"]
    areas = table.read_table(ROOT)
    rows = []
    for width in SUMMARY_WIDTHS:
        row = table.find_row(areas, SUMMARY_DEVICE, {"stream_width": width})
        sizes = [
            line
            for line in clocks
            if (line["case"], line["order"], line["stream_width"]) == ("random", "quadratic", width)
        ]
        rows.append(
            (
                f"{width} bits" + (", the default" if width == Formats().stream_width else ""),
                *(f"{size['clocks_per_pixel']:.2f}" for size in sizes[:3]),
                *(str(row["area"][kind]) for kind in ("lut4", "ff", "bram", "dsp")),
                f"{row['fmax_mhz']:.0f}",
            )
        )
    means = [f"{size['mean_pixels']:.0f}" for size in sizes[:3]]
    header = ("set-up stream", f"clocks a pixel, {means[0]} pixels a triangle", *means[1:])
    header += ("LUT4", "flip-flops", "block RAM", "multipliers", "MHz")
    text = (
        "Three quadratic colours and depth on an ECP5 (LFE5U-25F, speed grade 6), after place-and-route:\n\n"
    )
    return text + markdown_table(header, rows, right=header[1:])


def demo() -> str:
    """What ``make demo`` measured."""
    rows = json.loads((REPORTS / "demo.json").read_text())["rows"]
    shadings = tuple(rows[0]["psnr"])
    lines = []
    for row in rows:
        values = [f"{value:.1f} dB" for value in row["psnr"].values()]
        clocks = " or ".join(map(str, sorted(set(row["clocks"].values()))))
        counts = (str(row["triangles"]), str(row["exponent"]), str(row["pixels"]), clocks)
        lines.append((*counts, *values[:-1], f"**{values[-1]}**"))
    return markdown_table(("triangles", "exponent", "pixels", "clocks", *shadings), lines)


BLOCKS = {
    "README.md": {"demo": demo, "summary": summary},
    "docs/explanation/numbers.md": {"throughput": throughput, "resources": resources},
    "docs/reference/axis.md": {"pixel": axis.pixel_table, "registers": axis.register_table},
}


def rewritten(name: str) -> str:
    """A page with its tables as they are measured."""
    text = (ROOT / name).read_text()
    for block, make in BLOCKS[name].items():
        text = replace_block(text, block, make(), name)
    return text


def main() -> int:
    """Rewrite the pages, or with ``--check`` say whether that would change them."""
    for name in BLOCKS:
        path = ROOT / name
        new = rewritten(name)
        if "--check" in sys.argv[1:]:
            if new != path.read_text():
                print(
                    f"readme: error: {name} is older than what was measured; run `make readme`",
                    file=sys.stderr,
                )
                return 2
        else:
            path.write_text(new)
    return 0


if __name__ == "__main__":
    sys.exit(main())
