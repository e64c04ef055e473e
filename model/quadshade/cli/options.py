# SPDX-License-Identifier: Apache-2.0
"""How commands declare options, in groups that their help shows, and those that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from quadshade.choices import ENGINES, SUPERSAMPLES
from quadshade.contract.formats import GENERIC_HELP, Formats
from quadshade.errors import QuadshadeError

Function = TypeVar("Function", bound=Callable[..., Any])
Decorator = Callable[[Any], Any]

PATH = click.Path(dir_okay=False, path_type=Path)

GENERICS_EPILOG = "\b\nGenerics, and their defaults:\n" + "\n".join(
    f"{name}={value}".ljust(21) + GENERIC_HELP[name] for name, value in Formats().generics().items()
)
"""What the help of a command with ``--generic`` ends with."""


class TitledOption(click.Option):
    """An option that stands under a title of the help."""

    def __init__(self, *declarations: Any, title: str = "", **attributes: Any) -> None:
        super().__init__(*declarations, **attributes)
        self.title = title


class TitledCommand(click.Command):
    """A command whose help shows its options under their titles."""

    def format_options(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, group by group in the order in which they are declared."""
        groups: dict[str, list[tuple[str, str]]] = {}
        plain = []
        for parameter in self.get_params(context):
            record = parameter.get_help_record(context)
            if isinstance(parameter, TitledOption) and record is not None:
                groups.setdefault(parameter.title, []).append(record)
            elif isinstance(parameter, click.Option) and record is not None:
                plain.append(record)
        for title, records in (groups | {"Options": plain}).items():
            with formatter.section(title):
                formatter.write_dl(records)


class Parsed(click.ParamType[Any]):
    """
    A value that a function of the library reads.

    Parameters
    ----------
    name : str
      What the help shows.
    parse : callable
      Raises :class:`QuadshadeError`, which becomes the usage error.
    """

    def __init__(self, name: str, parse: Callable[[Any], Any]) -> None:
        self.name, self.parse = name, parse

    def convert(self, value: Any, param: click.Parameter | None, context: click.Context | None) -> Any:
        """The value, or a usage error that says how to write it."""
        try:
            return self.parse(value)
        except QuadshadeError as error:
            self.fail(str(error))


def option(title: str, *declarations: str, **attributes: Any) -> Decorator:
    """An option under a title of the help; otherwise as ``click.option``."""
    return click.option(*declarations, cls=TitledOption, title=title, **attributes)


def add_options(*groups: Sequence[Decorator]) -> Callable[[Function], Function]:
    """Add groups of options to a command, in their order; its function gets them under their names."""

    def decorate(function: Function) -> Function:
        for declared in reversed([one for group in groups for one in group]):
            function = declared(function)
        return function

    return decorate


def is_given(name: str, context: click.Context | None = None) -> bool:
    """Whether an option stands on the command line."""
    context = context or click.get_current_context()
    return context.get_parameter_source(name) is ParameterSource.COMMANDLINE


def complete_file(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Let the shell complete the name of a file."""
    return [CompletionItem(incomplete, type="file")]


def output_option(help_text: str, required: bool = True) -> Decorator:
    """``-o``: where the result goes."""
    return option("Output", "-o", "--output", required=required, type=PATH, help=help_text)


def generic_option(board: bool = True) -> Decorator:
    """``--generic`` of commands that draw with a core, and with ``board`` also on a simulated board."""
    return option(
        "Accuracy",
        "--generic",
        "generics",
        multiple=True,
        metavar="NAME=VALUE",
        help=f"Set a generic of the core for this run{', with --port sim also of the board' * board}, "
        "under its VHDL name (repeatable), e.g. stream_width=128.",
    )


def engine_option(
    default: str = "verilator where it and a C++ compiler are installed, else model",
) -> Decorator:
    """``--engine``; ``default`` is what the help says of it."""
    return option(
        "Engine or board",
        "--engine",
        type=click.Choice(ENGINES),
        envvar="QUADSHADE_ENGINE",
        help="What draws: the golden model, the VHDL in GHDL, or its netlist in Verilator.  "
        f"[default: {default}]",
    )


dask_option = option(
    "Engine or board",
    "--dask",
    metavar="ADDRESS",
    help="Let the workers of a Dask scheduler draw, e.g. tcp://host:8786; with --port sim or auto each on a "
    "board of its own.",
)

supersample_option = option(
    "Output",
    "--supersample",
    type=click.Choice([str(count) for count in SUPERSAMPLES]),
    default="1",
    show_default=True,
    callback=lambda _, __, value: int(value),
    help="Smooth the outlines: the mean of N x N pictures, each moved by a part of a pixel.",
)
stats_option = option(
    "Output", "--stats", type=PATH, help="Write clocks, pixels, triangles, set-up words as JSON."
)
waves_option = option(
    "Output", "--waves", type=PATH, help="Keep the simulation's waveforms (GHDL only), e.g. out.ghw."
)
