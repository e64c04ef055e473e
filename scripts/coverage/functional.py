# SPDX-License-Identifier: Apache-2.0
"""Functional coverage over all simulations: combinations of stimuli that were driven, and that were not."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

from cocotb_tests.support.cover import FOLDER


@dataclass
class Cross:
    """
    A cross of all simulations.

    Attributes
    ----------
    name : str
    bins : mapping of str to sequence of str
    impossible : sequence of (str, mapping)
      Reasons, and the combinations that each excludes.
    hits : Counter
      By combination.
    """

    name: str
    bins: Mapping[str, Sequence[str]]
    impossible: Sequence[tuple[str, Mapping[str, Sequence[str]]]]
    hits: Counter[tuple[str, ...]] = field(default_factory=Counter)

    def reason(self, combination: tuple[str, ...]) -> str:
        """Why a combination cannot be; empty if it can."""
        values = dict(zip(self.bins, combination, strict=True))
        for why, where in self.impossible:
            if all(values[name] in chosen for name, chosen in where.items()):
                return why
        return ""

    @property
    def possible(self) -> list[tuple[str, ...]]:
        """Combinations that can be."""
        return [one for one in product(*self.bins.values()) if not self.reason(one)]

    def faults(self) -> list[str]:
        """Combinations that were not driven, and reasons that are none."""
        missing = [
            f"{self.name}: {', '.join(one)}: not driven" for one in self.possible if not self.hits[one]
        ]
        wrong = [
            f"{self.name}: {', '.join(one)}: driven, and yet {why}"
            for one in self.hits
            if (why := self.reason(one))
        ]
        return missing + wrong


def read_crosses(data: Path) -> list[Cross]:
    """The crosses that simulations left, each once; raises ``ValueError`` where two of a name differ."""
    found: dict[str, Cross] = {}
    for path in sorted((data / FOLDER).glob("*.json")):
        content = json.loads(path.read_text())
        cross = Cross(content["name"], content["bins"], content["impossible"])
        known = found.setdefault(cross.name, cross)
        if (known.bins, known.impossible) != (cross.bins, cross.impossible):
            raise ValueError(f"{cross.name} was run with other values before")
        for *key, count in content["hits"]:
            known.hits[tuple(key)] += count
    return list(found.values())
