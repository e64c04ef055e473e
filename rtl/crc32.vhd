-- SPDX-License-Identifier: Apache-2.0
--
-- CRC-32 of bytes (IEEE 802.3: reflected 0x04C11DB7, ones before and after), `num_bytes` per cycle:
-- per bit, crc = (crc >> 1) xor (0xEDB88320 if the bits shifted out of crc and data differ).
--
-- Model: crc32.py.  Test: test_crc32.py.  Latency: 1 cycle.  One byte per cycle.
-- Over bytes and their own CRC, lowest byte first, the result is 0x2144DF1C (crc_residue).

library ieee;
use ieee.std_logic_1164.all;

entity crc32 is
  generic (
    num_bytes : positive := 1
  );
  port (
    clk : in std_ulogic;
    -- Begins anew; a byte in the same cycle is the first of the new ones.
    clear : in std_ulogic;
    byte_valid : in std_ulogic;
    -- The first byte lowest.
    byte_data : in std_ulogic_vector(8 * num_bytes - 1 downto 0);
    crc : out std_ulogic_vector(31 downto 0)
  );
end entity;

architecture rtl of crc32 is

  constant ones : std_ulogic_vector(31 downto 0) := x"ffffffff";
  constant polynomial : std_ulogic_vector(31 downto 0) := x"edb88320";

  signal remainder : std_ulogic_vector(31 downto 0) := x"ffffffff";

begin

  division : process (clk)
    variable v : std_ulogic_vector(31 downto 0);
    variable out_bit : std_ulogic;
  begin
    if rising_edge(clk) then
      v := remainder;
      if clear = '1' then
        v := ones;
      end if;
      if byte_valid = '1' then
        for index in 0 to 8 * num_bytes - 1 loop
          out_bit := v(0) xor byte_data(index);
          v := '0' & v(31 downto 1);
          if out_bit = '1' then
            v := v xor polynomial;
          end if;
        end loop;
      end if;
      remainder <= v;
    end if;
  end process;

  crc <= not remainder;

end architecture;
