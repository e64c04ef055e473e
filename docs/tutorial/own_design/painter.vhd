-- SPDX-License-Identifier: Apache-2.0
--
-- A picture that paints itself: on `start` the set-up stream of picture_pkg goes into a raster_core, and each
-- pixel becomes a write to a memory of the design, here its own: screen_width * screen_height colours.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.picture_pkg.all;

entity painter is
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    start : in std_ulogic;
    -- Every beat was taken, every pixel written.
    done : out std_ulogic;
    -- The picture's read port: the colour of an address a cycle later, red highest.
    read_address : in natural range 0 to screen_width * screen_height - 1;
    read_colour : out std_ulogic_vector(23 downto 0)
  );
end entity;

architecture rtl of painter is

  signal setup_valid, setup_ready, idle : std_ulogic;
  signal next_beat : natural range 0 to setup_beats'length := setup_beats'length;

  signal pixel_valid : std_ulogic;
  signal pixel_x, pixel_y : u_unsigned(coord_bits - 1 downto 0);
  signal pixel_value : u_unsigned(8 * num_channels - 1 downto 0);

  type memory_t is array (0 to screen_width * screen_height - 1) of std_ulogic_vector(23 downto 0);
  signal memory : memory_t := (others => (others => '0'));

begin

  -- A beat is taken in a clock with valid and ready, and the next one follows.
  setup_valid <= '1' when next_beat < setup_beats'length else '0';
  done <= idle and not setup_valid;

  beats : process (clk)
  begin
    if rising_edge(clk) then
      if start = '1' then
        next_beat <= 0;
      elsif setup_valid = '1' and setup_ready = '1' then
        next_beat <= next_beat + 1;
      end if;
      if reset = '1' then
        next_beat <= setup_beats'length;
      end if;
    end if;
  end process;

  core_inst : entity work.raster_core
    generic map (
      num_channels => num_channels, with_depth => with_depth, coord_bits => coord_bits,
      subpixel_bits => subpixel_bits, word_width => word_width, frac_bits => frac_bits
    )
    port map (
      clk => clk, reset => reset,
      setup_valid => setup_valid, setup_ready => setup_ready,
      setup_data => setup_beats(next_beat mod setup_beats'length),
      -- A memory takes a pixel in every clock; what cannot lowers ready.
      pixel_valid => pixel_valid, pixel_ready => '1', pixel_last => open,
      pixel_x => pixel_x, pixel_y => pixel_y, pixel_value => pixel_value, pixel_depth => open,
      idle => idle
    );

  pixels : process (clk)
    variable address : natural;
  begin
    if rising_edge(clk) then
      if pixel_valid = '1' then
        address := to_integer(pixel_y) * screen_width + to_integer(pixel_x);
        -- Channel 0, red, is lowest in the core's word.
        memory(address) <= std_ulogic_vector(
          pixel_value(7 downto 0) & pixel_value(15 downto 8) & pixel_value(23 downto 16));
      end if;
      read_colour <= memory(read_address);
    end if;
  end process;

end architecture;
