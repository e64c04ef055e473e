# SPDX-License-Identifier: Apache-2.0
"""Packets with vertices that are damaged, meshes at the limits, and how long a packet can take at most."""

from __future__ import annotations

import random
from functools import lru_cache

import numpy as np

from quadshade.contract.formats import SETUP_WORD_BITS, Formats
from quadshade.contract.triangles import ScreenTriangles
from quadshade.contract.vertex_program import (
    IMMEDIATE,
    LONGEST_PREFIX,
    OPERATIONS,
    PARAMETERS,
    PREFIXES,
    SCRATCH_AT,
    VERTEX_WORDS,
    evaluated,
)
from quadshade.golden.link.vertex_alu import shift_clocks
from quadshade.golden.link.vertex_machine import JUMP_CLOCKS

HEAD = 3 + 5 * len(PARAMETERS)
"""Bits of a packet of parameters."""

KINDS = ("flipped", "cut", "spliced", "random", "sparse", "zeros")


class Echo:
    """Stands for the packed words' unpacker: what goes in comes out, but for zeros."""

    within = False

    def feed(self, words: np.ndarray) -> np.ndarray:
        return np.asarray(words, np.uint32)[np.asarray(words) != 0]

    def reset(self) -> None:
        """Nothing is kept."""


def as_bits(words: np.ndarray) -> list[int]:
    """Bits of (n,) uint32 words, the lowest first."""
    return np.unpackbits(np.ascontiguousarray(words, "<u4").view(np.uint8), bitorder="little").tolist()


def as_words(bits: list[int]) -> np.ndarray:
    """(n,) uint32 words of bits, with zeros up to the end of the last one."""
    bits = [*bits, *([0] * (-len(bits) % 32))]
    return np.packbits(np.array(bits, np.uint8), bitorder="little").view("<u4").astype(np.uint32)


def parameters(draw: random.Random) -> list[int]:
    """Bits of a packet of parameters: small ones, as a packer chooses them, or any."""
    most = 31 if draw.random() < 0.3 else 6
    numbers = [draw.randint(0, most if index < len(PREFIXES) else 2) for index in range(len(PARAMETERS))]
    return [1, 1, 0, *(int(bit) for number in numbers for bit in f"{number:05b}")]


def damaged(draw: random.Random, kind: str, words: np.ndarray, most: int) -> np.ndarray:
    """
    Words of packets, damaged in one of :data:`KINDS` of ways, ``most`` words at most.

    What tells parameters stays, or other ones do: without any nothing is known of the tables.
    """
    bits = as_bits(words)
    head, body = bits[:HEAD], bits[HEAD:]
    if kind == "flipped":
        for _ in range(draw.choice((1, 1, 3, 20))):
            body[draw.randrange(len(body))] ^= 1
    elif kind == "cut":
        body = body[: draw.randrange(len(body))]
    elif kind == "spliced":
        pieces: list[int] = []
        while len(pieces) < min(len(body), 32 * most):
            start = draw.randrange(len(body))
            pieces += body[start : start + draw.choice((7, 40, 200))]
        body = pieces
    elif kind == "zeros":
        body = [0] * len(body)
    else:
        head = parameters(draw)
        # Few ones: short packets of triangles that share much. Many: long residuals.
        share = 0.5 if kind == "random" else draw.choice((0.2, 0.35, 0.65, 0.8))
        body = [int(draw.random() < share) for _ in range(32 * most)]
    return as_words(head + body)[:most]


def limit_mesh(formats: Formats, count: int, points: int, seed: int) -> ScreenTriangles:
    """
    Triangles over few points, at the ends of what numbers can be: some twice, some without an area.

    Corners lie on the screen's border or just beside pixels' centres, colours and depth are the least, the
    greatest, or any; more ``points`` than the board's tables hold come round again.
    """
    rng = np.random.default_rng(seed)
    pixel, size, channels = 1 << formats.subpixel_bits, 200, formats.num_channels
    ends = np.array([0, 1, pixel // 2, pixel // 2 + 1, size * pixel // 2, size * pixel - 1, size * pixel])
    any_places = rng.integers(0, size * pixel + 1, (points, 2))
    places = np.where(rng.random((points, 2)) < 0.3, rng.choice(ends, (points, 2)), any_places)
    near = rng.random(points) < 0.7
    # Most are near the one before: small triangles.
    steps = rng.integers(-12 * pixel, 12 * pixel + 1, (points, 2))
    places = np.clip(np.where(near[:, None], np.roll(places, 1, axis=0) + steps, places), 0, size * pixel)
    top, far = 2.0**formats.value_bits - 1, 2.0**formats.depth_bits - 1
    colours = np.where(
        rng.random((points, channels)) < 0.5, rng.choice([0.0, top]), rng.uniform(0, top, (points, channels))
    )
    depth = np.where(rng.random(points) < 0.5, rng.choice([0.0, far], points), rng.uniform(0, far, points))
    corners = np.arange(count)[:, None] % points + np.arange(3)
    corners[rng.random(count) < 0.2] = rng.integers(0, points, 3)
    corners[1:][rng.random(count - 1) < 0.1] = corners[0]
    corners %= points
    of = np.swapaxes(colours[corners], 1, 2)
    middles = (of[:, :, (0, 0, 1)] + of[:, :, (1, 2, 2)]) / 2 + rng.uniform(-0.1, 0.1, (count, 1, 1)) * top
    return ScreenTriangles(
        size,
        size,
        places[corners],
        np.clip(np.concatenate([of, middles], axis=2), 0, top),
        rng.integers(0, formats.max_order + 1, (count, channels)),
        depth[corners] if formats.with_depth else None,
        tuple(f"c{index}" for index in range(channels)),
    )


CONDITIONS = ("jz", "jnz", "jn", "jnn")
CLEARS = SCRATCH_AT // VERTEX_WORDS
"""Rounds of the loop that empties the tables, the only one that is not counted by ``loop``."""


def _own_clocks(row: tuple[int, int, int, int, int]) -> int:
    """Clocks of an instruction by itself, with every step that it may take."""
    operation, mode, operand, count, clocks = row
    name, waits = OPERATIONS[operation], int(mode != IMMEDIATE)
    times = 63 if waits else operand
    if name == "muli":
        return clocks + count // 2
    if name in ("shl", "shr"):
        return clocks + waits + max(shift_clocks(np.int64(by)) for by in (range(64) if waits else (times,)))
    if name in ("get", "take"):
        # A bit a clock, and one for each word that is fetched.
        return clocks + waits + max(times, 1) + 2
    if name == "ones":
        return clocks + LONGEST_PREFIX + 1
    # Before bits go out, those before have to, two a clock, and zeros up to the end of their word.
    return clocks + (SETUP_WORD_BITS + 2 if name in ("put", "word") else 0)


@lru_cache
def most_clocks(formats: Formats) -> int:
    """
    No packet takes more clocks than this from its first bit on, but for words that it waits for.

    The longest way through the program, which jumps back in counted loops alone, and in the one that empties
    the tables.
    """
    code = evaluated(formats)
    names = [OPERATIONS[row[0]] for row in code]
    known: dict[tuple[int, int], int] = {}

    def way(pc: int, end: int) -> int:
        """Clocks of the longest way to an instruction, or to the end of the packet or the subroutine."""
        if pc in (0, end):
            return 0
        if (pc, end) not in known:
            known[pc, end] = longest(pc, end)
        return known[pc, end]

    def longest(pc: int, end: int) -> int:
        name, target, here = names[pc], code[pc][2], _own_clocks(code[pc])
        jump = here + JUMP_CLOCKS
        if name == "ret":
            return jump
        if name == "raw":
            return here
        if name == "jmp":
            return jump + way(target, end)
        if name == "call":
            return jump + way(target, -1) + way(pc + 1, end)
        if name == "loop" or (name in CONDITIONS and target <= pc):
            rounds = code[pc][3] if name == "loop" else CLEARS
            return rounds * (jump + way(target, pc)) + here + way(pc + 1, end)
        behind = here + way(pc + 1, end)
        return max(behind, jump + way(target, end)) if name in CONDITIONS else behind

    # From the end on, so that no way is deep.
    for pc in reversed(range(1, len(code))):
        way(pc, -1)
    return _own_clocks(code[0]) + way(1, -1)
