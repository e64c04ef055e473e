# SPDX-License-Identifier: Apache-2.0
"""What a simulation with one process for each mutant and who starts it call the same."""

PORT = "mutant_select"
"""Input of the mutated netlist: the number of the mutant; 0 is the netlist as it is."""
LOG, RESULTS = "mutant_{}.log", "mutant_{}.xml"
FORKS = "QUADSHADE_MUTANTS"
"""Environment variable: how many mutants there are, with number 0."""
