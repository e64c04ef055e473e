-- SPDX-License-Identifier: Apache-2.0
--
-- A channel along the major edge: from scanline to scanline, modulo 2**word_width, with c the edge's carry,
--   col += dd_mixed + c dd_col;  value += row + c col (the new one);  row += dd_row + c dd_mixed
-- so that value is I at the span's first pixel centre and col + dd_col the first step to the right.
-- A carry is one more pixel step: nothing is multiplied and no second set of row differences is kept.
--
-- Model: scanline_channel.py.  Test: test_scanline_channel.py.
-- Latency: 4 enabled cycles from stage 2 to the span.  One scanline per enabled cycle.
-- Keeping a second row difference for carried steps was tried first: 160 LUTs a channel more.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity scanline_channel is
  generic (
    word_width : positive := 32;
    -- 0 constant, 1 linear, 2 quadratic.
    max_order : natural := 2;
    -- 1: the words stay at the inputs while a scanline of theirs is on its way; no copy is kept.
    inputs_stay : natural := 0
  );
  port (
    clk : in std_ulogic;
    enable : in std_ulogic;
    -- A primitive's first scanline has just come to stage 1: take its words, enabled or not.
    copy : in std_ulogic;
    setup_value, setup_d_row, setup_d_col : in u_unsigned(word_width - 1 downto 0);
    setup_dd_row, setup_dd_mixed, setup_dd_col : in u_unsigned(word_width - 1 downto 0);
    -- The scanline in stage 2.
    first : in std_ulogic;
    carry : in std_ulogic;
    -- The scanline in stage 6.
    span_value : out u_unsigned(word_width - 1 downto 0);
    span_d_col : out u_unsigned(word_width - 1 downto 0);
    span_dd_col : out u_unsigned(word_width - 1 downto 0)
  );
end entity;

architecture rtl of scanline_channel is

  subtype word_t is u_unsigned(word_width - 1 downto 0);
  constant zero : word_t := (others => '0');

  -- The primitive's words.
  signal value_0, row_0, col_0, dd_row_0, dd_mixed_0, dd_col_0 : word_t := zero;
  signal value_4, value_6 : word_t := zero;
  signal first_3, first_4, first_5 : std_ulogic := '0';

begin

  assert max_order <= 2
    report "scanline_channel: max_order is " & integer'image(max_order) & ", must be 0, 1 or 2"
    severity failure;

  -- The start value hops twice, so that the next primitive's words may follow three scanlines behind.
  start : process (clk)
  begin
    if rising_edge(clk) then
      -- The primitive before has used its own by now, this one's stays: no enable.
      if first_3 = '1' then
        value_4 <= value_0;
      end if;
      if enable = '1' then
        first_3 <= first;
        first_4 <= first_3;
        first_5 <= first_4;
      end if;
    end if;
  end process;

  copy_gen : if inputs_stay = 0 generate
    copies : process (clk)
    begin
      if rising_edge(clk) then
        if copy = '1' then
          value_0 <= setup_value;
          row_0 <= setup_d_row;
          col_0 <= setup_d_col;
          dd_row_0 <= setup_dd_row;
          dd_mixed_0 <= setup_dd_mixed;
          dd_col_0 <= setup_dd_col;
        end if;
      end if;
    end process;
  end generate;

  wires_gen : if inputs_stay = 1 generate
    value_0 <= setup_value;
    row_0 <= setup_d_row;
    col_0 <= setup_d_col;
    dd_row_0 <= setup_dd_row;
    dd_mixed_0 <= setup_dd_mixed;
    dd_col_0 <= setup_dd_col;
  end generate;

  constant_gen : if max_order = 0 generate
    value_stage : process (clk)
    begin
      if rising_edge(clk) then
        if enable = '1' and first_5 = '1' then
          value_6 <= value_4;
        end if;
      end if;
    end process;
    span_d_col <= zero;
    span_dd_col <= zero;
  end generate;

  varying_gen : if max_order > 0 generate
    signal carry_3, carry_4 : std_ulogic := '0';
    signal row_3, row_4, row_5, col_3, col_5, step_6 : word_t := zero;
    signal first_col_4, first_col_5, first_col_6 : word_t := zero;
    signal first_col, next_value : word_t;
  begin

    linear_gen : if max_order = 1 generate
      row_and_col : process (clk)
      begin
        if rising_edge(clk) then
          if enable = '1' and first = '1' then
            row_3 <= row_0;
            col_3 <= col_0;
          end if;
        end if;
      end process;
      first_col <= col_3;
      span_dd_col <= zero;
    end generate;

    quadratic_gen : if max_order = 2 generate
      signal dd_row_carry_0, dd_mixed_carry_0, dd_col_3, dd_col_6 : word_t := zero;
      signal row_step_3, col_step_3 : word_t := zero;
      signal next_row, next_col : word_t;
    begin
      row_inst : entity work.load_adder
        generic map (width => word_width)
        port map (load => first, start => row_0, value => row_3, step => row_step_3, sum => next_row);

      col_inst : entity work.load_adder
        generic map (width => word_width)
        port map (load => first, start => col_0, value => col_3, step => col_step_3, sum => next_col);

      row_and_col : process (clk)
      begin
        if rising_edge(clk) then
          if copy = '1' then
            dd_row_carry_0 <= setup_dd_row + setup_dd_mixed;
            dd_mixed_carry_0 <= setup_dd_mixed + setup_dd_col;
          end if;
          if enable = '1' then
            if carry = '1' then
              row_step_3 <= dd_row_carry_0;
              col_step_3 <= dd_mixed_carry_0;
            else
              row_step_3 <= dd_row_0;
              col_step_3 <= dd_mixed_0;
            end if;
            row_3 <= next_row;
            col_3 <= next_col;
            if first = '1' then
              dd_col_3 <= dd_col_0;
            end if;
            if first_5 = '1' then
              dd_col_6 <= dd_col_3;
            end if;
          end if;
        end if;
      end process;
      first_col <= col_3 + dd_col_3;
      span_dd_col <= dd_col_6;
    end generate;

    value_inst : entity work.load_adder
      generic map (width => word_width)
      port map (load => first_5, start => value_4, value => value_6, step => step_6, sum => next_value);

    -- When a scanline is in stage 4, col_3 is already that of the next one: the step the carry adds.
    value_stages : process (clk)
    begin
      if rising_edge(clk) then
        if enable = '1' then
          carry_3 <= carry;
          carry_4 <= carry_3;
          row_4 <= row_3;
          row_5 <= row_4;
          if carry_4 = '1' then
            col_5 <= col_3;
          else
            col_5 <= zero;
          end if;
          step_6 <= row_5 + col_5;
          value_6 <= next_value;
          first_col_4 <= first_col;
          first_col_5 <= first_col_4;
          first_col_6 <= first_col_5;
        end if;
      end if;
    end process;

    span_d_col <= first_col_6;
  end generate;

  span_value <= value_6;

end architecture;
