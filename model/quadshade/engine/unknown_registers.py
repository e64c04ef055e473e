# SPDX-License-Identifier: Apache-2.0
"""
A netlist whose registers hold nothing known at power-up, so that a simulation shows what only reset defines.

GHDL writes a register's initial value as an ``initial`` statement, and a signal that has one as a register of
its own, which follows another. Constant tables keep their values: they are no state.
"""

from __future__ import annotations

import re

from quadshade.engine.simplify_netlist import fold_followers
from quadshade.errors import QuadshadeError

PROMISED = {
    "scan_out": {"pixel_clocks": "divides the clock through a reset; every value leads into its turn"},
}
"""Registers by entity and VHDL name whose value at power-up counts, each with why no reset sets it."""

DECIDED = {
    "depth_test": {
        "stored": "a cleared word is farther than every depth by its top bit; the others are not looked at"
    },
}
"""
Words by entity and VHDL name that a number with 0 above its bits is compared with, each with what their top
bit says. Where it is 1 the number is less. Icarus calls a comparison unknown if any bit is.
"""

_VALUE = re.compile(r"^  initial\n    (\w+) <= [^;]*;\n", re.MULTILINE)
_TABLE = re.compile(r"^  initial begin\n(    \w+\[\d+\] = \d+'b[01]+;\n)+    end\n", re.MULTILINE)


def _decide(module: str, word: str) -> str:
    """A comparison of `{1'b0, number} < word` that the word's top bit alone decides where it is 1."""
    top = re.search(rf"^  wire \[(\d+):0\] {word};$", module, re.MULTILINE)
    less = re.search(rf"^  assign (\w+) = \$unsigned\((\w+)\) < \$unsigned\({word}\);", module, re.MULTILINE)
    if not (top and less and re.search(rf"^  assign {less[2]} = {{1'b0, \w+}};$", module, re.MULTILINE)):
        raise QuadshadeError(
            f"the netlist compares nothing with {word} as DECIDED says",
            "keep quadshade.engine.unknown_registers.DECIDED in step with the VHDL",
        )
    known = f"  assign {less[1]} = {word}[{top[1]}] === 1'b1 | $unsigned({less[2]}) < $unsigned({word});"
    return module.replace(less[0], known)


def _strip(module: str) -> str:
    """One module without its registers' values; GHDL's name is entity and generics, or their hash."""
    name = re.match(r"module (\w+?)(?:_[0-9a-f]+)*\n", module)
    promised = PROMISED.get(name[1], {}) if name else {}
    for word in DECIDED.get(name[1], {}) if name else ():
        module = _decide(module, word)
    # A signal within a generate statement has its label in front.
    signals = "|".join(promised) or "(?!)"
    kept = set(re.findall(rf"^    (?:\w+_)?(?:{signals}) = (\w+); // \(isignal\)$", module, re.MULTILINE))
    return _VALUE.sub(lambda value: value[0] if value[1] in kept else "", fold_followers(module))


def without_initial_values(verilog: str) -> str:
    """
    The same circuit after a power-up that sets no register but those of ``PROMISED``.

    Parameters
    ----------
    verilog : str
      A netlist by GHDL.

    Returns
    -------
    str

    Raises
    ------
    QuadshadeError
      It sets something that is neither a register nor a constant table, or has no comparison of ``DECIDED``.
    """
    modules = re.split(r"^(?=module )", verilog, flags=re.MULTILINE)
    stripped = "".join(map(_strip, modules))
    plain = _VALUE.sub("", _TABLE.sub("", stripped))
    if left := re.search(r"^ *initial\b.*\n.*", plain, re.MULTILINE):
        raise QuadshadeError(
            f"the netlist has an initial statement of an unknown kind: {' '.join(left[0].split())}",
            "is this a netlist by GHDL 2.0?",
        )
    return stripped
