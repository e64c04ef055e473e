# SPDX-License-Identifier: Apache-2.0
"""
Set-ups a second by the methods of the literature, and what binds them: a part of ``host_speed.py``.

Beside the rates stand the instructions of each method's loop, as compiled, and what one division, root and
product takes on this processor. The quickest that a loop can be is its products one after the other.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from llvmlite import binding
from numba import njit

from quadshade.setup.literature.kernels import LANES, METHODS, OPTIONS, kernel_arguments, loop
from scripts.experiments.report_writer import met, paragraph

SETUPS = 2 * LANES
"""Triangles of the measurement, set up over and over: 12 or 24 KiB, which stay in the innermost cache."""
TYPES = {"float64": np.float64, "float32": np.float32}
_KEYS = {"float64": "setups", "float32": "setups_float32"}
PAPER = {"abbas": 42.0, "unit_triangle": 40.3, "x_shading": 12.7}
"""Seconds of 10**8 set-ups, Barrera et al., Table 1 (Abbas, Hast, X-shading)."""
RATIO, RATE = 3.3, 5e6
"""What X-shading is asked for: Abbas et al.'s set-ups in the time of one of its own, and set-ups a second."""

PARTS = {"division": 16, "root": 8, "product": 48}
"""Instructions of one kind that a lane of the loops below has, all but independent of each other."""
FOUR = 4 * LANES
"""Three rows that they read and one that they write."""
KINDS = {"div": "divisions", "sqrt": "roots", "mul": "products", "add": "sums", "sub": "sums"}
"""Instructions by the beginning of their names; a fused one is a product."""
VECTORS = {"zmm": 64, "ymm": 32, "xmm": 16}
"""Bytes of a register."""
ARITHMETIC = re.compile(r"\sv?(?:fn?m(add|sub)\d+|(div|sqrt|mul|add|sub))([ps])[sd]\s.*%([xyz]mm)")

SHOWN = "abbas", "unit_triangle", "x_shading", "x_shading_stored"
"""Methods whose loop has no other loop inside."""


@loop
def divide(flat: np.ndarray) -> None:
    """16 divisions a lane."""
    for block in range(len(flat) // FOUR):
        for lane in range(LANES):
            at = block * FOUR + lane
            one, two, three = flat[at], flat[at + LANES], flat[at + 2 * LANES]
            four, five = one + two, two + three
            total = one / two + two / one + one / three + three / one + two / three + three / two
            total += one / four + four / one + two / four + four / two + three / four + four / three
            flat[at + 3 * LANES] = total + one / five + five / one + two / five + five / two


@loop
def take_roots(flat: np.ndarray) -> None:
    """8 roots a lane."""
    for block in range(len(flat) // FOUR):
        for lane in range(LANES):
            at = block * FOUR + lane
            one, two, three = flat[at], flat[at + LANES], flat[at + 2 * LANES]
            total = np.sqrt(one) + np.sqrt(two) + np.sqrt(three) + np.sqrt(one + two) + np.sqrt(one + three)
            total += np.sqrt(two + three) + np.sqrt(one + one + two)
            flat[at + 3 * LANES] = total + np.sqrt(one + one + three)


@loop
def multiply(flat: np.ndarray) -> None:
    """48 products a lane, fused with sums where the processor can."""
    for block in range(len(flat) // FOUR):
        for lane in range(LANES):
            at = block * FOUR + lane
            one, two, three = flat[at], flat[at + LANES], flat[at + 2 * LANES]
            a, b, c, d, e, f = one, two, three, one, two, three
            for _ in range(8):
                a, b, c = a * two + one, b * three + one, c * one + two
                d, e, f = d * three + two, e * one + three, f * two + three
            flat[at + 3 * LANES] = a + b + c + d + e + f


def least_seconds(works: Mapping[Any, Callable[[], object]], repeats: int) -> dict[Any, float]:
    """
    Least seconds of processor time that one call of each took (of all threads: more than one would not help).

    They take turns, so that what else the machine does meets all of them.
    """
    best = dict.fromkeys(works, float("inf"))
    for work in works.values():
        work()
    for _ in range(repeats):
        for name, work in works.items():
            start = time.process_time()
            work()
            best[name] = min(best[name], time.process_time() - start)
    return best


def setup_arguments(count: int, dtype: type[np.floating[Any]] = np.float64) -> tuple:
    """Random triangles with normals up to about 45 degrees apart, for the kernels of ``METHODS``."""
    rng = np.random.default_rng(1)
    normals = np.array([0.0, 0.0, 1.0]) + rng.normal(scale=0.25, size=(count, 3, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return kernel_arguments(rng.uniform(0, 100, (count, 3, 2)), normals, np.array([0.36, 0.48, 0.80]), dtype)


@njit
def again(kernel, rounds, arguments):
    """Run a kernel many times."""
    for _ in range(rounds):
        kernel(*arguments)


def assembly(kernel: Any, arguments: tuple) -> str:
    """What a kernel is compiled to for these arguments; what comes from the disk's cache cannot be read."""
    compiled = njit(**OPTIONS)(kernel.py_func)
    compiled(*arguments)
    return str(compiled.inspect_asm(compiled.signatures[0]))


def instructions(text: str, itemsize: int) -> dict[str, int]:
    """
    Arithmetic instructions of the innermost loop in assembly, by ``KINDS``, and the bytes of its registers.

    The loop is the stretch between labels with the most of them. Empty where the processor is none whose
    assembly is known. ``itemsize`` is that of the numbers.
    """
    stretches = [Counter[str]()]
    for line in text.splitlines():
        if line and not line[0].isspace():
            stretches.append(Counter())
        elif found := ARITHMETIC.search(line):
            fused, plain, packed, register = found.groups()
            stretches[-1]["products" if fused else KINDS[plain]] += 1
            stretches[-1]["bytes"] = VECTORS[register] if packed == "p" else itemsize
    return dict(max(stretches, key=lambda stretch: sum(stretch.values()) - stretch["bytes"]))


def processor() -> str:
    """What the processor calls itself, and what the compiler takes it for."""
    path = Path("/proc/cpuinfo")
    names = re.findall(r"^model name\s*:\s*(.+)$", path.read_text(), re.MULTILINE) if path.exists() else []
    return f"{(names or ['a processor'])[0].strip()} ({binding.get_host_cpu_name()})"


def setups(rounds: int, repeats: int) -> dict[str, dict[str, float]]:
    """Set-ups per second of each method: ``setups`` in float64, ``setups_float32``."""
    works = {}
    for name, dtype in TYPES.items():
        arguments = setup_arguments(SETUPS, dtype)
        works |= {(name, way): partial(again, kernel, rounds, arguments) for way, kernel in METHODS.items()}
    seconds = least_seconds(works, repeats)
    return {_KEYS[name]: {way: SETUPS * rounds / seconds[name, way] for way in METHODS} for name in TYPES}


def bounds(rounds: int, repeats: int) -> dict[str, dict]:
    """By type: seconds of one division, root and product of a lane, and each method's instructions."""
    works, counts = {}, {}
    for name, dtype in TYPES.items():
        arguments = setup_arguments(SETUPS, dtype)
        size = dtype().itemsize
        counts[name] = {way: instructions(assembly(METHODS[way], arguments), size) for way in SHOWN}
        flat = np.linspace(0.5, 0.9, 4 * SETUPS).astype(dtype)
        for part, kernel in zip(PARTS, (divide, take_roots, multiply), strict=True):
            works[name, part] = partial(again, kernel, rounds, (flat,))
    seconds = least_seconds(works, repeats)
    return {
        name: {
            "seconds": {part: seconds[name, part] / (rounds * SETUPS * PARTS[part]) for part in PARTS},
            "instructions": counts[name],
        }
        for name in TYPES
    }


EXPLAINED = """
From vertices, normals and a directional light to the six coefficients (`setup/literature/kernels.py`),
counted as in Barrera et al., Table 1: the first three compute and normalise the normals in the middles of
the edges, as printed (their equations 1-6); `general` solves six equations by elimination. `x_shading` is
their equation 32; `x_shading_stored` takes Ni · Nj from the mesh, as their section 4 proposes. All are
compiled to vector instructions, `general` excepted, and work in the innermost cache, so that memory does not
bind.
"""


def setup_tables(results: dict) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
    """Title, header and rows of the report's tables of set-ups."""
    double, single = results["setups"], results["setups_float32"]
    rows = []
    for way, rate in double.items():
        ratios = single[way] / single["abbas"], rate / double["abbas"]
        paper = f"{PAPER['abbas'] / PAPER[way]:.2f}" if way in PAPER else ""
        goal = [met(rate, RATE)] if way == "x_shading" else []
        if way.startswith("x_shading"):
            goal += [met(ratios[1], RATIO), f"float32 {met(ratios[0], RATIO)}"]
        cells = f"{single[way] / 1e6:.1f}", f"{ratios[0]:.2f}", f"{rate / 1e6:.1f}", f"{ratios[1]:.2f}"
        plain = f"{rate / results['plain']['setups'][way]:,.0f}"
        rows.append((f"`{way}`", *cells, paper, plain, ", ".join(goal)))
    header = (
        "method", "float32, million a second", "to Abbas", "float64, million a second", "to Abbas",
        "Barrera's Table 1", "to a plain loop", "target",
    )  # fmt: skip
    tables = [("Set-ups", header, rows)]

    rows = []
    for name in TYPES:
        for way in SHOWN:
            count = results["bounds"][name]["instructions"][way]
            if count:
                kinds = (str(count.get(kind, 0)) for kind in ("divisions", "roots", "products", "sums"))
                spent = (f"{1e9 * value:.1f}" for value in _vector_times(results, name, way))
                rows.append((name, f"`{way}`", str(count["bytes"]), *kinds, *spent))
    header = (
        "type", "method", "bytes", "divisions", "roots", "products", "sums", "ns", "ns, divider alone",
        "ns, products alone",
    )  # fmt: skip
    return [*tables, ("What binds the set-ups", header, rows)]


def _vector_times(results: dict, name: str, way: str) -> tuple[float, float, float]:
    """Seconds of a register full of set-ups: all of it, its divisions and roots, its products."""
    bound = results["bounds"][name]
    count, one = bound["instructions"][way], bound["seconds"]
    lanes = count["bytes"] / TYPES[name]().itemsize
    divider = count.get("divisions", 0) * one["division"] + count.get("roots", 0) * one["root"]
    products = count.get("products", 0) * one["product"]
    return lanes / results[_KEYS[name]][way], lanes * divider, lanes * products


def what_binds(results: dict) -> str:
    """What the instructions say, in words."""
    most = []
    for name in TYPES:
        if results["bounds"][name]["instructions"]["x_shading"]:
            whole = _vector_times(results, name, "abbas")[0]
            limits = (f"{whole / _vector_times(results, name, way)[2]:.2f}" for way in SHOWN[2:])
            most.append(f"{' and '.join(limits)} in {name}")
    text = f"""
    Instructions of one register full of set-ups, as compiled; a product fused with a sum is a product.
    Beside its time stand what its divisions and roots alone take on this processor, and its products
    alone. Abbas et al.'s formulas wait for the divider, X-shading for the multipliers. The divider of a
    processor is about as much faster in float32 as a register holds more numbers, the multipliers are not
    faster: so the ratio is lower there. If nothing but their products took time, X-shading and the stored
    one would be as many times as fast as Abbas et al.: {", ".join(most)}. No code with these products has
    a higher ratio.

    Three forms of X-shading were tried: equation 22 as printed, through gradients, and with the shared
    product that stands in the code, which has the fewest products. Barrera et al. timed a Pentium 4 of
    1.8 GHz: their X-shading saves 497 clocks to Hast's set-up. Over three roots and nine divisions these
    are 41 clocks each, over three roots and three divisions 83: so theirs, too, will divide each of a
    normal's three components.
    """
    return "\n\n".join(paragraph(part) for part in text.split("\n\n"))
