-- SPDX-License-Identifier: Apache-2.0
--
-- Fills a memory on request: lets what is on its way leave first, then counts through every address.
--
-- Model: memory_clear.py.  Test: test_memory_clear.py.  Latency: 1 cycle.  One word per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity memory_clear is
  generic (
    num_words : positive := 512
  );
  port (
    clk : in std_ulogic;
    -- Starts a fill.
    reset : in std_ulogic;
    -- Taken in any cycle without busy.
    clear : in std_ulogic;
    -- Nothing is on its way to the memory.
    emptied : in std_ulogic;
    busy : out std_ulogic;
    -- The last cycle before the fill that a clear asked for.
    drained : out std_ulogic;
    filling : out std_ulogic;
    fill_address : out u_unsigned(address_bits(num_words) - 1 downto 0)
  );
end entity;

architecture rtl of memory_clear is

  signal draining : std_ulogic := '0';
  signal closed, counting : std_ulogic := '1';
  signal count : u_unsigned(address_bits(num_words) - 1 downto 0) := (others => '0');

begin

  state : process (clk)
  begin
    if rising_edge(clk) then
      if closed = '0' and clear = '1' then
        closed <= '1';
        draining <= '1';
      end if;
      if draining = '1' and emptied = '1' then
        draining <= '0';
        counting <= '1';
      end if;
      if counting = '1' then
        count <= count + 1;
        if count = num_words - 1 then
          count <= (others => '0');
          counting <= '0';
          closed <= '0';
        end if;
      end if;
      if reset = '1' then
        count <= (others => '0');
        closed <= '1';
        draining <= '0';
        counting <= '1';
      end if;
    end if;
  end process;

  busy <= closed;
  drained <= draining and emptied;
  filling <= counting;
  fill_address <= count;

end architecture;
