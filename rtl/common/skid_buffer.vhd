-- SPDX-License-Identifier: Apache-2.0
--
-- Two registers between a producer and a consumer that may stall: the ready towards the producer is a
-- register, so back-pressure does not ripple through the core.
--
-- Model: skid_buffer.py.  Test: test_skid_buffer.py.  Latency: 1 cycle.  One word per cycle.

library ieee;
use ieee.std_logic_1164.all;

entity skid_buffer is
  generic (
    data_bits : positive := 8
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    input_valid : in std_ulogic;
    input_ready : out std_ulogic;
    input_data : in std_ulogic_vector(data_bits - 1 downto 0);
    output_valid : out std_ulogic;
    output_ready : in std_ulogic;
    output_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of skid_buffer is

  signal front, spare : std_ulogic_vector(data_bits - 1 downto 0) := (others => '0');
  signal front_valid : std_ulogic := '0';
  -- The spare register is free: what comes in is taken.
  signal ready : std_ulogic := '1';

begin

  buffers : process (clk)
  begin
    if rising_edge(clk) then
      if ready = '1' then
        spare <= input_data;
      end if;
      if front_valid = '0' or output_ready = '1' then
        if ready = '0' then
          front <= spare;
        else
          front <= input_data;
        end if;
        front_valid <= input_valid or not ready;
        ready <= '1';
      elsif input_valid = '1' then
        ready <= '0';
      end if;
      if reset = '1' then
        front_valid <= '0';
        ready <= '1';
      end if;
    end if;
  end process;

  input_ready <= ready;
  output_valid <= front_valid;
  output_data <= front;

end architecture;
