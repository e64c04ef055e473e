-- SPDX-License-Identifier: Apache-2.0
--
-- Bytes of the line to bytes of frames (COBS): a code n says that n - 1 bytes follow and then, unless n is
-- 255 or the frame ends, a zero. A 00 on the line ends a frame, always: the next byte begins a new one.
--
-- Model: cobs_decoder.py.  Test: test_cobs_decoder.py.  Latency: 1 cycle.  One byte per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity cobs_decoder is
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    line_valid : in std_ulogic;
    line_data : in std_ulogic_vector(7 downto 0);
    -- A character was lost: the frame that it was in cannot be good.
    line_error : in std_ulogic;
    byte_valid : out std_ulogic;
    byte_data : out std_ulogic_vector(7 downto 0);
    -- A frame ended; good if it was whole. Nothing between two 00s is no frame.
    frame_end : out std_ulogic;
    frame_good : out std_ulogic
  );
end entity;

architecture rtl of cobs_decoder is

  signal begun, damaged : std_ulogic := '0';
  -- A zero is due if another block follows.
  signal zero_due : std_ulogic := '0';
  -- Bytes of the block that are still to come.
  signal remaining : u_unsigned(7 downto 0) := (others => '0');
  signal ended, good, valid : std_ulogic := '0';
  signal data : std_ulogic_vector(7 downto 0) := (others => '0');

begin

  decode : process (clk)
  begin
    if rising_edge(clk) then
      valid <= '0';
      ended <= '0';
      good <= '0';
      data <= line_data;
      if line_error = '1' then
        damaged <= '1';
      end if;
      if line_valid = '1' then
        if line_data = x"00" then
          ended <= begun or damaged;
          if remaining = 0 then
            good <= begun and not damaged;
          end if;
          begun <= '0';
          damaged <= '0';
          zero_due <= '0';
          remaining <= (others => '0');
        elsif remaining = 0 then
          begun <= '1';
          valid <= zero_due;
          data <= x"00";
          zero_due <= '1';
          if line_data = x"ff" then
            zero_due <= '0';
          end if;
          remaining <= unsigned(line_data) - 1;
        else
          valid <= '1';
          remaining <= remaining - 1;
        end if;
      end if;
      if reset = '1' then
        begun <= '0';
        damaged <= '0';
        zero_due <= '0';
        remaining <= (others => '0');
        valid <= '0';
        ended <= '0';
        good <= '0';
      end if;
    end if;
  end process;

  byte_valid <= valid;
  byte_data <= data;
  frame_end <= ended;
  frame_good <= good;

end architecture;
