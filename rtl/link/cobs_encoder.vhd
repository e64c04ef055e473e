-- SPDX-License-Identifier: Apache-2.0
--
-- Bytes of a frame to bytes of the line: 00, COBS, 00. A block is gathered up to its zero, 254 bytes, or the
-- frame's end, and then sent behind its code; a zero at the very end needs an empty block behind it.
--
-- Model: cobs_encoder.py.  Test: test_cobs_encoder.py.  Latency: a block.
-- Throughput: a byte takes 1 cycle to gather and 3 to send: far less than on a line.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity cobs_encoder is
  port (
    clk : in std_ulogic;
    -- Forgets a frame; what was sent of it is noise, which the next frame's leading 00 ends.
    reset : in std_ulogic;
    byte_valid : in std_ulogic;
    byte_ready : out std_ulogic;
    byte_data : in std_ulogic_vector(7 downto 0);
    byte_last : in std_ulogic;
    -- Nothing is begun.
    idle : out std_ulogic;
    line_valid : out std_ulogic;
    line_ready : in std_ulogic;
    line_data : out std_ulogic_vector(7 downto 0)
  );
end entity;

architecture rtl of cobs_encoder is

  constant longest : positive := 254;

  type place_t is (waiting, leading, gathering, code, fetching, arriving, sending, trailing);

  signal fetched : std_ulogic_vector(7 downto 0);
  signal place : place_t := waiting;
  -- Bytes in the buffer, and of these, sent.
  signal count, sent : u_unsigned(7 downto 0) := (others => '0');
  -- The frame's last byte is in the block, and it is a zero.
  signal last_seen, zero_last : std_ulogic := '0';
  signal store : std_ulogic;

begin

  store <= byte_valid when place = gathering else '0';

  memory : entity work.block_ram
    generic map (
      num_words => 256,
      data_bits => 8
    )
    port map (
      clk => clk,
      write_enable => store, write_address => count, write_data => byte_data,
      read_enable => '1', read_address => sent, read_data => fetched
    );

  control : process (clk)
  begin
    if rising_edge(clk) then
      -- No case statement: GHDL 2.0 gives that of all places no default, and Yosys a latch.
      if place = waiting then
        if byte_valid = '1' then
          place <= leading;
        end if;
        count <= (others => '0');
        last_seen <= '0';
        zero_last <= '0';
      elsif place = leading then
        if line_ready = '1' then
          place <= gathering;
        end if;
      elsif place = gathering then
        sent <= (others => '0');
        if byte_valid = '1' then
          last_seen <= byte_last;
          if byte_data = x"00" then
            zero_last <= byte_last;
            place <= code;
          else
            count <= count + 1;
            if byte_last = '1' or count = longest - 1 then
              place <= code;
            end if;
          end if;
        end if;
      elsif place = code then
        if line_ready = '1' then
          place <= fetching;
        end if;
      elsif place = fetching then
        -- Also where a block is done: the next one, the empty one, or the end.
        place <= arriving;
        if sent = count then
          count <= (others => '0');
          sent <= (others => '0');
          zero_last <= '0';
          if last_seen = '0' then
            place <= gathering;
          elsif zero_last = '1' then
            place <= code;
          else
            place <= trailing;
          end if;
        end if;
      elsif place = arriving then
        place <= sending;
      elsif place = sending then
        if line_ready = '1' then
          sent <= sent + 1;
          place <= fetching;
        end if;
      else
        if line_ready = '1' then
          place <= waiting;
        end if;
      end if;
      if reset = '1' then
        place <= waiting;
      end if;
    end if;
  end process;

  byte_ready <= '1' when place = gathering else '0';
  idle <= '1' when place = waiting else '0';
  line_valid <= '1' when place = leading or place = code or place = sending or place = trailing else '0';

  output : process (all)
  begin
    line_data <= x"00";
    if place = code then
      line_data <= std_ulogic_vector(count + 1);
    elsif place = sending then
      line_data <= fetched;
    end if;
  end process;

end architecture;
