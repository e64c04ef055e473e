-- SPDX-License-Identifier: Apache-2.0
--
-- A byte, or two control bits, as a ten-bit word of a TMDS data channel: few transitions, and over a line as
-- many ones as zeros (Digital Visual Interface, revision 1.0, figure 3-5).
--
-- Model: tmds_encoder.py.  Test: test_tmds_encoder.py.
-- Latency: 4 enabled cycles.  A word per enabled cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity tmds_encoder is
  port (
    clk : in std_ulogic;
    enable : in std_ulogic;
    -- The byte is shown; else the control bits are.
    active : in std_ulogic;
    value : in u_unsigned(7 downto 0);
    control : in std_ulogic_vector(1 downto 0);
    -- Bit 0 goes first.
    word : out std_ulogic_vector(9 downto 0)
  );
end entity;

architecture rtl of tmds_encoder is

  subtype byte_t is std_ulogic_vector(7 downto 0);
  subtype control_t is std_ulogic_vector(1 downto 0);

  -- Numbered by stage: ones counted, transitions made few, ones counted again.
  signal active_1, active_2, active_3 : std_ulogic := '0';
  signal control_1, control_2, control_3 : control_t := (others => '0');
  signal byte_1, byte_2, byte_3 : byte_t := (others => '0');
  -- Every bit is the equality with the one before it, not the difference.
  signal equal_1, equal_2, equal_3 : std_ulogic := '0';
  -- Ones above four, that is half of ones minus zeros.
  signal excess_3 : signed(3 downto 0) := (others => '0');
  -- Half of all ones minus zeros since the line began.
  signal disparity : signed(3 downto 0) := (others => '0');
  signal word_4 : std_ulogic_vector(9 downto 0) := (others => '0');

  function count_ones(bits : byte_t) return u_unsigned is
    variable count : u_unsigned(3 downto 0) := (others => '0');
  begin
    for index in bits'range loop
      if bits(index) = '1' then
        count := count + 1;
      end if;
    end loop;
    return count;
  end function;

begin

  encode : process (clk)
    variable ones : u_unsigned(3 downto 0);
    variable bits : byte_t;
    variable inverts : std_ulogic;
    variable change : signed(3 downto 0);
  begin
    if rising_edge(clk) then
      if enable = '1' then
        active_1 <= active;
        control_1 <= control;
        byte_1 <= std_ulogic_vector(value);
        ones := count_ones(std_ulogic_vector(value));
        equal_1 <= '0';
        if ones > 4 or (ones = 4 and value(0) = '0') then
          equal_1 <= '1';
        end if;

        active_2 <= active_1;
        control_2 <= control_1;
        equal_2 <= equal_1;
        bits := byte_1;
        for index in 1 to 7 loop
          bits(index) := bits(index - 1) xor byte_1(index) xor equal_1;
        end loop;
        byte_2 <= bits;

        active_3 <= active_2;
        control_3 <= control_2;
        equal_3 <= equal_2;
        byte_3 <= byte_2;
        excess_3 <= signed(count_ones(byte_2)) - 4;

        -- With the ninth bit, one if it was the difference, and the tenth, one if the byte is inverted.
        inverts := equal_3;
        if disparity /= 0 and excess_3 /= 0 then
          inverts := not (disparity(3) xor excess_3(3));
        end if;
        change := excess_3;
        if inverts = '1' then
          change := -excess_3;
        end if;
        if disparity /= 0 and excess_3 /= 0 then
          if inverts = '1' and equal_3 = '0' then
            change := change + 1;
          elsif inverts = '0' and equal_3 = '1' then
            change := change - 1;
          end if;
        end if;
        if active_3 = '1' then
          word_4 <= inverts & not equal_3 & (byte_3 xor byte_t'(others => inverts));
          disparity <= disparity + change;
        else
          disparity <= (others => '0');
          if control_3 = "00" then
            word_4 <= "1101010100";
          elsif control_3 = "01" then
            word_4 <= "0010101011";
          elsif control_3 = "10" then
            word_4 <= "0101010100";
          else
            word_4 <= "1010101011";
          end if;
        end if;
      end if;
    end if;
  end process;

  word <= word_4;

end architecture;
