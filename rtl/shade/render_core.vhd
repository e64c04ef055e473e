-- SPDX-License-Identifier: Apache-2.0
--
-- The rasteriser core, and where it is built the shade unit behind it: raster_core -> shade.
-- With with_shade = 0 it is raster_core and nothing more; state words are then taken and forgotten.
--
-- Model: render_core.py.  Test: test_render_core.py.
-- Latency: that of raster_core, and with shade shade_stages + 1 cycles more.  One pixel per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;

entity render_core is
  generic (
    num_channels : positive := default_formats.num_channels;
    max_order : natural := default_formats.max_order;
    with_depth : natural := default_formats.with_depth;
    word_width : positive := default_formats.word_width;
    frac_bits : natural := default_formats.frac_bits;
    value_bits : positive := default_formats.value_bits;
    depth_bits : positive := default_formats.depth_bits;
    subpixel_bits : natural := default_formats.subpixel_bits;
    coord_bits : positive := default_formats.coord_bits;
    stream_width : positive := default_formats.stream_width;
    span_depth : positive := default_formats.span_depth;
    with_shade : natural := default_formats.with_shade;
    num_specular : positive := default_formats.num_specular;
    shade_guard_bits : positive := default_formats.shade_guard_bits;
    -- See raster_core.
    single_buffer : natural := 0;
    with_last : natural := 0
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    setup_valid : in std_ulogic;
    setup_ready : out std_ulogic;
    setup_data : in std_ulogic_vector(stream_width - 1 downto 0);
    setup_last : in std_ulogic := '0';
    setup_cut : out std_ulogic;

    -- The shade unit's registers and tables: taken only while the core is idle.
    state_valid : in std_ulogic;
    state_ready : out std_ulogic;
    state_address : in u_unsigned(31 downto 0);
    state_data : in std_ulogic_vector(31 downto 0);

    pixel_valid : out std_ulogic;
    pixel_ready : in std_ulogic;
    -- The last pixel of a primitive.
    pixel_last : out std_ulogic;
    pixel_x : out u_unsigned(coord_bits - 1 downto 0);
    pixel_y : out u_unsigned(coord_bits - 1 downto 0);
    -- emitted_channels, channel 0 or red lowest.
    pixel_value : out
      u_unsigned((num_channels * (1 - with_shade) + shaded_colours * with_shade) * value_bits - 1 downto 0);
    -- Zero where the core is built without depth.
    pixel_depth : out u_unsigned(depth_bits - 1 downto 0);

    -- No packet begun, no scanline, span or pixel on its way.
    idle : out std_ulogic
  );
end entity;

architecture rtl of render_core is

  constant formats : formats_t := (
    num_channels => num_channels, max_order => max_order, with_depth => with_depth,
    word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
    subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
    span_depth => span_depth, with_shade => with_shade, num_specular => num_specular,
    shade_guard_bits => shade_guard_bits
  );
  constant formats_ok : boolean := check_formats(formats);
  constant lane_width : positive := lane_value_bits(formats);
  constant along_bits : positive := depth_bits + 2 * coord_bits + 1;

  signal drawn_valid, drawn_ready, drawn_last, drawn_idle : std_ulogic;
  signal drawn_x, drawn_y : u_unsigned(coord_bits - 1 downto 0);
  signal drawn_value : u_unsigned(num_channels * lane_width - 1 downto 0);
  signal drawn_depth : u_unsigned(depth_bits - 1 downto 0);

begin

  assert formats_ok
    report "render_core: generics out of range"
    severity failure;

  core_inst : entity work.raster_core
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, frac_bits => lane_frac_bits(formats), value_bits => lane_width,
      depth_bits => depth_bits, subpixel_bits => subpixel_bits, coord_bits => coord_bits,
      stream_width => stream_width, span_depth => span_depth, single_buffer => single_buffer,
      with_last => with_last
    )
    port map (
      clk => clk, reset => reset,
      setup_valid => setup_valid, setup_ready => setup_ready, setup_data => setup_data,
      setup_last => setup_last, setup_cut => setup_cut,
      pixel_valid => drawn_valid, pixel_ready => drawn_ready, pixel_last => drawn_last,
      pixel_x => drawn_x, pixel_y => drawn_y, pixel_value => drawn_value, pixel_depth => drawn_depth,
      idle => drawn_idle
    );

  plain_gen : if with_shade = 0 generate
    drawn_ready <= pixel_ready;
    pixel_valid <= drawn_valid;
    pixel_last <= drawn_last;
    pixel_x <= drawn_x;
    pixel_y <= drawn_y;
    pixel_value <= drawn_value;
    pixel_depth <= drawn_depth;
    state_ready <= '1';
    idle <= drawn_idle;
  end generate;

  shade_gen : if with_shade = 1 generate
    signal along, shaded_along : std_ulogic_vector(along_bits - 1 downto 0);
    signal state_offered, state_wanted, shading : std_ulogic;
  begin

    along <= drawn_last & std_ulogic_vector(drawn_y & drawn_x & drawn_depth);
    -- A word that came amid a drawing would change the colour of some of its pixels.
    state_offered <= state_valid and drawn_idle;
    state_ready <= state_wanted and drawn_idle;

    shade_inst : entity work.shade
      generic map (
        num_channels => num_channels, num_specular => num_specular, value_bits => value_bits,
        shade_guard_bits => shade_guard_bits, along_bits => along_bits
      )
      port map (
        clk => clk, reset => reset,
        state_valid => state_offered, state_ready => state_wanted, state_address => state_address,
        state_data => state_data,
        pixel_valid => drawn_valid, pixel_ready => drawn_ready, pixel_value => drawn_value,
        pixel_along => along,
        shaded_valid => pixel_valid, shaded_ready => pixel_ready, shaded_value => pixel_value,
        shaded_along => shaded_along, busy => shading
      );

    pixel_depth <= unsigned(shaded_along(depth_bits - 1 downto 0));
    pixel_x <= unsigned(shaded_along(depth_bits + coord_bits - 1 downto depth_bits));
    pixel_y <= unsigned(shaded_along(depth_bits + 2 * coord_bits - 1 downto depth_bits + coord_bits));
    pixel_last <= shaded_along(along_bits - 1);
    idle <= drawn_idle and not shading;

  end generate;

end architecture;
