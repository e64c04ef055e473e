-- SPDX-License-Identifier: Apache-2.0
--
-- One edge of a triangle as an exact rational DDA: column(k) = floor((m + k dx) / dy), in adders only.
--   carry = error >= 0;  column += step + carry;  error += decrement if carry else increment
-- The low bits of the remainder never change, so there is no slope rounding and no drift.
--
-- Model: edge_dda.py.  Test: test_edge_dda.py.
-- Latency: 2 cycles, to carry and to column.  One scanline per cycle.
-- One adder behind a multiplexer of its second operand was the first idea: 23 LUTs less, but the
-- multiplexer and its select then stand in front of the carry chain; two adders and a choice do not.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity edge_dda is
  generic (
    column_bits : positive := 13;
    edge_bits : positive := 22
  );
  port (
    clk : in std_ulogic;
    enable : in std_ulogic;
    -- Start a new edge; without it, step one scanline down.
    load : in std_ulogic;
    load_column : in u_unsigned(column_bits - 1 downto 0);
    load_error : in u_signed(edge_bits downto 0);
    load_step : in u_unsigned(column_bits - 1 downto 0);
    load_increment : in u_unsigned(edge_bits - 1 downto 0);
    load_decrement : in u_signed(edge_bits downto 0);
    -- Both belong to the same scanline, one cycle after it was loaded or stepped to.
    carry : out std_ulogic;
    column : out u_unsigned(column_bits - 1 downto 0)
  );
end entity;

architecture rtl of edge_dda is

  signal error, decrement : u_signed(edge_bits downto 0) := (others => '0');
  signal increment : u_unsigned(edge_bits - 1 downto 0) := (others => '0');
  signal start, step, column_reg : u_unsigned(column_bits - 1 downto 0) := (others => '0');
  signal starting, carry_reg : std_ulogic := '0';

begin

  error_stage : process (clk)
    variable without_carry, with_carry : u_signed(edge_bits downto 0);
  begin
    if rising_edge(clk) then
      if enable = '1' then
        without_carry := error + signed('0' & increment);
        with_carry := error + decrement;
        if load = '1' then
          error <= load_error;
          increment <= load_increment;
          decrement <= load_decrement;
          start <= load_column;
          step <= load_step;
        elsif error(edge_bits) = '1' then
          error <= without_carry;
        else
          error <= with_carry;
        end if;
        starting <= load;
      end if;
    end if;
  end process;

  column_stage : process (clk)
    variable carry_in : u_unsigned(0 downto 0);
  begin
    if rising_edge(clk) then
      if enable = '1' then
        carry_in(0) := carry_reg;
        if starting = '1' then
          column_reg <= start;
        else
          column_reg <= column_reg + step + carry_in;
        end if;
        carry_reg <= not error(edge_bits);
      end if;
    end if;
  end process;

  carry <= carry_reg;
  column <= column_reg;

end architecture;
