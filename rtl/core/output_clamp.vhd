-- SPDX-License-Identifier: Apache-2.0
--
-- clamp(floor(word / 2**frac_bits), 0, 2**value_bits - 1). The host has added one half to the first word,
-- so this rounds. The top bits of the word are only sign or overshoot: one LUT a bit.
--
-- Model: output_clamp.py.  Test: test_output_clamp.py.  Latency: none, combinational.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity output_clamp is
  generic (
    word_width : positive := 32;
    frac_bits : natural := 22;
    value_bits : positive := 8
  );
  port (
    word : in u_unsigned(word_width - 1 downto 0);
    value : out u_unsigned(value_bits - 1 downto 0)
  );
end entity;

architecture rtl of output_clamp is

  constant high : natural := word_width - 1;
  signal over : std_ulogic;

begin

  assert word_width >= frac_bits + value_bits + 2
    report "output_clamp: word_width is " & integer'image(word_width)
      & ", needs frac_bits + value_bits + 2 = "
      & integer'image(frac_bits + value_bits + 2)
    severity failure;

  over <= or word(high - 1 downto frac_bits + value_bits);

  bit_gen : for index in 0 to value_bits - 1 generate
    value(index) <= (word(frac_bits + index) or over) and not word(high);
  end generate;

end architecture;
