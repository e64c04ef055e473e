-- SPDX-License-Identifier: Apache-2.0
--
-- Sends 8N1: a phase of 2**phase_bits a bit, advanced by phase_step a clock; a bit ends where it overflows.
-- Characters follow each other without a gap and keep the phase's remainder: the rate is exact on average.
--
-- Model: uart_tx.py.  Test: test_uart_tx.py.  Latency: 1 cycle to the start bit.  10 bits a byte.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;

entity uart_tx is
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    phase_step : in u_unsigned(phase_bits - 1 downto 0);
    byte_valid : in std_ulogic;
    byte_ready : out std_ulogic;
    byte_data : in std_ulogic_vector(7 downto 0);
    -- A character is on its way.
    busy : out std_ulogic;
    tx : out std_ulogic
  );
end entity;

architecture rtl of uart_tx is

  signal phase : u_unsigned(phase_bits - 1 downto 0) := (others => '0');
  signal phase_after : u_unsigned(phase_bits downto 0);
  signal active : std_ulogic := '0';
  -- Bits that follow the one on the line.
  signal bits_left : u_unsigned(3 downto 0) := (others => '0');
  -- What is on the line, lowest, and what follows; ones behind it are the stop bit.
  signal shift : std_ulogic_vector(8 downto 0) := (others => '1');
  signal ends, ready : std_ulogic;

begin

  phase_after <= ('0' & phase) + ('0' & phase_step);
  ends <= phase_after(phase_bits) when bits_left = 0 else '0';
  ready <= ends or not active;

  send : process (clk)
  begin
    if rising_edge(clk) then
      if active = '1' then
        phase <= phase_after(phase_bits - 1 downto 0);
        if phase_after(phase_bits) = '1' then
          shift <= '1' & shift(8 downto 1);
          bits_left <= bits_left - 1;
        end if;
      else
        phase <= (others => '0');
      end if;
      if ready = '1' then
        active <= byte_valid;
        if byte_valid = '1' then
          shift <= byte_data & '0';
          bits_left <= to_unsigned(9, 4);
        end if;
      end if;
      if reset = '1' then
        active <= '0';
        shift <= (others => '1');
      end if;
    end if;
  end process;

  byte_ready <= ready;
  busy <= active;
  tx <= shift(0);

end architecture;
