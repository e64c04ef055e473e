-- SPDX-License-Identifier: Apache-2.0
--
-- Reads an area of the framebuffer in scanline order, and the CRC-32 of its bytes (channel 0 first:
-- zlib.crc32 of the picture's): `count` pixels from (x, y) on, `width` to a scanline, down to the last.
--
-- Model: read_out.py.  Test: test_read_out.py.
-- Latency: read_stages + 3 cycles from an area to its first pixel.  One pixel per cycle; the next
-- area is taken once the last pixel was.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;
use work.screen_pkg.all;

entity read_out is
  generic (
    width : positive := 320;
    height : positive := 240;
    coord_bits : positive := 12;
    -- A channel is a byte.
    num_channels : positive := 3;
    -- 0: area_count is not looked at; the area ends with the screen, or by reset.
    with_count : natural := 1;
    -- 0: there is no CRC.
    with_crc : natural := 1;
    -- Enabled cycles from an address to its value.
    read_stages : positive := 3
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    area_valid : in std_ulogic;
    area_ready : out std_ulogic;
    area_x : in u_unsigned(coord_bits - 1 downto 0);
    area_y : in u_unsigned(coord_bits - 1 downto 0);
    area_width : in u_unsigned(coord_bits downto 0);
    area_count : in u_unsigned(address_bits(width * height) downto 0);
    -- The cycle after an area was taken that is empty or not within the screen's columns: it gives no pixel.
    refused : out std_ulogic;

    -- To the framebuffer: an address, and its value read_stages enabled cycles later.
    read_enable : out std_ulogic;
    read_address : out u_unsigned(address_bits(width * height) - 1 downto 0);
    read_value : in u_unsigned(8 * num_channels - 1 downto 0);

    pixel_valid : out std_ulogic;
    pixel_ready : in std_ulogic;
    pixel_last : out std_ulogic;
    pixel_value : out u_unsigned(8 * num_channels - 1 downto 0);
    -- Of the whole area while pixel_last is shown, and until the next area is taken.
    crc : out std_ulogic_vector(31 downto 0)
  );
end entity;

architecture rtl of read_out is

  constant address_width : positive := address_bits(width * height);
  subtype address_t is u_unsigned(address_width - 1 downto 0);

  constant row_step : address_t := resize(to_unsigned(width, address_width + 1), address_width);

  signal starting, running, refused_reg : std_ulogic := '0';
  -- Of the pixel; below the first one of its scanline.
  signal row, below, address : address_t := (others => '0');
  signal x : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  -- Columns of an area's scanline, minus 1; columns, scanlines and pixels left after this one.
  signal columns, columns_left : u_unsigned(coord_bits downto 0) := (others => '0');
  signal rows_left : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  signal count_left : u_unsigned(address_width downto 0) := (others => '0');

  -- Stages of a pixel: address, the memory's registers. A pixel is there; it is the last one.
  signal valids, lasts : std_ulogic_vector(2 to read_stages + 1) := (others => '0');
  signal read_valid, read_last, reading : std_ulogic;
  signal line_end, last_1, advance, accept, fits, summed : std_ulogic;
  signal emitted, shown : std_ulogic_vector(8 * num_channels downto 0);
  signal shown_valid, idle : std_ulogic;

begin

  assert read_stages >= 2
    report "read_out: read_stages is " & integer'image(read_stages) & ", must be at least 2"
    severity failure;
  assert width <= 2**coord_bits and height <= 2**coord_bits
    report "read_out: the screen is " & integer'image(width) & " by " & integer'image(height)
      & ", coord_bits = " & integer'image(coord_bits) & " allow " & integer'image(2**coord_bits)
    severity failure;

  reading <= or valids;
  read_valid <= valids(read_stages + 1);
  read_last <= lasts(read_stages + 1);
  idle <= not (starting or running or reading or shown_valid);
  area_ready <= idle;
  accept <= area_valid and idle;
  fits <= '1' when area_width /= 0 and area_count /= 0
    and resize(area_x, coord_bits + 2) + area_width <= to_unsigned(width, coord_bits + 2)
    and resize(area_y, coord_bits + 1) < to_unsigned(height, coord_bits + 1) else '0';

  line_end <= '1' when columns_left = 0 else '0';
  last_1 <= '1' when (count_left = 0 and with_count = 1) or (columns_left = 0 and rows_left = 0) else '0';

  walk : process (clk)
  begin
    if rising_edge(clk) then
      refused_reg <= accept and not fits;
      if accept = '1' then
        starting <= fits;
        row <= row_address(area_y, width, address_width);
        x <= area_x;
        columns <= area_width - 1;
        rows_left <= to_unsigned(height - 1, coord_bits) - area_y;
        count_left <= area_count - 1;
      end if;
      if starting = '1' then
        starting <= '0';
        running <= '1';
        below <= row + resize(x, address_width) + row_step;
        address <= row + resize(x, address_width);
        columns_left <= columns;
      end if;
      if running = '1' and advance = '1' then
        running <= not last_1;
        count_left <= count_left - 1;
        columns_left <= columns_left - 1;
        if line_end = '1' then
          below <= below + row_step;
          columns_left <= columns;
          rows_left <= rows_left - 1;
        end if;
        -- No address beyond the screen, not even when nothing is read any more.
        if last_1 = '0' then
          address <= address + 1;
          if line_end = '1' then
            address <= below;
          end if;
        end if;
      end if;
      if advance = '1' then
        valids <= running & valids(2 to read_stages);
        lasts <= last_1 & lasts(2 to read_stages);
      end if;
      if reset = '1' then
        starting <= '0';
        running <= '0';
        valids <= (others => '0');
        refused_reg <= '0';
      end if;
    end if;
  end process;

  refused <= refused_reg;
  read_enable <= advance;
  read_address <= address;
  emitted <= read_last & std_ulogic_vector(read_value);
  summed <= read_valid and advance;

  crc_gen : if with_crc = 1 generate
    crc_inst : entity work.crc32
      generic map (num_bytes => num_channels)
      port map (
        clk => clk, clear => accept, byte_valid => summed, byte_data => std_ulogic_vector(read_value),
        busy => open,
        crc => crc
      );
  end generate;

  no_crc_gen : if with_crc = 0 generate
    crc <= (others => '0');
  end generate;

  output_inst : entity work.skid_buffer
    generic map (data_bits => 8 * num_channels + 1)
    port map (
      clk => clk, reset => reset,
      input_valid => read_valid, input_ready => advance, input_data => emitted,
      output_valid => shown_valid, output_ready => pixel_ready, output_data => shown
    );

  pixel_valid <= shown_valid;
  pixel_last <= shown(8 * num_channels);
  pixel_value <= unsigned(shown(8 * num_channels - 1 downto 0));

end architecture;
