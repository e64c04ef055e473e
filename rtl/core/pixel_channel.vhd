-- SPDX-License-Identifier: Apache-2.0
--
-- A channel along a span: value += d_col;  d_col += dd_col, modulo 2**word_width. This is the accumulator
-- that limits the clock; everything else is built to be shorter.
--
-- Model: pixel_channel.py.  Test: test_pixel_channel.py.  Latency: 1 cycle.  One pixel per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity pixel_channel is
  generic (
    word_width : positive := 32;
    max_order : natural := 2
  );
  port (
    clk : in std_ulogic;
    advance : in std_ulogic;
    load : in std_ulogic;
    span_value, span_d_col, span_dd_col : in u_unsigned(word_width - 1 downto 0);
    pixel_value : out u_unsigned(word_width - 1 downto 0)
  );
end entity;

architecture rtl of pixel_channel is

  signal value, d_col, dd_col : u_unsigned(word_width - 1 downto 0) := (others => '0');
  signal next_value, next_d_col : u_unsigned(word_width - 1 downto 0);

begin

  constant_gen : if max_order = 0 generate
    next_value <= span_value when load = '1' else value;
  end generate;

  linear_gen : if max_order > 0 generate
    value_inst : entity work.load_adder
      generic map (width => word_width)
      port map (load => load, start => span_value, value => value, step => d_col, sum => next_value);
  end generate;

  kept_gen : if max_order < 2 generate
    next_d_col <= span_d_col when load = '1' else d_col;
  end generate;

  quadratic_gen : if max_order > 1 generate
    d_col_inst : entity work.load_adder
      generic map (width => word_width)
      port map (load => load, start => span_d_col, value => d_col, step => dd_col, sum => next_d_col);
  end generate;

  accumulate : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        value <= next_value;
        d_col <= next_d_col;
        if load = '1' then
          dd_col <= span_dd_col;
        end if;
      end if;
    end if;
  end process;

  pixel_value <= value;

end architecture;
