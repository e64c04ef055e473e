-- SPDX-License-Identifier: Apache-2.0
--
-- A cosine through a curve: the distance t from 1 (the value's bits inverted) as a floating-point number
-- with 5 bits below its leading one is the index, the bits below those interpolate.
--   power = here + round((there - here) * fraction / 2**fraction_bits),  word = there & here
--
-- Model: power_table.py.  Test: test_power_table.py.  Latency: power_stages (8) enabled cycles.
-- One value per enabled cycle. One block RAM of 512 words, one multiplier.
-- An equidistant table of that size is off by 52 grey levels at an exponent of 1024.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
use work.memory_pkg.all;

entity power_table is
  generic (
    lane_value_bits : positive := 18
  );
  port (
    clk : in std_ulogic;

    -- Moves all stages.
    advance : in std_ulogic;
    value : in u_unsigned(lane_value_bits - 1 downto 0);
    power : out u_unsigned(power_bits - 1 downto 0);

    -- A word is in the table two cycles later.
    write_enable : in std_ulogic;
    write_address : in u_unsigned(address_bits(table_words) - 1 downto 0);
    write_data : in std_ulogic_vector(2 * power_bits - 1 downto 0)
  );
end entity;

architecture rtl of power_table is

  constant index_bits : positive := address_bits(table_words);
  -- The leading one and the mantissa; what lies below them in the widest octave is the fraction.
  constant top_bits : positive := power_mantissa_bits + 1;
  constant fraction_bits : positive := lane_value_bits - top_bits;
  -- Which octave, counted from 1; 0 is where the leading one is too low to be left out of the index.
  constant row_bits : positive := index_bits - power_mantissa_bits;
  constant shift_bits : positive := 4;

  subtype row_t is u_unsigned(row_bits - 1 downto 0);
  subtype shift_t is u_unsigned(shift_bits - 1 downto 0);
  subtype far_t is u_unsigned(lane_value_bits - 1 downto 0);
  subtype fraction_t is u_unsigned(fraction_bits - 1 downto 0);
  subtype power_t is u_unsigned(power_bits - 1 downto 0);

  -- Numbered by stage.
  signal far_1, far_2, far_3 : far_t := (others => '0');
  signal row_1, row_2, row_3 : row_t := (others => '0');
  signal shift_1 : shift_t := (others => '0');
  signal shift_2 : u_unsigned(1 downto 0) := (others => '0');
  signal fraction_4, fraction_5, fraction_6 : fraction_t := (others => '0');
  signal here_6, here_7, power_8 : power_t := (others => '0');
  signal difference_6 : u_signed(power_bits downto 0) := (others => '0');
  signal product_7 : u_signed(power_bits + fraction_bits + 1 downto 0) := (others => '0');

  signal fetch_address : u_unsigned(index_bits - 1 downto 0);
  signal word_5 : std_ulogic_vector(2 * power_bits - 1 downto 0);
  signal total_7 : u_signed(power_bits + fraction_bits + 1 downto 0);
  signal below_7 : fraction_t;

begin

  assert lane_value_bits >= top_bits + 2 and lane_value_bits <= factor_bits
    report "power_table: lane_value_bits is " & integer'image(lane_value_bits) & "; give a value from "
      & integer'image(top_bits + 2) & " to " & integer'image(factor_bits)
    severity failure;

  -- Stage 1: where the leading one is, and by how many bits it must move to the top.
  leading_one : process (clk)
    variable row : row_t;
    variable shift : shift_t;
  begin
    if rising_edge(clk) then
      if advance = '1' then
        far_1 <= not value;
        row := to_unsigned(0, row_bits);
        shift := to_unsigned(fraction_bits, shift_bits);
        for place in power_mantissa_bits to lane_value_bits - 1 loop
          if value(place) = '0' then
            row := to_unsigned(place - power_mantissa_bits + 1, row_bits);
            shift := to_unsigned(lane_value_bits - 1 - place, shift_bits);
          end if;
        end loop;
        row_1 <= row;
        shift_1 <= shift;
      end if;
    end if;
  end process;

  -- Stages 2 and 3: by multiples of four bits, then by the rest.
  normalise : process (clk)
    variable coarse, fine : far_t;
  begin
    if rising_edge(clk) then
      if advance = '1' then
        coarse := far_1;
        if shift_1(3) = '1' then
          coarse := shift_left(coarse, 8);
        end if;
        if shift_1(2) = '1' then
          coarse := shift_left(coarse, 4);
        end if;
        far_2 <= coarse;
        shift_2 <= shift_1(1 downto 0);
        row_2 <= row_1;
        fine := far_2;
        if shift_2(1) = '1' then
          fine := shift_left(fine, 2);
        end if;
        if shift_2(0) = '1' then
          fine := shift_left(fine, 1);
        end if;
        far_3 <= fine;
        row_3 <= row_2;
      end if;
    end if;
  end process;

  fetch_address <= row_3 & far_3(lane_value_bits - 2 downto fraction_bits);

  -- Stages 4 and 5.
  memory_inst : entity work.block_ram
    generic map (num_words => table_words, data_bits => 2 * power_bits)
    port map (
      clk => clk,
      write_enable => write_enable, write_address => write_address, write_data => write_data,
      read_enable => advance, read_address => fetch_address, read_data => word_5
    );

  below_7 <= shift_left(to_unsigned(1, fraction_bits), fraction_bits - 1);
  -- The half that rounds stands below the value where the interval begins.
  total_7 <= signed("00" & here_7 & below_7) + product_7;

  interpolate : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        fraction_4 <= far_3(fraction_bits - 1 downto 0);
        fraction_5 <= fraction_4;
        fraction_6 <= fraction_5;
        here_6 <= unsigned(word_5(power_bits - 1 downto 0));
        difference_6 <= signed('0' & word_5(2 * power_bits - 1 downto power_bits))
          - signed('0' & word_5(power_bits - 1 downto 0));
        here_7 <= here_6;
        product_7 <= difference_6 * signed('0' & fraction_6);
        power_8 <= unsigned(total_7(power_bits + fraction_bits - 1 downto fraction_bits));
      end if;
    end if;
  end process;

  power <= power_8;

end architecture;
