# SPDX-License-Identifier: Apache-2.0
"""How every script ends that cannot do what it was asked: one line on stderr, and an exit code."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

import click

from quadshade.errors import QuadshadeError

BAD_INPUT = 2
Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


class Failure(Exception):
    """What was measured is not what it has to be; exit code 1."""


def _show_usage(error: click.UsageError, _: object = None) -> None:
    """In place of click's usage, hint and error, a line each."""
    path = "" if error.ctx is None else error.ctx.command_path
    script = path.removeprefix("python -m ").split()[:1]
    name = Path(script[0]).stem if script and "/" in script[0] else "".join(script).rpartition(".")[2]
    text = " ".join(error.format_message().rstrip(".").split())
    click.echo(f"{name}: error: {text}; try '{path} --help'", err=True)


# For every script, as each of them imports this module.
click.UsageError.show = _show_usage  # type: ignore[method-assign]


def one_line_errors(name: str) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """
    Say bad input, a missing tool or a failed check in one line, instead of a traceback.

    Parameters
    ----------
    name : str
      Of the script, which the line begins with.

    Returns
    -------
    callable
      A decorator of a command's function; it goes below click's own.
    """

    def decorate(work: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        @functools.wraps(work)
        def run(*arguments: Parameters.args, **options: Parameters.kwargs) -> Result:
            try:
                return work(*arguments, **options)
            except (QuadshadeError, OSError) as problem:
                click.echo(f"{name}: error: {problem}", err=True)
                sys.exit(BAD_INPUT)
            except Failure as failure:
                click.echo(f"{name}: failed: {failure}", err=True)
                sys.exit(1)

        return run

    return decorate
