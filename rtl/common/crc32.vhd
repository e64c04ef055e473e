-- SPDX-License-Identifier: Apache-2.0
--
-- CRC-32 of bytes (IEEE 802.3: reflected 0x04C11DB7, ones before and after), `num_bytes` per cycle:
-- per bit, crc = (crc >> 1) xor (0xEDB88320 if the bits shifted out of crc and data differ).
--
-- Model: crc32.py.  Test: test_crc32.py.  Latency: 1 cycle, 1 + `cycles` if that is more than 1.
-- A word per cycle, or per `cycles`: half the logic with 4, for lines are slow.
-- Over bytes and their own CRC, lowest byte first, the result is 0x2144DF1C (crc_residue).

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity crc32 is
  generic (
    num_bytes : positive := 1;
    -- Cycles that a word takes, a divisor of its bits; a word may come in any cycle without busy.
    cycles : positive := 1
  );
  port (
    clk : in std_ulogic;
    -- Begins anew; a byte in the same cycle is the first of the new ones.
    clear : in std_ulogic;
    byte_valid : in std_ulogic;
    -- The first byte lowest.
    byte_data : in std_ulogic_vector(8 * num_bytes - 1 downto 0);
    busy : out std_ulogic;
    -- Of all words so far, in cycles without busy.
    crc : out std_ulogic_vector(31 downto 0)
  );
end entity;

architecture rtl of crc32 is

  constant ones : std_ulogic_vector(31 downto 0) := x"ffffffff";
  constant polynomial : std_ulogic_vector(31 downto 0) := x"edb88320";

  constant step_bits : positive := 8 * num_bytes / cycles;

  signal remainder : std_ulogic_vector(31 downto 0) := x"ffffffff";
  signal step_valid : std_ulogic;
  signal step_data : std_ulogic_vector(step_bits - 1 downto 0);

begin

  assert (8 * num_bytes) mod cycles = 0
    report "crc32: cycles is " & integer'image(cycles) & ", must divide " & integer'image(8 * num_bytes)
    severity failure;

  at_once_gen : if cycles = 1 generate
    step_valid <= byte_valid;
    step_data <= byte_data;
    busy <= '0';
  end generate;

  in_steps_gen : if cycles > 1 generate
    signal left : natural range 0 to cycles := 0;
    signal rest : std_ulogic_vector(8 * num_bytes - 1 downto 0) := (others => '0');
  begin
    steps : process (clk)
    begin
      if rising_edge(clk) then
        rest <= std_ulogic_vector(shift_right(unsigned(rest), step_bits));
        if left /= 0 then
          left <= left - 1;
        end if;
        if clear = '1' then
          left <= 0;
        end if;
        if byte_valid = '1' then
          rest <= byte_data;
          left <= cycles;
        end if;
      end if;
    end process;
    step_valid <= '1' when left /= 0 and clear = '0' else '0';
    busy <= '1' when left /= 0 else '0';
    step_data <= rest(step_bits - 1 downto 0);
  end generate;

  division : process (clk)
    variable v : std_ulogic_vector(31 downto 0);
    variable out_bit : std_ulogic;
  begin
    if rising_edge(clk) then
      v := remainder;
      if clear = '1' then
        v := ones;
      end if;
      if step_valid = '1' then
        for index in 0 to step_bits - 1 loop
          out_bit := v(0) xor step_data(index);
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
