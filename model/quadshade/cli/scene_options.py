# SPDX-License-Identifier: Apache-2.0
"""Options about the scene, its shading and its accuracy, which ``render``, ``pack`` and ``raster`` share."""

from __future__ import annotations

import click
from click.core import ParameterSource

from quadshade.choices import (
    ALL_FITS,
    DEFAULT_SHADING,
    DEFAULT_SIZE,
    JUMP,
    MAX_ERROR,
    MEASURES,
    PACK_ERROR,
    ROUNDINGS,
    SETUPS,
    SHADINGS,
    SMOOTHNESS,
    STEPPINGS,
    VERIFIES,
    parse_budget,
    parse_clock,
    parse_limit,
    parse_lod,
    parse_pack_error,
)
from quadshade.cli.options import Decorator, Parsed, complete_file, generic_option, is_given, option
from quadshade.errors import QuadshadeError

VERIFY_BOARD = (
    "What the board shows must be what the golden model draws. picture: it is fetched and compared; crc: "
    "its CRC alone is, and the model's picture is shown; none: it is fetched and believed."
)
VERIFY_ERROR = "With --max-error: compare every pixel with Phong shading and repair what exceeds it."
VERIFY_PICTURE = f"{VERIFY_BOARD} {VERIFY_ERROR}"

ERROR_OPTIONS: list[Decorator] = [
    option(
        "Accuracy",
        "--max-error",
        type=float,
        metavar="GREY",
        help="Adaptive: the cheapest order of each channel and triangle, or division, for this error "
        "against Phong shading, in grey levels; of colours, cosines or parts of the light, whichever "
        "takes least, unless --shading says (docs/guide/adapt.md).",
    ),
    option(
        "Accuracy",
        "--budget",
        type=Parsed("N[bytes|clocks|line]", parse_budget),
        help="Adaptive: of the pictures of --max-error the one with the least error that takes no more "
        "bytes of set-up words, clocks of the core, or bytes on the serial line: 20000bytes, 180000clocks, "
        "10000line.",
    ),
    option(
        "Accuracy",
        "--error-measure",
        type=click.Choice(MEASURES),
        help="What --max-error and --budget mean by error: the largest of any pixel, or the root mean "
        "square.  [default: max]",
    ),
]

FRAME_TIME = (
    "Adaptive: the least error that is complete on a board when so many milliseconds are over; level of "
    "detail, channels, orders and division are chosen for it. Without --port for a line of --baud and a core "
    "of --clock (docs/guide/frame_time.md)."
)

CLOCK_OPTIONS: list[Decorator] = [
    option(
        "Accuracy",
        "--clock",
        type=Parsed("MHZ", parse_clock),
        help="Of the core that --frame-time is for, without --port.  [default: 100]",
    )
]

GENERIC_OPTIONS: list[Decorator] = [generic_option()]

PACK_OPTIONS: list[Decorator] = [
    option(
        "Accuracy",
        "--pack-error",
        type=Parsed("GREY", parse_pack_error),
        help="Grey levels that words with fewer fraction bits may add to a pixel's error; 0 leaves every "
        f"word and every edge as it is (docs/reference/packing.md).  [default: {PACK_ERROR}]",
    )
]

VERTEX_OPTIONS: list[Decorator] = [
    option(
        "Accuracy",
        "--vertices",
        is_flag=True,
        help="Pack corners and edge middles, which neighbours share, where that takes fewer bytes than the "
        "packed fields, for a board with_vertices=1 (docs/reference/vertices.md).",
    )
]


def scene_options(size: str = DEFAULT_SIZE, background: str = "black") -> list[Decorator]:
    """What is looked at; ``size`` and ``background`` are what the help says of their defaults."""
    return [
        click.argument("scene", shell_complete=complete_file),
        option(
            "Scene",
            "--size",
            metavar="WxH",
            help=f"Pixels.  [default: {size}]",
        ),
        option(
            "Scene",
            "--camera",
            default="",
            metavar="KEY=VALUE,...",
            help="eye=x,y,z or from=x,y,z (direction), target=x,y,z, up=x,y,z, fov=degrees or "
            "ortho=half-height, near=distance; what is missing is fitted to the scene.",
        ),
        option(
            "Scene",
            "--light",
            "lights",
            multiple=True,
            metavar="KEY=VALUE,...",
            help="dir=x,y,z (towards the light), point=x,y,z or ambient=n, with colour=r,g,b (1 is full) "
            "and, for points, attenuation=a,b,c. Repeatable; replaces the default lights.",
        ),
        option(
            "Scene",
            "--material",
            default="",
            metavar="KEY=VALUE,...",
            help="colour=r,g,b, diffuse=, ambient=, specular= (one number or three), exponent=n, "
            "model=blinn or phong; Phong's own terms: d=, and w= or fresnel= (docs/guide/render.md).",
        ),
        option("Scene", "--exponent", type=float, help="Specular exponent.  [default: 20]"),
        option(
            "Scene",
            "--reflectance",
            metavar="MODULE:FUNCTION",
            help="Your own reflectance: a function of point, normal, to_light and to_viewer.",
        ),
        option(
            "Scene",
            "--cull/--no-cull",
            default=True,
            show_default=True,
            help="Drop triangles seen from behind.",
        ),
        option(
            "Scene",
            "--crease",
            type=float,
            metavar="DEGREES",
            help="Compute vertex normals; edges sharper than this stay sharp.  "
            "[default: the file's normals, else 60]",
        ),
        option(
            "Scene",
            "--lod",
            type=Parsed("N|auto", parse_lod),
            help="Level of detail: at most N triangles, with the normals and colours of all; auto: as many "
            "as are best for --budget.",
        ),
        option(
            "Scene",
            "--background",
            metavar="R,G,B",
            help=f"0..1; one number is grey.  [default: {background}]",
        ),
    ]


def shading_options(shadings: tuple[str, ...] = SHADINGS) -> list[Decorator]:
    """How colour is interpolated, by one of some shadings."""
    phong = "; phong is the reference, computed in float on the host" if "phong" in shadings else ""
    return [
        option(
            "Shading",
            "--shading",
            type=click.Choice(shadings),
            help="How colour is interpolated; -specular: diffuse and specular cosines, the power taken per "
            f"pixel{phong}.  [default: {DEFAULT_SHADING}]",
        ),
        option(
            "Shading",
            "--toon",
            type=int,
            metavar="STEPS",
            help="Cartoon: diffuse light in so many steps, highlights with a sharp border. Needs a -specular "
            "shading.",
        ),
        option(
            "Shading",
            "--fit",
            type=click.Choice(ALL_FITS),
            default=ALL_FITS[0],
            show_default=True,
            help="Which quadratic a triangle gets: through six samples, the best for the squared or the "
            "largest error over the whole picture, with smaller jumps of the derivative across edges, or "
            "without, in parts where a jump could be seen (c1); auto: with --max-error or --budget what "
            "takes fewer bytes, six samples or each part fitted anew.",
        ),
        option(
            "Shading",
            "--smoothness",
            type=float,
            metavar="PIXELS",
            help=f"Weight of jumps against errors, with --fit smooth.  [default: {SMOOTHNESS:g}]",
        ),
        option(
            "Shading",
            "--jump",
            type=float,
            metavar="LEVELS",
            help="Jump of the derivative across an edge that may stay, with --fit c1, in grey levels per "
            f"pixel.  [default: {JUMP:g}]",
        ),
    ]


NO_VERIFY = "quadshade.no_verify"
"""Where a command keeps whether ``--no-verify`` was given."""


def verify_option() -> list[Decorator]:
    """``--verify`` of commands that draw on no board."""
    return [option("Accuracy", "--verify/--no-verify", default=True, show_default=True, help=VERIFY_ERROR)]


def verify_options(title: str, help_text: str, default: str = VERIFIES[0]) -> list[Decorator]:
    """``--verify`` of commands that may draw on a board, and ``--no-verify``."""
    none = VERIFIES[-1]

    def without(context: click.Context, _: click.Parameter, wanted: bool) -> None:
        context.meta[NO_VERIFY] = wanted

    def chosen(context: click.Context, parameter: click.Parameter, word: str) -> str:
        if not context.meta[NO_VERIFY]:
            return word
        if is_given("verify", context) and word != none:
            raise QuadshadeError(f"--verify {word} and --no-verify are given", "give one of them")
        # For who asks whether it was said.
        context.set_parameter_source("verify", ParameterSource.COMMANDLINE)
        return none

    # The flag is read first, wherever it stands.
    flag = {"is_flag": True, "is_eager": True, "expose_value": False, "callback": without}
    return [
        option(
            title,
            "--verify",
            type=click.Choice(VERIFIES),
            default=default,
            show_default=True,
            callback=chosen,
            help=help_text,
        ),
        option(title, "--no-verify", help=f"--verify {none}.", **flag),
    ]


def setup_options(methods: tuple[str, ...] = SETUPS) -> list[Decorator]:
    """The set-up's methods, rounding, stepping, and how far a triangle may be off."""
    return [
        option(
            "Accuracy",
            "--setup",
            type=click.Choice(methods),
            default=methods[0],
            show_default=True,
            help="Where quadratic channels' coefficients come from (docs/explanation/setup.md).",
        ),
        option(
            "Accuracy",
            "--rounding",
            type=click.Choice(ROUNDINGS),
            default=ROUNDINGS[0],
            show_default=True,
            help="A channel's words rounded together, or each by itself.",
        ),
        option(
            "Accuracy",
            "--stepping",
            type=click.Choice(STEPPINGS),
            default=STEPPINGS[0],
            show_default=True,
            help="Colour at pixel centres, or stepped along the fractional major edge as in the paper.",
        ),
        option(
            "Accuracy",
            "--strict",
            type=Parsed("GREY", parse_limit),
            is_flag=False,
            flag_value=str(MAX_ERROR),
            help=f"Refuse a triangle that may be further than this from exact; {MAX_ERROR} without a number.",
        ),
        option(
            "Accuracy",
            "--divide",
            type=Parsed("GREY", parse_limit),
            help=f"Without --strict, draw such a triangle in parts.  [default: {MAX_ERROR}]",
        ),
    ]
