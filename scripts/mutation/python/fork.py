# SPDX-License-Identifier: Apache-2.0
"""Work in a forked process that may end, hang or ask for too much: how it ended, and its processor time."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

MEMORY = 12 << 30
"""Bytes of address space that a mutant may ask for."""


@dataclass(frozen=True)
class Outcome:
    """
    How the tests of a mutant ended.

    Attributes
    ----------
    state : str
      ``survived``, ``killed`` or ``timeout``, which is killed too: it used several times the processor time
      that the tests need without a change.
    test : str
      The first test that failed; empty if none did.
    seconds : float
      Of processor time.
    """

    state: str
    test: str
    seconds: float


def allow_seconds(limit: float) -> None:
    """End this process where it takes more processor time; a limit that is set already can be lowered."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 5))


def forked(work: Callable[[], str], limit: float, patience: float) -> Outcome:
    """What a forked process says: the test that failed, or nothing."""
    reading, writing = os.pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        code = 3
        try:
            os.close(reading)
            os.setpgid(0, 0)
            allow_seconds(limit)
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            with open(os.devnull, "w") as nowhere:
                os.dup2(nowhere.fileno(), 1)
                os.dup2(nowhere.fileno(), 2)
            os.write(writing, work().encode()[:2000])
            code = 0
        finally:
            os._exit(code)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        status, seconds = _wait(child, patience)
        test = pipe.read().strip()
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL):
        return Outcome("timeout", "", seconds)
    if not os.WIFEXITED(status) or os.WEXITSTATUS(status):
        return Outcome("killed", test or f"the process ended with status {status}", seconds)
    return Outcome("killed" if test else "survived", test, seconds)


def _wait(child: int, patience: float) -> tuple[int, float]:
    """Status and processor time of a child; one that only waits is ended in the end."""
    end = time.monotonic() + patience
    while True:
        done, status, usage = os.wait4(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
            _, status, usage = os.wait4(child, 0)
            break
        time.sleep(0.01)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    return status, round(usage.ru_utime + usage.ru_stime, 1)
