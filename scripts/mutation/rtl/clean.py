# SPDX-License-Identifier: Apache-2.0
"""How long the benches' cases take on the clean RTL, measured once for each state of a bench."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from scripts.mutation.rtl.benches import Case, digest
from scripts.mutation.rtl.results import CLEAN, append_line, read_lines


@dataclass(frozen=True)
class Clean:
    """A case on the clean RTL: simulated nanoseconds, and processor time in seconds."""

    case: str
    benches: str
    ns: float
    seconds: float


def _known(case: Case) -> list[Clean]:
    return [clean for line in read_lines(CLEAN) if (clean := Clean(**line)).case == case.name]


def known_clean(case: Case) -> Clean | None:
    """What an earlier run measured with the bench as it is."""
    found = [clean for clean in _known(case) if clean.benches == digest(case.unit)]
    return found[-1] if found else None


def has_run(case: Case) -> bool:
    """Whether a case was ever measured, with whatever bench."""
    return bool(_known(case))


def usual_seconds(case: Case) -> float:
    """Processor time of a case when it was last measured, with whatever bench; 1 if it never was."""
    found = _known(case)
    return found[-1].seconds if found else 1.0


def remember(clean: Clean) -> None:
    """Keep what was measured for later runs."""
    append_line(CLEAN, asdict(clean))
