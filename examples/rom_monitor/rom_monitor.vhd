-- SPDX-License-Identifier: Apache-2.0
--
-- A picture on a monitor without a host: the set-up words of picture_pkg stand in a ROM, the core draws them
-- once after a reset, and the monitor shows the framebuffer for ever after.
--   ROM -> raster_core -> framebuffer -> scan_out
-- One clock is all: 25 MHz, that of the pixels of 640 x 480 at 60 Hz.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

library quadshade;
use quadshade.memory_pkg.all;

use work.picture_pkg.all;

entity rom_monitor is
  generic (
    -- Behind the picture: blue, green, red.
    background : std_ulogic_vector(23 downto 0) := x"331a1a";
    -- What the monitor shows, in squares of screen_width by screen_height. A simulation may do with less.
    columns : positive := 640;
    lines : positive := 480
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    -- Every pixel is in the framebuffer.
    done : out std_ulogic;
    -- Of scan_out: three words of TMDS, new in the clock after one with video_next.
    video_next : out std_ulogic;
    video_words : out std_ulogic_vector(29 downto 0)
  );
end entity;

architecture rtl of rom_monitor is

  signal next_beat : natural range 0 to setup_beats'length := 0;
  signal setup_valid : std_ulogic := '0';
  signal setup_data : std_ulogic_vector(stream_width - 1 downto 0) := (others => '0');
  signal setup_ready, core_idle, framebuffer_idle : std_ulogic;

  signal pixel_valid, pixel_ready : std_ulogic;
  signal pixel_x, pixel_y : u_unsigned(coord_bits - 1 downto 0);
  signal pixel_value : u_unsigned(8 * num_channels - 1 downto 0);

  signal read_address : u_unsigned(address_bits(screen_width * screen_height) - 1 downto 0);
  signal read_value : u_unsigned(8 * num_channels - 1 downto 0);

begin

  -- A ROM with a register behind it is a block RAM. A word is taken in a clock with valid and ready; the next
  -- one stands there in the clock after it.
  beats : process (clk)
  begin
    if rising_edge(clk) then
      if setup_valid = '0' or setup_ready = '1' then
        setup_valid <= '0';
        if next_beat < setup_beats'length then
          setup_data <= setup_beats(next_beat);
          setup_valid <= '1';
          next_beat <= next_beat + 1;
        end if;
      end if;
      if reset = '1' then
        next_beat <= 0;
        setup_valid <= '0';
      end if;
    end if;
  end process;

  core_inst : entity quadshade.raster_core
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
      subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
      span_depth => span_depth
    )
    port map (
      clk => clk, reset => reset,
      setup_valid => setup_valid, setup_ready => setup_ready, setup_data => setup_data,
      pixel_valid => pixel_valid, pixel_ready => pixel_ready, pixel_last => open,
      pixel_x => pixel_x, pixel_y => pixel_y, pixel_value => pixel_value, pixel_depth => open,
      idle => core_idle
    );

  -- A reset starts a clear to the background; the first pixels wait for it, by pixel_ready.
  framebuffer_inst : entity quadshade.framebuffer
    generic map (
      width => screen_width, height => screen_height, coord_bits => coord_bits,
      value_bits => 8 * num_channels
    )
    port map (
      clk => clk, reset => reset, clear => '0', clear_value => u_unsigned(background),
      busy => open, idle => framebuffer_idle,
      pixel_valid => pixel_valid, pixel_ready => pixel_ready, pixel_x => pixel_x, pixel_y => pixel_y,
      pixel_value => pixel_value,
      read_enable => '1', read_address => read_address, read_value => read_value, show_value => open
    );

  done <= core_idle and framebuffer_idle and not setup_valid
    when next_beat = setup_beats'length else '0';

  monitor_inst : entity quadshade.scan_out
    generic map (
      width => screen_width, height => screen_height, num_channels => num_channels, clocks_per_pixel => 1,
      columns => columns, lines => lines
    )
    port map (
      clk => clk, reset => reset, may_read => '1', blank => open, reads => open,
      read_address => read_address, read_value => read_value,
      word_next => video_next, words => video_words
    );

end architecture;
