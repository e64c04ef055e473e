# SPDX-License-Identifier: Apache-2.0
"""
The first test of a simulation whose netlist holds many mutants: it makes a process for each of them.

All that a simulation begins with (Icarus' file, Python, cocotb, the bench, the golden model) is loaded once;
then each child sets the port that chooses its mutant, runs the other tests, and writes results and log of its
own.
"""

from __future__ import annotations

import os
import resource
from typing import Any

import cocotb
from cocotb.triggers import ReadWrite

from scripts.mutation.rtl.fork_names import FORKS, LOG, PORT, RESULTS

PROCESSOR_SECONDS = 300
"""Ends a child whose simulated time stands still."""


@cocotb.test(stage=-1)
async def choose_mutant(dut: Any) -> None:
    """Return in a child for each mutant; the parent waits for one after the other, and ends."""
    for number in range(int(os.environ[FORKS])):
        child = os.fork()
        if child:
            os.waitpid(child, 0)  # noqa: ASYNC222 -- nothing else is to run meanwhile
            continue
        resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_SECONDS, PROCESSOR_SECONDS))
        log = os.open(LOG.format(number), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(log, 1)
        os.dup2(log, 2)
        os.environ["COCOTB_RESULTS_FILE"] = RESULTS.format(number)
        getattr(dut, PORT).value = number
        await ReadWrite()
        return
    os._exit(0)
