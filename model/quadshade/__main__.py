# SPDX-License-Identifier: Apache-2.0
"""``python -m quadshade``: the command line."""

from quadshade.cli.main import main

main(prog_name="quadshade")
