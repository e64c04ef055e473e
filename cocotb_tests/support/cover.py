# SPDX-License-Identifier: Apache-2.0
"""
Functional coverage: which combinations of a stimulus the benches have driven, for ``make coverage``.

Of cocotb-coverage only its crosses would be used here; it brings a solver for random stimuli along, whose
last release is of 2018, and a database within a process, where each configuration is a simulation of its own.
"""

from __future__ import annotations

import json
import os
import uuid
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

FOLDER = "functional"
"""Below that of ``QUADSHADE_COVERAGE``; scripts/coverage/functional.py reads it."""

SOURCES = "sources"
"""A file beside the counters of a unit's program: a hash of all VHDL that it was one of."""


class Cover:
    """
    A cross of what varies in a stimulus.

    Parameters
    ----------
    name : str
    bins : mapping of str to sequence of str
      What varies, and the values that it can have.
    impossible : sequence of (str, mapping of str to sequence of str), optional
      Why combinations of these values cannot be.
    """

    def __init__(
        self,
        name: str,
        bins: Mapping[str, Sequence[str]],
        impossible: Sequence[tuple[str, Mapping[str, Sequence[str]]]] = (),
    ) -> None:
        self.name, self.bins, self.impossible = name, bins, impossible
        self.hits: Counter[tuple[str, ...]] = Counter()

    def sample(self, **values: object) -> None:
        """Count a combination; raises ``ValueError`` for a value that is in no bin."""
        key = tuple(str(values[name]) for name in self.bins)
        for name, value in zip(self.bins, key, strict=True):
            if value not in self.bins[name]:
                raise ValueError(f"{self.name}: {name} is {value}")
        self.hits[key] += 1

    def save(self) -> None:
        """Keep the counts, where coverage is asked for."""
        if place := os.environ.get("QUADSHADE_COVERAGE"):
            folder = Path(place) / FOLDER
            folder.mkdir(parents=True, exist_ok=True)
            rows = [[*key, count] for key, count in sorted(self.hits.items())]
            content = {"name": self.name, "bins": self.bins, "impossible": self.impossible, "hits": rows}
            (folder / f"{uuid.uuid4().hex}.json").write_text(json.dumps(content))
            self.hits.clear()
