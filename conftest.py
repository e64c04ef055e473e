# SPDX-License-Identifier: Apache-2.0
"""One seed for all random tests: shown first, given to the tests and to cocotb, and named by a failure."""

from __future__ import annotations

import os
import zlib

import numpy as np
import pytest
from hypothesis import settings

SEED = int(os.environ.get("QUADSHADE_SEED") or 1)

# cocotb takes its seed from here, in whatever process the simulator runs.
os.environ["COCOTB_RANDOM_SEED"] = str(SEED)

# The command line's default depends on what is installed, and may have to compile first.
os.environ["QUADSHADE_ENGINE"] = "model"

settings.register_profile("quadshade", deadline=None, print_blob=True)
settings.load_profile("quadshade")


def pytest_report_header() -> str:
    return f"seed: {SEED} (make test SEED=n)"


@pytest.fixture(scope="session")
def seed() -> int:
    """The seed of this run (QUADSHADE_SEED, 1 if not given)."""
    return SEED


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """A generator of the test's own, so that a test draws the same numbers alone as among others."""
    return np.random.default_rng([SEED, zlib.crc32(request.node.nodeid.encode())])


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item):
    outcome = yield
    report = outcome.get_result()
    if report.failed:
        # pytest's -k takes no "=" in a name: its parts, all of which must occur, do the same.
        name = item.name.replace("=", " and ").replace("[", " and ").replace("]", "")
        report.sections.append(("replay", f"make test T='{name}' SEED={SEED} WAVES=1"))
