# SPDX-License-Identifier: Apache-2.0
"""Options of the set-up that ``render`` and ``raster`` share: method, rounding, stepping and its limit."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import click

from quadshade.cli.port_options import is_given
from quadshade.errors import QuadshadeError
from quadshade.setup.literature.terms import SETUPS
from quadshade.setup.triangle_setup import MAX_ERROR, ROUNDINGS

STEPPINGS = ("centre", "fractional")
SAMPLED = tuple(method for method in SETUPS if method != "xshading")
"""Methods for samples that are given; X-shading takes normals."""


class GreyLevels(click.ParamType):
    """A number of grey levels above 0."""

    name = "GREY"

    def convert(self, value: object, param: click.Parameter | None, context: click.Context | None) -> float:
        """The number, or a usage error that says where to write it."""
        try:
            levels = float(value)
        except ValueError:
            levels = math.nan
        if not 0 < levels < math.inf:
            self.fail(f"{value!r} is not a number of grey levels above 0; write for example =0.5")
        return levels


def setup_options(methods: tuple[str, ...]) -> Callable:
    """
    Add the options to a command; its function gets them as one ``setup_choice``.

    Parameters
    ----------
    methods : tuple of str
      Choices of ``--setup``.

    Returns
    -------
    callable
      A decorator. ``setup_choice`` is a dict of arguments of :func:`quadshade.engine.draw`.
    """
    options = (
        click.option(
            "--setup",
            "method",
            type=click.Choice(methods),
            default="unit",
            show_default=True,
            help="Where quadratic channels' coefficients come from (docs/explanation/setup.md).",
        ),
        click.option(
            "--rounding",
            type=click.Choice(ROUNDINGS),
            default=ROUNDINGS[0],
            show_default=True,
            help="A channel's words rounded together, or each by itself.",
        ),
        click.option(
            "--stepping",
            type=click.Choice(STEPPINGS),
            default=STEPPINGS[0],
            show_default=True,
            help="Colour at pixel centres, or stepped along the fractional major edge as in the paper.",
        ),
        click.option(
            "--strict",
            type=GreyLevels(),
            is_flag=False,
            flag_value=str(MAX_ERROR),
            help=f"Refuse a triangle that may be further than this from exact; {MAX_ERROR} without a number.",
        ),
        click.option(
            "--divide",
            type=GreyLevels(),
            default=str(MAX_ERROR),
            show_default=True,
            help="Without --strict, draw such a triangle in parts.",
        ),
    )

    def decorate(command: Callable) -> Callable:
        @functools.wraps(command)
        def with_choice(
            *arguments: Any,
            method: str,
            rounding: str,
            stepping: str,
            strict: float | None,
            divide: float,
            **others: Any,
        ) -> Any:
            if strict is not None and is_given("divide"):
                raise QuadshadeError("--strict and --divide are given", "give one of them")
            choice = {
                "fractional": stepping == "fractional",
                "rounding": rounding,
                "method": method,
                "limit": divide if strict is None else strict,
                "strict": strict is not None,
            }
            return command(*arguments, setup_choice=choice, **others)

        for option in reversed(options):
            with_choice = option(with_choice)
        return with_choice

    return decorate


def check_method(method: str, shading: str) -> None:
    """Refuse a set-up method that a shading has no use for; raises :class:`QuadshadeError`."""
    if method != "unit" and not shading.startswith("quadratic"):
        raise QuadshadeError(f"--setup {method} is for quadratic channels, the shading is {shading}")


def undefined_note(stats: dict, method: str) -> str:
    """What to say about triangles that a method could not set up, or nothing."""
    count = stats["triangles_undefined"]
    return f", {count} triangles undefined by {method} and drawn as 0" if count else ""
