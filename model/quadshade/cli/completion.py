# SPDX-License-Identifier: Apache-2.0
"""``quadshade completion``: the script that lets a shell complete commands and options."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from quadshade.errors import QuadshadeError

SHELLS = ("bash", "zsh", "fish")


@click.command(short_help="Print the shell's script that completes commands.")
@click.argument("shell", type=click.Choice(SHELLS))
def completion(shell: str) -> None:
    """
    Print the script that completes commands, options, their values and files in SHELL.

    \b
    quadshade completion bash >> ~/.bashrc
    quadshade completion zsh >> ~/.zshrc
    quadshade completion fish > ~/.config/fish/completions/quadshade.fish
    """
    made = get_completion_class(shell)
    if made is None:
        raise QuadshadeError(f"click completes nothing in {shell}", "install a newer click")
    group = click.get_current_context().find_root().command
    click.echo(made(group, {}, "quadshade", "_QUADSHADE_COMPLETE").source())
