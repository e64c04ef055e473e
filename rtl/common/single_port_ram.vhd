-- SPDX-License-Identifier: Apache-2.0
--
-- Memory of one port, for many words of few bits: a cycle writes, or moves both registers of the read port.
-- No initial contents; after a cycle that writes, what was fetched for the second register is undefined.
-- On iCE40UP5K synth/cells/single_port_ram.v takes its place: SPRAM, two words of eight bits side by side.
--
-- Model: single_port_ram.py.  Test: test_single_port_ram.py.  Latency: 2 enabled cycles.
-- A word in or out per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity single_port_ram is
  generic (
    num_words : positive := 512;
    data_bits : positive := 8
  );
  port (
    clk : in std_ulogic;
    write_enable : in std_ulogic;
    -- Both addresses are below num_words.
    write_address : in u_unsigned(address_bits(num_words) - 1 downto 0);
    write_data : in std_ulogic_vector(data_bits - 1 downto 0);
    read_enable : in std_ulogic;
    read_address : in u_unsigned(address_bits(num_words) - 1 downto 0);
    read_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of single_port_ram is

  type words_t is array (0 to num_words - 1) of std_ulogic_vector(data_bits - 1 downto 0);
  signal words : words_t;
  signal fetched, read_reg : std_ulogic_vector(data_bits - 1 downto 0);
  signal address : u_unsigned(address_bits(num_words) - 1 downto 0);

begin

  assert num_words >= 2
    report "single_port_ram: num_words is " & integer'image(num_words) & ", must be at least 2"
    severity failure;

  address <= write_address when write_enable = '1' else read_address;

  port_access : process (clk)
  begin
    if rising_edge(clk) then
      if write_enable = '1' then
        words(to_integer(address)) <= write_data;
      end if;
      if read_enable = '1' then
        fetched <= words(to_integer(address));
        read_reg <= fetched;
      end if;
    end if;
  end process;

  read_data <= read_reg;

end architecture;
