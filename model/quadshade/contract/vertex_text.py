# SPDX-License-Identifier: Apache-2.0
"""
The text of ``vertex_unpacker``'s program; ``vertex_program.py`` says what its lines mean, and assembles it.

It decodes a packet, sorts the corners, sets up the edges and puts the fields out; then come the ratios, their
products, and for each channel its differences.
"""

from __future__ import annotations

_DECODE = """
main:
    start
    take #1; jnz others
    ones; st trim_top; ones; st trim_bottom; take #1; st quadratic; ld #max_order - 2; jn all_linear
corners:
    ldx #0; take #2; jz drop_first
    add #0 - 1; jz drop_second
    add #0 - 1; jz drop_third
    ld v2; st pa; st pb; st px; call point; st v0; st pa; st pb; st px; call point; st v1; ld quadratic
    jz own_third
    ld v0; st pa; ld v1; st pb; call middle; st m0
own_third:
    ld v1; st pa; st pb; st px; jmp third
drop_first:
    ld v0; st px; ld v1; st v0; ld v2; st v1; ld m2; st m0; jmp shared
drop_second:
    ld v1; st px; ld v2; st v1; ld m1; st m0; jmp shared
drop_third:
    ld v2; st px
shared:
    ld v0; st pa; ld v1; st pb
third:
    call point; st v2; ld quadratic; jz sort
    ld v0; st pa; ld v2; st pb; call middle; st m1; ld v1; st pa; call middle; st m2; jmp sort
others:
    take #1; jz parameters
    take #RUN_BITS; raw
    jmp main
parameters:
    ldx #0; ldp #@k_place
parameter:
    take #PARAMETER_BITS; add #LONGEST_PREFIX; st p+0; loop parameter, len_prefixes
    take #PARAMETER_BITS; st shift_colour; take #PARAMETER_BITS; st shift_depth
    ld #1; shl k_place; shr #LONGEST_PREFIX; st b_place; ld #1; shl k_colour; shr #LONGEST_PREFIX
    st b_colour; ld #1; shl k_depth; shr #LONGEST_PREFIX; st b_depth; ld #1; shl k_middle
    shr #LONGEST_PREFIX; st b_middle
    ldx #0; ldp #@halves; ld shift_colour; st p+5; st p+6; st p+7; st p+8; ld shift_depth
    st p+5 + num_channels
    ld #1; shl shift_colour; shl #RATIO_FRAC + SAMPLE_FRAC - 1; st p+0; st p+1; st p+2; st p+3; ld #1
    shl shift_depth; shl #RATIO_FRAC + SAMPLE_FRAC - frac_bits + depth_frac_bits * with_depth; shr #1
    st p+num_channels
    ld #1; shl #RATIO_FRAC + 4; st offset; ld #0; st next_vertex; st v0; st v1; st v2; st m0; st m1
    st m2; st t
clear:
    ldp t; ld #0; st p+0; st p+1; st p+2; st p+3; st p+4; st p+5; st p+6; st p+7
    ld t; add #8; st t; add #0 - SCRATCH_AT; jn clear
    ld #MIDDLES_AT; st next_middle; jmp main
all_linear:
    ld #0; st quadratic; jmp corners
point:
    take #1; jz known_point
    take #1; st moved; jnz moved_point
    ld k_place; st k; ld b_place; st bias; call part; ldx #1; call part
point_colours:
    ld #0; st e; ldx #2
point_colour:
    ones; add #0 - LONGEST_PREFIX; jz long_colour
    add k_colour; st n; ld #1; get n; sub b_colour; fold
point_coloured:
    add e; ldp pa; st e; add p+0; ldp pb; add p+0; ldp px; sub p+0; ldp next_vertex; st p+0
    loop point_colour, 2 + num_channels
    ld #with_depth; jz point_whole
    ld moved; jnz point_whole
    ld k_depth; st k; ld b_depth; st bias; call part
point_whole:
    ld next_vertex; add #VERTEX_WORDS; ldx #0; st next_vertex; add #0 - MIDDLES_AT; jnn first_vertex
point_kept:
    add #MIDDLES_AT - VERTEX_WORDS; ret
known_point:
    get #6; shl #3; ret
moved_point:
    take #6; shl #3; st slot
    ldp slot; ld p+0; ldp next_vertex; st p+0; ldp slot; ld p+1; ldp next_vertex; st p+1
    ldp slot; ld p+2 + num_channels; ldp next_vertex; st p+2 + num_channels; jmp point_colours
first_vertex:
    st next_vertex; jmp point_kept
long_colour:
    get #LONG_BITS; fold; jmp point_coloured
part:
    ones; add #0 - LONGEST_PREFIX; jz long_part
    add k; st n; ld #1; get n; sub bias; fold
part_kept:
    ldp pa; add p+0; ldp pb; add p+0; ldp px; sub p+0; ldp next_vertex; st p+0; ret
long_part:
    get #LONG_BITS; fold; jmp part_kept
middle:
    take #1; jz known_middle
    ld #0; st e
middle_colour:
    ones; add #0 - LONGEST_PREFIX; jz long_middle
    add k_middle; st n; ld #1; get n; sub b_middle; fold
middle_coloured:
    add e; ldp pa; st e; ld p+2; ldp pb; add p+2; shr #1; add e; ldp next_middle; st p+0
    loop middle_colour, num_channels
    ld next_middle; add #MIDDLE_WORDS; ldx #0; st next_middle; add #0 - SCRATCH_AT; jnn first_middle
middle_kept:
    add #SCRATCH_AT - MIDDLE_WORDS; ret
known_middle:
    get #6; shl #2; add #MIDDLES_AT; ret
first_middle:
    add #MIDDLES_AT; st next_middle; add #0 - MIDDLES_AT; jmp middle_kept
long_middle:
    get #LONG_BITS; fold; jmp middle_coloured
"""

_EDGES = """
sort:
    ldp v0; ld p+1; st y1; ldp v1; ld p+1; st ym; ldp v2; ld p+1; st yb; ld ym; sub y1; jnn sorted_first
    call swap_first
sorted_first:
    ld yb; sub ym; jnn sorted_second
    call swap_second
sorted_second:
    ld ym; sub y1; jnn sorted
    call swap_first
sorted:
    ldp v0; ld p+0; st x1; ldp v1; ld p+0; st xm; sub x1; ldp v2; st x2; ld p+0; st xb; sub x1; st x3
    ld ym; sub y1; st y2; ld yb; sub y1; st y3; ld y1; sub ym; ldq y3; st ny2
    ld #0; muli x2, 18; ldq ny2; muli x3, 18; st area; ld y1; add y1
    add #2 ** subpixel_bits - 1; shr #subpixel_bits + 1; add trim_top; st y; st from; add y; add #1
    shl #subpixel_bits; sub y1; sub y1; st down
    ld ym; add ym; add #2 ** subpixel_bits - 1; shr #subpixel_bits + 1; st knee
    ld yb; add yb; add #2 ** subpixel_bits - 1; shr #subpixel_bits + 1; sub trim_bottom; st bottom; sub y
    st rows; st rows_first; ld #0; st mirror; st has_second; st rows_second; ld y; sub knee; jnn header
    ld knee; sub bottom; jnn header
    ld knee; sub y; st rows_first; ld bottom; sub knee; st rows_second; ld #1; st has_second; ld area
    jnn header
    ld #2; st mirror
header:
    ld #(4 ** num_channels - 1) / 3 * 8; shl quadratic; add #with_depth * 2 ** (3 + 2 * num_channels)
    add has_second; add mirror; put #3 + 2 * num_channels + 2 * with_depth
    ld y; put #coord_bits; ld rows_first; add #0 - 2; put #column_bits; ld rows_second; add #0 - 2
    put #column_bits; ld has_second; jnz both
    ld area; jn short_major
    ldp #@major; call long; ldp #@minor; call short; jmp colours
short_major:
    ldp #@major; call short; ldp #@minor; call long; jmp colours
both:
    ldp #@major; call long; ldp #@minor; ld rows_first; st rows; call upper; align; ld rows_second
    st rows; ld knee; st from; call lower; jmp colours
swap_first:
    ld v0; ldq v1; st v1; stq v0; ld y1; ldq ym; st ym; stq y1; ld m1; ldq m2; st m2; stq m1; ret
swap_second:
    ld v1; ldq v2; st v2; stq v1; ld ym; ldq yb; st yb; stq ym; ld m0; ldq m1; st m1; stq m0; ret
short:
    ld y; sub knee; jnn lower
upper:
    ld x2; st dx; ld y2; st dy; jmp from_top
lower:
    ld xm; st xa; ld yb; sub ym; st dy; ld xb; sub xm; st dx
    ld from; add from; add #1; shl #subpixel_bits; sub ym; sub ym; st d; jmp edge
long:
    ld x3; st dx; ld y3; st dy
from_top:
    ld x1; st xa; ld down; st d
edge:
    ld dy; add dy; ldq xa; st t; ld dy; shl #subpixel_bits; add #0 - 1; muli t, 22; ldq d; muli dx, 20
    shr #subpixel_bits + 1; st m; ld mirror; jnz mirrored
straight:
    ld dy; shl #column_bits; st wide; shl #1; st double; ld wide; add m; ldq #0
    div double, 1 + column_bits; jnn whole
    add double
whole:
    shr #1 + column_bits; st rest; ldr; add #0 - 2 ** column_bits; st p+0; put #column_bits
    ld dx; jz flat
    ld rows; add #0 - 1; jz flat
    ld wide; add dx; ldq #0; div double, 1 + column_bits; jnn whole_step
    add double
whole_step:
    shr #1 + column_bits; st m; sub dy; st dx; add rest; put #error_bits; ldr
    add #0 - 2 ** column_bits; st p+1; put #column_bits; ld m; put #edge_bits; ld dx; put #error_bits; ret
flat:
    ld #0 - 1; put #error_bits; ld #0; st p+1; put #column_bits; put #edge_bits; ld #0 - 1
    put #error_bits; ret
mirrored:
    ld dy; sub m; add #0 - 1; st m; ld #0; sub dx; st dx; jmp straight
"""

_RATIOS = """
colours:
    ld area; jnn positive
    call swap_second; ld x2; ldq x3; st x3; stq x2; ld y2; ldq y3; st y3; stq y2; ld #0; sub area; st area
positive:
    ld #0; sub x3; st nx3; ld #0; sub y2; st ny2; st qy2; ld y3; st qy3; ld area; add area; st double
    shl #5; st wide; ld mirror; jnz mirrored_ratios
pixel:
    ld major; add major; add #1; shl #subpixel_bits; sub x1; sub x1; ldq down; st right
    ld wide; shr #1; st half_wide; muli nx3, 20; ldq right; muli y3, 20; ldq #0; div wide, RATIO_FRAC + 5; ldr
    sub offset; ldq down; st u; ld half_wide; muli x2, 20; ldq right; muli ny2, 20; ldq #0
    div wide, RATIO_FRAC + 5; ldr; sub offset; ldq major_step; st v; ld nx3; muli y3, 16
    shl #subpixel_bits - 4; add area; ldq #0; div double, RATIO_FRAC + 5; ldr; sub offset
    ldq major_step; st pu; ld x2; muli ny2, 16; shl #subpixel_bits - 4; add area; ldq #0
    div double, RATIO_FRAC + 5; ldr; sub offset; ldq #0; st pv; ld qy3; shl #subpixel_bits - 4; add area
    div double, RATIO_FRAC + 5; ldr; sub offset; ldq #0; st qu; ld qy2; shl #subpixel_bits - 4; add area
    div double, RATIO_FRAC + 5; ldr; sub offset; st qv; ld quadratic; jz channels
"""

_MIRRORED = """
mirrored_ratios:
    ld #0 - 1; sub major; st major; ld #0; sub major_step; st major_step; ld #0; sub y3; st qy3; ld y2
    st qy2; jmp pixel
"""

PRODUCTS = (
    *(("uu", "u", "u"), ("vv", "v", "v"), ("uv", "u", "v")),
    *(("p_uu", "pu", "pu"), ("p_vv", "pv", "pv"), ("p_uv", "pu", "pv")),
    *(("q_uu", "qu", "qu"), ("q_vv", "qv", "qv"), ("q_uv", "qu", "qv")),
)
"""Squares and products of ratios: of the first pixel's, of a row step's, of a column step's."""

SUMS = (
    ("r_uu", ("twice_u",), ("pu",), ("add p_uu",)),
    ("r_vv", ("twice_v",), ("pv",), ("add p_vv",)),
    ("r_uv", ("u", "pu"), ("v", "pv"), ("sub uv",)),
    ("c_uu", ("twice_u",), ("qu",), ("sub q_uu",)),
    ("c_vv", ("twice_v",), ("qv",), ("sub q_vv",)),
    ("c_uv", ("u", "qu"), ("v", "qv"), ("sub uv", "sub q_uv", "sub q_uv")),
    ("x_uu", ("twice_pu",), ("qu",), ()),
    ("x_vv", ("twice_pv",), ("qv",), ()),
    ("x_uv", ("pu", "qu"), ("pv", "qv"), ("sub p_uv", "sub q_uv")),
)
"""
Of d_row, d_col and dd_mixed: a product of two sums, and what is added and subtracted then. Of u and v
together that is shorter than the two products which are left.
"""

TERMS = (
    (("uu", "a"), ("vv", "b"), ("uv", "c"), ("u", "d"), ("v", "e")),
    (("r_uu", "a"), ("r_vv", "b"), ("r_uv", "c"), ("pu", "d"), ("pv", "e")),
    (("c_uu", "a"), ("c_vv", "b"), ("c_uv", "c"), ("qu", "d"), ("qv", "e")),
    (("p_uu", "a2"), ("p_vv", "b2"), ("p_uv", "c2")),
    (("x_uu", "a"), ("x_vv", "b"), ("x_uv", "c")),
    (("q_uu", "a2"), ("q_vv", "b2"), ("q_uv", "c2")),
)
"""Differences in their order, each a sum of ratios times coefficients of the unit triangle's quadratic."""


def _product(first: str, second: str) -> list[str]:
    """Lines that leave a product of ratios in the accumulator."""
    return ["ld #0", f"ldq {second}", f"mulf {first}, 36", "shl #4"]


def _factor(parts: tuple[str, ...], place: str) -> tuple[list[str], str]:
    """Lines that add ratios, and where the sum then is."""
    if len(parts) == 1:
        return [], parts[0]
    return [f"ld {parts[0]}", *(f"add {part}" for part in parts[1:]), f"st {place}"], place


def _words(terms: tuple[tuple[tuple[str, str], ...], ...], shift: str, first: str) -> list[str]:
    lines = []
    for index, row in enumerate(terms):
        lines += ["ld #0"] if index else ["ld i1", "shl #RATIO_FRAC", f"add {first}"]
        for ratio, coefficient in row:
            lines += [f"ldq {coefficient}", f"muli {ratio}, 18"]
        lines += [f"shr {shift}", "word"]
    return lines


LINEAR_TERMS = tuple(row[3:] for row in TERMS[:3])

_LINEAR = """
    ldp v0; ld p+2; st i1; ldp v1; ld p+2; sub i1; ldp v2; st d; ld p+2; sub i1; ldp #@halves; st e
"""

_COEFFICIENTS = """
    ldp v0; ld p+2; st i1; ldp m0; ld p+0; st i12; ldp v1; ld p+2; st i2; add i1; sub i12; sub i12
    shl #1; st a; shl #1; st a2; ldp m1; ld p+0; st i13; ldp v2; ld p+2; st i3; add i1; sub i13; sub i13
    shl #1; st b; shl #1; st b2; ldp m2; ld p+0; sub i12; sub i13; add i1; shl #2; st c; shl #1; st c2
    ld i2; sub i1; sub a; st d; ld i3; sub i1; sub b; st e
"""


def program_text() -> str:
    """The whole program."""
    lines = ["products:"]
    for name in ("u", "v", "pu", "pv"):
        lines += [f"ld {name}", f"add {name}", f"st twice_{name}"]
    for target, first, second in PRODUCTS:
        lines += [*_product(first, second), f"st {target}"]
    for target, parts, others, then in SUMS:
        (sum_first, one), (sum_second, other) = _factor(parts, "d"), _factor(others, "e")
        lines += [*sum_first, *sum_second, *_product(one, other), *then, f"st {target}"]
    lines += ["channels:", "align", "ldx #0", "ld quadratic", "jz linear_channel"]
    lines += ["quadratic_channel:", *_COEFFICIENTS.split("\n")]
    lines += [*_words(TERMS, "shift_colour", "halves"), "loop quadratic_channel, num_channels"]
    # The index is now the depth's.
    lines += ["ld #with_depth", "jz main"]
    lines += ["linear_channel:", *_LINEAR.split("\n"), *_words(LINEAR_TERMS, "p+5", "p+0")]
    lines += ["loop linear_channel, num_channels + with_depth", "jmp main"]
    return "\n".join([_DECODE, _EDGES, _RATIOS, *lines, _MIRRORED])
