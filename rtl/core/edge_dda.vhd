-- SPDX-License-Identifier: Apache-2.0
--
-- One edge of a triangle as an exact rational DDA: column(k) = floor((m + k dx) / dy), in adders only.
--   carry = error >= 0;  column += step + carry;  error += decrement if carry else increment
-- The low bits of the remainder never change, so there is no slope rounding and no drift.
--
-- Both sums that the next scanline may need are registers; the carry before them chooses. A load clears both
-- and comes through an or, so that the choice is one LUT and each adder ends in its register.
--
-- Model: edge_dda.py.  Test: test_edge_dda.py.
-- Latency: 1 cycle to carry, 2 to column.  One scanline per cycle.
-- Two forms lost: one adder behind a multiplexer of its second operand (fewer LUTs), and two adders before
-- a multiplexer of both sums and the load, which set the clock of the whole core.

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
    -- Of the scanline that was loaded or stepped to in the last cycle; its column follows a cycle later.
    carry : out std_ulogic;
    column : out u_unsigned(column_bits - 1 downto 0)
  );
end entity;

architecture rtl of edge_dda is

  -- The error of the scanline in the first stage, and what it is made of.
  signal error : u_signed(edge_bits downto 0);
  signal without_carry, with_carry, loaded : u_signed(edge_bits downto 0) := (others => '0');
  signal below, starting, carry_reg : std_ulogic := '0';
  signal decrement : u_signed(edge_bits downto 0) := (others => '0');
  signal increment : u_unsigned(edge_bits - 1 downto 0) := (others => '0');
  signal start, step, column_reg : u_unsigned(column_bits - 1 downto 0) := (others => '0');
  signal next_column : u_unsigned(column_bits - 1 downto 0);

begin

  error <= loaded or without_carry when below = '1' else loaded or with_carry;

  error_stage : process (clk)
  begin
    if rising_edge(clk) then
      if enable = '1' then
        if load = '1' then
          loaded <= load_error;
          without_carry <= (others => '0');
          with_carry <= (others => '0');
          increment <= load_increment;
          decrement <= load_decrement;
          start <= load_column;
          step <= load_step;
        else
          loaded <= (others => '0');
          without_carry <= error + signed('0' & increment);
          with_carry <= error + decrement;
        end if;
        below <= error(edge_bits);
        starting <= load;
      end if;
    end if;
  end process;

  column_inst : entity work.load_adder
    generic map (width => column_bits, with_carry => 1)
    port map (
      load => starting, start => start, value => column_reg, step => step, carry_in => carry_reg,
      sum => next_column
    );

  column_stage : process (clk)
  begin
    if rising_edge(clk) then
      if enable = '1' then
        column_reg <= next_column;
        carry_reg <= not error(edge_bits);
      end if;
    end if;
  end process;

  carry <= not error(edge_bits);
  column <= column_reg;

end architecture;
