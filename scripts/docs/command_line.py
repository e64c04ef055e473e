# SPDX-License-Identifier: Apache-2.0
"""The reference of the command line, written from click's own description of it."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator

import click

from quadshade.cli.main import main


def command_line_page() -> str:
    """Every command with its arguments and options, as Markdown."""
    lines = ["# Command line", "", "What `quadshade --help` and the help of each command say.", ""]
    for path, command in _commands(main, ("quadshade",)):
        lines += _section(path, command)
    return "\n".join(lines)


def _commands(
    command: click.Command, path: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    """A command and those below it."""
    yield path, command
    if isinstance(command, click.Group):
        context = click.Context(command, info_name=path[-1])
        for name in command.list_commands(context):
            yield from _commands(command.get_command(context, name), (*path, name))


def _section(path: tuple[str, ...], command: click.Command) -> list[str]:
    """One command's heading, usage, text and table of options."""
    context = click.Context(command, info_name=" ".join(path))
    usage = " ".join([*path, *command.collect_usage_pieces(context)])
    lines = [f"## {' '.join(path)}", "", f"    {usage}", "", *_text(command.help or ""), ""]
    if isinstance(command, click.Group):
        names = command.list_commands(context)
        lines += [
            f"- [`{' '.join((*path, name))}`](#{'-'.join((*path, name))}): "
            f"{command.get_command(context, name).get_short_help_str(200)}"
            for name in names
        ]
        lines.append("")
    options = [option for option in command.params if isinstance(option, click.Option) and not option.hidden]
    if options:
        lines += ["| option | value | meaning |", "| --- | --- | --- |"]
        lines += [_row(option, context) for option in options]
        lines.append("")
    return lines


def _text(text: str) -> list[str]:
    """A help text as Markdown; what click must not wrap is code."""
    lines = []
    for paragraph in inspect.cleandoc(text).split("\n\n"):
        if paragraph.startswith("\b"):
            lines += [f"    {line}" for line in paragraph.splitlines()[1:]]
        else:
            lines += [_plain(line) for line in paragraph.splitlines()]
        lines.append("")
    return lines


def _row(option: click.Option, context: click.Context) -> str:
    """A row of the table of options."""
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    switch = option.is_flag or option.count
    values = () if switch else (option.make_metavar(context),)
    if isinstance(option.type, click.Choice) and not option.metavar:
        values = tuple(map(str, option.type.choices))  # A code for each: a line may end between them.
    value = ", ".join(f"`{one}`" for one in values)
    _, described = option.get_help_record(context) or ("", option.help or "")
    return f"| {names} | {value} | {_plain(described)} |"


def _plain(text: str) -> str:
    """Text without anything that Markdown or a table would take for its own."""
    return re.sub(r"([*_\[\]|\\])", r"\\\1", " ".join(text.split())).replace("<", "&lt;")
