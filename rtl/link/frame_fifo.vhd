-- SPDX-License-Identifier: Apache-2.0
--
-- FIFO of words that count only once they are committed: a frame is written while it comes in, and then
-- stays, or is forgotten as if it had never come. free = num_words - committed words that were not yet read.
--
-- Model: frame_fifo.py.  Test: test_frame_fifo.py.
-- Latency: 5 cycles from commit to output.  A word in per cycle, and one out every 5.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity frame_fifo is
  generic (
    -- A power of two.
    num_words : positive := 512;
    data_bits : positive := 32;
    -- Of block_ram, at most 4: where the device is full of memory, this one's blocks are anywhere.
    read_stages : positive := 4
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    -- Dropped if there is no room; then `overflow` is high up to the frame's end.
    write_valid : in std_ulogic;
    write_data : in std_ulogic_vector(data_bits - 1 downto 0);
    -- The frame ends: its words stay (not after an overflow), or go. No word is written in that cycle.
    commit : in std_ulogic;
    discard : in std_ulogic;
    overflow : out std_ulogic;
    free : out u_unsigned(address_bits(num_words) downto 0);
    read_valid : out std_ulogic;
    read_ready : in std_ulogic;
    read_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of frame_fifo is

  constant address_width : positive := address_bits(num_words);

  -- One bit more than an address: the same address is empty or full.
  subtype pointer_t is u_unsigned(address_width downto 0);

  type place_t is (empty, asking, fetching, arriving, shown);

  signal written, committed, taken : pointer_t := (others => '0');
  signal overflowed, store : std_ulogic := '0';
  signal place : place_t := empty;

begin

  assert 2 ** address_width = num_words
    report "generic num_words is " & integer'image(num_words) & "; give a power of two"
    severity failure;
  assert read_stages <= 4
    report "frame_fifo: read_stages is " & integer'image(read_stages) & ", must be 2, 3 or 4"
    severity failure;

  store <= write_valid when (written - taken) /= num_words else '0';

  memory : entity work.block_ram
    generic map (
      num_words => num_words,
      data_bits => data_bits,
      read_stages => read_stages
    )
    port map (
      clk => clk,
      write_enable => store,
      write_address => written(address_width - 1 downto 0),
      write_data => write_data,
      read_enable => '1',
      read_address => taken(address_width - 1 downto 0),
      read_data => read_data
    );

  writing : process (clk)
  begin
    if rising_edge(clk) then
      if store = '1' then
        written <= written + 1;
      elsif write_valid = '1' then
        overflowed <= '1';
      end if;
      if commit = '1' or discard = '1' then
        overflowed <= '0';
        if commit = '1' and overflowed = '0' then
          committed <= written;
        else
          written <= committed;
        end if;
      end if;
      if reset = '1' then
        written <= (others => '0');
        committed <= (others => '0');
        overflowed <= '0';
      end if;
    end if;
  end process;

  reading : process (clk)
  begin
    if rising_edge(clk) then
      -- No case statement: GHDL 2.0 gives that of all places no default, and Yosys a latch.
      if place = empty then
        if taken /= committed then
          place <= asking;
        end if;
      elsif place = asking then
        place <= fetching;
      elsif place = fetching then
        place <= arriving;
      elsif place = arriving then
        place <= shown;
      else
        if read_ready = '1' then
          taken <= taken + 1;
          place <= empty;
        end if;
      end if;
      if reset = '1' then
        taken <= (others => '0');
        place <= empty;
      end if;
    end if;
  end process;

  overflow <= overflowed;
  read_valid <= '1' when place = shown else '0';
  free <= to_unsigned(num_words, address_width + 1) - (committed - taken);

end architecture;
