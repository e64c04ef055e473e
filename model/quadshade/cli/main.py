# SPDX-License-Identifier: Apache-2.0
"""The command ``quadshade``."""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NoReturn

from quadshade.cli.interrupts import MESSAGE, ending_in_order, exit_code, is_interrupted, leave_at_once

with leave_at_once():
    import difflib
    from importlib import import_module

    import click

    import quadshade
    from quadshade.cli.compiled_loops import somewhere_for_compiled_loops
    from quadshade.errors import QuadshadeError

BAD_INPUT = 2
COMMANDS = (
    "render",
    "turn",
    "view",
    "raster",
    "compare",
    "trade",
    "pack",
    "words",
    "dump",
    "replay",
    "info",
    "board",
    "completion",
)
"""Each is the function of this name in the module of this name, imported when it is needed."""


class OneLineErrors(click.Group):
    """A group of commands that says every error in one line on stderr and then exits with code 2."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command; as click's own ``main`` but for what an error looks like."""
        run: Callable[[], Any] = partial(
            super().main, args, prog_name, complete_var, standalone_mode=False, **extra
        )
        if not standalone_mode:
            return run()
        try:
            with warnings.catch_warnings(), ending_in_order(), somewhere_for_compiled_loops():
                # What matters is an error; numpy's and Pillow's warnings would be further lines on stderr.
                if not sys.warnoptions:
                    warnings.simplefilter("ignore")
                code = run()
        except click.exceptions.NoArgsIsHelpError as error:
            click.echo(error.ctx.get_help() if error.ctx else "")
            sys.exit(0)
        except (click.Abort, KeyboardInterrupt):
            _leave_interrupted()
        except (QuadshadeError, click.ClickException, OSError, MemoryError) as error:
            if is_interrupted():
                _leave_interrupted()
            _say(f"quadshade: error: {_one_line(error)}")
            sys.exit(BAD_INPUT)
        except Exception:
            # Numba's compiler raises others where it is interrupted.
            if is_interrupted():
                _leave_interrupted()
            raise
        sys.exit(code if isinstance(code, int) else 0)

    def make_context(self, *arguments: Any, **extra: Any) -> click.Context:
        """Read the options; click would print an empty line after Ctrl-C."""
        try:
            return super().make_context(*arguments, **extra)
        except KeyboardInterrupt:
            raise click.Abort from None

    def invoke(self, context: click.Context) -> Any:
        """Run a command; click would print an empty line after Ctrl-C."""
        try:
            return super().invoke(context)
        except KeyboardInterrupt:
            raise click.Abort from None

    def resolve_command(
        self, context: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that is named; where there is none, the error names the nearest one."""
        near = difflib.get_close_matches(args[0], COMMANDS, n=1)
        if args[0] not in COMMANDS and near and not args[0].startswith("-"):
            context.fail(f"there is no command {args[0]!r}, the nearest is {near[0]!r}")
        return super().resolve_command(context, args)

    def list_commands(self, context: click.Context) -> list[str]:
        """Names of the commands, in the order of the help."""
        return list(COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        """The command of a name; its module is imported here."""
        if name not in COMMANDS:
            return None
        with leave_at_once():
            return getattr(import_module(f"quadshade.cli.{name}"), name)


def _leave_interrupted() -> NoReturn:
    """End as after Ctrl-C."""
    _say(MESSAGE)
    sys.exit(exit_code())


def _say(text: str) -> None:
    """A line on stderr, which a closed terminal does not take any more."""
    with contextlib.suppress(OSError):
        click.echo(text, err=True)


def _one_line(error: BaseException) -> str:
    """What is wrong, without line breaks."""
    if isinstance(error, click.ClickException):
        text = error.format_message()
        if isinstance(error, click.UsageError) and error.ctx is not None:
            text = f"{text.rstrip('.')}; try '{error.ctx.command_path} --help'"
    elif isinstance(error, MemoryError):
        text = "not enough memory; draw a smaller scene or picture"
    elif isinstance(error, OSError) and error.strerror:
        text = f"{error.strerror}: {error.filename}" if error.filename else error.strerror
    else:
        text = str(error)
    return " ".join(text.split())


def _say_version(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Version of the installed package."""
    if wanted and not context.resilient_parsing:
        click.echo(f"quadshade, version {quadshade.__version__}")
        context.exit()


@click.group(
    cls=OneLineErrors, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_say_version,
    help="Show the version and exit.",
)
def main() -> None:
    """
    Quadratic shading, from a mesh to a picture, through a golden model or the VHDL itself.

    \b
    quadshade render sphere:168 -o sphere.png
    quadshade render pawn.obj -o pawn.png --engine ghdl --stats stats.json
    quadshade raster triangles.json -o pixels.npz
    quadshade compare quadratic.png phong.png
    """
