-- SPDX-License-Identifier: Apache-2.0
--
-- The fabric's limit: one second-order accumulator and nothing else, which the core is measured against.
--   value += d_col;  d_col += dd_col, modulo 2**word_width, or a load of all three.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity lone_accumulator is
  generic (
    word_width : positive := 32
  );
  port (
    clk : in std_ulogic;
    load : in std_ulogic;
    span_value, span_d_col, span_dd_col : in u_unsigned(word_width - 1 downto 0);
    pixel_value : out u_unsigned(word_width - 1 downto 0)
  );
end entity;

architecture rtl of lone_accumulator is

  signal value, d_col, dd_col : u_unsigned(word_width - 1 downto 0) := (others => '0');

begin

  accumulate : process (clk)
  begin
    if rising_edge(clk) then
      if load = '1' then
        value <= span_value;
        d_col <= span_d_col;
        dd_col <= span_dd_col;
      else
        value <= value + d_col;
        d_col <= d_col + dd_col;
      end if;
    end if;
  end process;

  pixel_value <= value;

end architecture;
