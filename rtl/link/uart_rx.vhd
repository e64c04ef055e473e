-- SPDX-License-Identifier: Apache-2.0
--
-- Receives 8N1: a phase of 2**phase_bits a bit, advanced by phase_step a clock from the start bit's edge on,
-- so that any rate up to a quarter of the clock is exact on average. A bit is the majority of three samples,
-- at 3/8, 4/8 and 5/8 of it. A low stop bit is a framing error, a line low for break_bits bits a break.
--
-- Model: uart_rx.py.  Test: test_uart_rx.py.  Latency: 3 cycles after 5/8 of the stop bit.
-- A whole-clock divisor was the alternative: 4 % off at 3 Mbaud from 25 MHz.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;

entity uart_rx is
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    phase_step : in u_unsigned(phase_bits - 1 downto 0);
    rx : in std_ulogic;
    byte_valid : out std_ulogic;
    byte_data : out std_ulogic_vector(7 downto 0);
    -- The character that just ended has no stop bit.
    framing_error : out std_ulogic;
    break_seen : out std_ulogic
  );
end entity;

architecture rtl of uart_rx is

  type place_t is (idle, character, low);

  type state_t is record
    place : place_t;
    phase : u_unsigned(phase_bits - 1 downto 0);
    -- The next phase, its carry on top: the addition is a cycle ahead.
    following : u_unsigned(phase_bits downto 0);
    -- 0 start bit, 1 to 8 data, 9 stop bit.
    position : u_unsigned(3 downto 0);
    -- The samples at 3/8 and 4/8.
    early, middle : std_ulogic;
    data : std_ulogic_vector(7 downto 0);
    -- Bits in a row that were low, up to break_bits.
    low_bits : u_unsigned(4 downto 0);
    valid, framing, breaks : std_ulogic;
  end record;

  constant state_init : state_t := (
    place => idle,
    phase => (others => '0'),
    following => (others => '0'),
    position => (others => '0'),
    early => '1',
    middle => '1',
    data => (others => '0'),
    low_bits => (others => '0'),
    valid => '0',
    framing => '0',
    breaks => '0'
  );

  signal state : state_t := state_init;
  signal state_next : state_t;
  -- The line, through two registers.
  signal line_meta, line_now : std_ulogic := '1';

begin

  assert break_bits < 32 report "break_bits is " & integer'image(break_bits) severity failure;

  receive : process (all)
    variable v : state_t;
    variable eighth, eighth_after : u_unsigned(2 downto 0);
    variable bit_value : std_ulogic;
  begin
    v := state;
    v.valid := '0';
    v.framing := '0';
    v.breaks := '0';
    eighth := state.phase(phase_bits - 1 downto phase_bits - 3);
    eighth_after := state.following(phase_bits - 1 downto phase_bits - 3);

    if state.place = idle then
      v.position := (others => '0');
      v.phase := phase_step;
      v.following := phase_step & '0';
      v.low_bits := (others => '0');
      if line_now = '0' then
        v.place := character;
      end if;
    else
      v.phase := state.following(phase_bits - 1 downto 0);
      v.following := ('0' & state.following(phase_bits - 1 downto 0)) + ('0' & phase_step);
      if eighth < 3 and eighth_after >= 3 then
        v.early := line_now;
      end if;
      if eighth < 4 and eighth_after >= 4 then
        v.middle := line_now;
      end if;
      if state.following(phase_bits) = '1' and state.place = character then
        v.position := state.position + 1;
      end if;
      if eighth < 5 and eighth_after >= 5 then
        bit_value := (v.early and v.middle) or (v.early and line_now) or (v.middle and line_now);
        if bit_value = '1' then
          v.low_bits := (others => '0');
        elsif state.low_bits /= break_bits then
          v.low_bits := state.low_bits + 1;
          if state.low_bits = break_bits - 1 then
            v.breaks := '1';
          end if;
        end if;
        if state.place = character then
          if state.position = 0 then
            -- A glitch is no start bit.
            if bit_value = '1' then
              v.place := idle;
            end if;
          elsif state.position = 9 then
            v.valid := bit_value;
            v.framing := not bit_value;
            v.place := low;
            if bit_value = '1' then
              v.place := idle;
            end if;
          else
            v.data := bit_value & state.data(7 downto 1);
          end if;
        end if;
      end if;
      -- After a character without a stop bit nothing begins before the line was high.
      if state.place = low and line_now = '1' then
        v.place := idle;
      end if;
    end if;
    state_next <= v;
  end process;

  registers : process (clk)
  begin
    if rising_edge(clk) then
      line_meta <= rx;
      line_now <= line_meta;
      state <= state_next;
      if reset = '1' then
        state <= state_init;
      end if;
    end if;
  end process;

  byte_valid <= state.valid;
  byte_data <= state.data;
  framing_error <= state.framing;
  break_seen <= state.breaks;

end architecture;
