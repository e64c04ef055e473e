-- SPDX-License-Identifier: Apache-2.0
--
-- What stands before an accumulator's register: sum = start if load, else value + step, and carry_in where
-- with_carry is 1, modulo 2**width.
--
-- An entity of its own, because ECP5's carry cell does all of it in one (synth/cells/load_adder.v) and Yosys
-- does not see that: it puts the choice in a LUT behind the adder, which set the clock of the whole core.
--
-- Model: load_adder.py.  Test: test_load_adder.py.
-- Latency: combinational.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity load_adder is
  generic (
    width : positive := 32;
    with_carry : natural := 0
  );
  port (
    load : in std_ulogic;
    start, value, step : in u_unsigned(width - 1 downto 0);
    carry_in : in std_ulogic := '0';
    sum : out u_unsigned(width - 1 downto 0)
  );
end entity;

architecture rtl of load_adder is

  signal stepped : u_unsigned(width - 1 downto 0);

begin

  plain_gen : if with_carry = 0 generate
    stepped <= value + step;
  end generate;

  carry_gen : if with_carry = 1 generate
    signal carry : u_unsigned(0 downto 0);
  begin
    carry(0) <= carry_in;
    stepped <= value + step + carry;
  end generate;

  sum <= start when load = '1' else stepped;

end architecture;
