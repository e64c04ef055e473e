# SPDX-License-Identifier: Apache-2.0
"""Options of ``render`` for adaptive pictures: an allowed error or a budget, and what came out."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import click

from quadshade.errors import QuadshadeError
from quadshade.shading.specular import UnsuitedError, specular_formats

if TYPE_CHECKING:
    from quadshade.adapt import Adapted
    from quadshade.contract.formats import Formats
    from quadshade.contract.triangles import Drawing
    from quadshade.scene import Projected
    from quadshade.shading import Light, Material

MEASURES = ("max", "rms")
ADAPTIVE_SHADINGS = ("quadratic", "quadratic-specular")
_BUDGET = re.compile(r"([0-9]{1,15})(bytes|clocks)?")


class Budget(click.ParamType):
    """A number of bytes or clocks, as (number, unit)."""

    name = "N[bytes|clocks]"

    def convert(
        self, value: object, param: click.Parameter | None, context: click.Context | None
    ) -> tuple[int, str]:
        """The number and its unit, or a usage error that says how to write them."""
        if isinstance(value, tuple):
            return value
        match = _BUDGET.fullmatch(str(value).strip().lower())
        if not match:
            self.fail(f"{value!r} is not a budget; write for example 20000bytes or 180000clocks")
        return int(match[1]), match[2] or "bytes"


def adapt_options(command: Callable) -> Callable:
    """
    Add ``--max-error``, ``--budget``, ``--error-measure`` and ``--verify`` to a command.

    Its function gets them as one ``adapt_choice``: a dict of arguments of :func:`quadshade.adapt.adapt`, or
    None where neither a limit nor a budget is given.
    """
    options = (
        click.option(
            "--max-error",
            type=float,
            metavar="GREY",
            help="Adaptive: the cheapest order of each channel and triangle, or division, for this error "
            "against Phong shading, in grey levels; of colours, cosines or parts of the light, whichever "
            "takes least, unless --shading says (docs/guide/adapt.md).",
        ),
        click.option(
            "--budget",
            type=Budget(),
            help="Adaptive: the least error for so many bytes of set-up words, or clocks of the core, e.g. "
            "20000bytes or 180000clocks.",
        ),
        click.option(
            "--error-measure",
            type=click.Choice(MEASURES),
            help="What --max-error and --budget mean by error: the largest of any pixel, or the root mean "
            "square.  [default: max]",
        ),
        click.option(
            "--verify/--no-verify",
            default=True,
            show_default=True,
            help="With --max-error: compare every pixel with Phong shading and repair what exceeds it. With "
            "--port: what the board shows must have the CRC that the golden model predicts.",
        ),
    )

    @functools.wraps(command)
    def with_choice(
        *arguments: Any,
        max_error: float | None,
        budget: tuple[int, str] | None,
        error_measure: str | None,
        verify: bool,
        **others: Any,
    ) -> Any:
        if max_error is None and budget is None:
            if error_measure is not None:
                raise QuadshadeError(
                    "--error-measure is given without an error", "give --max-error or --budget"
                )
            return command(*arguments, adapt_choice=None, **others)
        number, unit = budget or (None, "bytes")
        choice = {"max_error": max_error, "budget": number, "unit": unit}
        choice |= {"measure": error_measure or MEASURES[0], "verify": verify}
        return command(*arguments, adapt_choice=choice, **others)

    for option in reversed(options):
        with_choice = option(with_choice)
    return with_choice


def check_adaptive(adapt_choice: dict | None, shading: str, method: str, toon: int | None) -> None:
    """Refuse a shading or set-up that leaves nothing to choose; raises :class:`QuadshadeError`."""
    if adapt_choice is None:
        return
    if shading not in ADAPTIVE_SHADINGS:
        raise QuadshadeError(
            f"the shading is {shading}, and --max-error or --budget chooses it for each triangle",
            f"leave --shading out, or give {' or '.join(ADAPTIVE_SHADINGS)}",
        )
    if toon is not None:
        raise QuadshadeError(
            "--toon with --max-error or --budget, which are about Phong shading", "leave it out"
        )
    if method == "xshading":
        raise QuadshadeError("--setup xshading takes its own samples", "use another --setup")


def adapted_to(
    choice: dict | None,
    shading: str | None,
    projected: Projected,
    lights: Sequence[Light] | None,
    material: Material,
    formats: Formats,
    generics: dict[str, int],
) -> Adapted | None:
    """
    What is to be drawn for the error or budget of ``adapt_choice``.

    Parameters
    ----------
    choice : dict or None
    shading : str or None
      One of ``ADAPTIVE_SHADINGS``, where the user has given one; else the cheaper one is taken.
    projected, lights, material, formats
      As for :func:`quadshade.adapt.adapt`.
    generics : dict of str to int
      What the user has set.

    Returns
    -------
    Adapted or None
      None where there is no choice.
    """
    if choice is None:
        return None
    from quadshade.adapt import adapt

    specular = None
    if shading != ADAPTIVE_SHADINGS[0]:
        try:
            specular = specular_formats(generics, projected, lights, material)
        except UnsuitedError as reason:
            click.echo(f"quadshade: notice: drawn as {ADAPTIVE_SHADINGS[0]}: {reason}", err=True)
            shading = ADAPTIVE_SHADINGS[0]
    return adapt(projected, lights, material, formats, **choice, shading=shading or "auto", specular=specular)


def adapt_note(adapted: Adapted) -> str:
    """Bytes and kind of channels of a picture, what the other kind would have taken, and the mix."""
    from quadshade.adapt import stream_bytes

    size = stream_bytes(adapted.triangles, adapted.formats)
    rival = adapted.rival or {}
    other = f", as {rival['shading']} {rival['bytes']}" if "bytes" in rival else ""
    mix = adapted.mix()
    orders = ", ".join(f"{count} {order}" for order, count in mix["triangles_by_order"].items())
    powers = sum(mix["specular_by_order"].values()) - mix["specular_by_order"]["constant"]
    if adapted.shading == ADAPTIVE_SHADINGS[1]:
        orders += f", {powers} with a power"
    return (
        f"{size} bytes as {adapted.shading}{other}; {mix['triangles']} parts ({orders}), "
        f"{mix['divided']} triangles divided"
    )


def adapt_report(
    choice: dict | None,
    adapted: Adapted | None,
    drawing: Drawing,
    projected: Projected,
    lights: Sequence[Light] | None,
    material: Material,
    formats: Formats,
) -> tuple[dict, str]:
    """What ``--stats`` and the command's output line say about an adaptive picture; nothing about others."""
    if choice is None or adapted is None:
        return {}, ""
    from quadshade.adapt import error_figures, pixel_errors

    limit = choice["max_error"] if choice["measure"] == "max" else None
    errors = pixel_errors(drawing.pixels, adapted.root, projected, lights, material, formats)
    figures = error_figures(errors, math.inf if limit is None else limit)
    mix = adapted.mix()
    size = 4 * drawing.stats["words"] + mix["state_bytes"]
    content = {
        "max_error": choice["max_error"],
        "budget": choice["budget"],
        "budget_unit": choice["unit"] if choice["budget"] is not None else None,
        **mix,
        "bytes": size,
        "measured_max": figures.largest,
        "measured_rms": figures.rms,
        "share_over_max_error": None if limit is None else figures.exceeding,
    }
    over = "" if limit is None else f", {figures.exceeding:.4%} of the pixels over {limit:g}"
    note = (
        f", {adapt_note(adapted)}; error max {figures.largest:.2f}, rms {figures.rms:.3f} "
        f"(estimated {mix['error_measure']} {mix['estimated_error']:.3f}){over}"
    )
    return {"adaptive": content}, note
