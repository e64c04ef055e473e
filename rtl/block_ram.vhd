-- SPDX-License-Identifier: Apache-2.0
--
-- Memory of a write and a read port, in a form that GHDL and Yosys map to block RAM of ECP5 and iCE40. No
-- initial contents; what is read in the clock in which the same word is written is undefined.
--
-- Model: block_ram.py.  Test: test_block_ram.py.  Latency: 2 enabled cycles.  A word in and out per cycle.
-- The second register stands behind the multiplexer of a memory of many blocks: 100 MHz needs it there.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.screen_pkg.all;

entity block_ram is
  generic (
    num_words : positive := 512;
    data_bits : positive := 16
  );
  port (
    clk : in std_ulogic;
    write_enable : in std_ulogic;
    -- Both addresses are below num_words.
    write_address : in u_unsigned(address_bits(num_words) - 1 downto 0);
    write_data : in std_ulogic_vector(data_bits - 1 downto 0);
    -- Moves both registers of the read port.
    read_enable : in std_ulogic;
    read_address : in u_unsigned(address_bits(num_words) - 1 downto 0);
    read_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of block_ram is

  -- GHDL synthesises no memory of one word.
  function at_least_two(count : positive) return positive is
  begin
    if count < 2 then
      return 2;
    end if;
    return count;
  end function;

  type words_t is array (0 to at_least_two(num_words) - 1) of std_ulogic_vector(data_bits - 1 downto 0);
  signal words : words_t;
  signal fetched, read_reg : std_ulogic_vector(data_bits - 1 downto 0);

begin

  ports : process (clk)
  begin
    if rising_edge(clk) then
      if write_enable = '1' then
        words(to_integer(write_address)) <= write_data;
      end if;
      if read_enable = '1' then
        fetched <= words(to_integer(read_address));
        read_reg <= fetched;
      end if;
    end if;
  end process;

  read_data <= read_reg;

end architecture;
