-- SPDX-License-Identifier: Apache-2.0
--
-- The picture and what can be read of it: pixels through the z-buffer into the framebuffer, areas of a plane
-- as bytes, the CRC-32 of whole planes. Planes: 0 value, 1 depth, 2 and 3 edges by both variants. Pixels and
-- clears wait while something is read, so one port of each memory is enough, and what is read stands still.
-- For edges the whole frame passes edge_map: width * (height + 1) cycles, where a line needs a million.
--
-- Model: screen.py.  Test: test_screen.py.
-- Latency: 15 cycles from a request to its first byte, a frame for edges.  One pixel or one byte per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;
use work.memory_pkg.all;

entity screen is
  generic (
    width : positive := 320;
    height : positive := 240;
    coord_bits : positive := 12;
    -- A channel is a byte.
    num_channels : positive := 3;
    with_depth : natural := 1;
    depth_bits : positive := 16;
    with_edge_map : natural := 0;
    single_port_memory : natural := 0;
    -- 1: what scan_out makes of the picture, for a monitor.
    with_video : natural := 0;
    clocks_per_pixel : positive := 4;
    -- Of framebuffer; with two buffers what is read is that which is drawn, beside the monitor.
    buffers : positive := 1;
    colour_bits : positive := 8;
    -- Of crc32.
    crc_cycles : positive := 1;
    -- Of block_ram.
    bank_words : positive := 16384
  );
  port (
    clk : in std_ulogic;
    -- Starts a clear.
    reset : in std_ulogic;
    -- Ends what is read.
    read_reset : in std_ulogic;
    -- No pixel is on its way, nothing is cleared or read.
    idle : out std_ulogic;

    clear_valid : in std_ulogic;
    clear_ready : out std_ulogic;
    clear_colour : in std_ulogic_vector(31 downto 0);

    -- With two buffers: taken in the monitor's vertical blank, without a monitor as soon as it is idle.
    swap_valid : in std_ulogic := '0';
    swap_ready : out std_ulogic;

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    pixel_x : in u_unsigned(coord_bits - 1 downto 0);
    pixel_y : in u_unsigned(coord_bits - 1 downto 0);
    pixel_value : in u_unsigned(8 * num_channels - 1 downto 0);
    pixel_depth : in u_unsigned(depth_bits - 1 downto 0);

    -- An area of the screen; the bytes follow on read_data.
    read_valid : in std_ulogic;
    read_ready : out std_ulogic;
    read_x : in u_unsigned(15 downto 0);
    read_y : in u_unsigned(15 downto 0);
    read_width : in u_unsigned(15 downto 0);
    read_count : in u_unsigned(15 downto 0);
    read_plane : in u_unsigned(1 downto 0);
    read_data_valid : out std_ulogic;
    read_data_ready : in std_ulogic;
    read_data : out std_ulogic_vector(7 downto 0);

    frame_crc_valid : in std_ulogic;
    frame_crc_ready : out std_ulogic;
    frame_crc_plane : in u_unsigned(1 downto 0);
    frame_crc_done : out std_ulogic;
    frame_crc_value : out std_ulogic_vector(31 downto 0);

    -- Of scan_out.
    video_next : out std_ulogic;
    video_words : out std_ulogic_vector(29 downto 0)
  );
end entity;

architecture rtl of screen is

  constant num_pixels : positive := width * height;
  constant address_width : positive := address_bits(num_pixels);
  constant value_bits : positive := 8 * num_channels;
  constant depth_bytes : natural := with_depth * ((depth_bits + 7) / 8);
  constant data_bytes : positive := num_channels + depth_bytes;

  subtype coord_t is u_unsigned(coord_bits - 1 downto 0);

  signal kept_valid, kept_ready, depth_ready, depth_idle, framebuffer_idle : std_ulogic;
  signal kept_x, kept_y : coord_t;
  signal kept_value, stored_value : u_unsigned(value_bits - 1 downto 0);
  signal clear, clear_picture, free, quiet, held, blank, swap : std_ulogic;

  signal plane : u_unsigned(1 downto 0);
  -- The area, and what is read for it: for edges that is the whole frame.
  signal x, y, area_x, area_y : coord_t;
  signal columns, area_width : u_unsigned(coord_bits downto 0);
  signal starting, reader_reset : std_ulogic;

  signal memory_enable : std_ulogic;
  signal memory_address, area_address, scan_address : u_unsigned(address_width - 1 downto 0);
  signal resting, scan_free, scan_reads : std_ulogic;
  signal scan_value, shown_value : u_unsigned(value_bits - 1 downto 0);
  signal stored, area_data : u_unsigned(8 * data_bytes - 1 downto 0);
  signal area_valid, area_taken, chosen_valid, chosen_ready : std_ulogic;
  signal edges : u_unsigned(8 * edge_bytes - 1 downto 0);

begin

  assert num_channels <= 4
    report "screen: num_channels is " & integer'image(num_channels) & ", a clear has 4 bytes"
    severity failure;
  assert with_edge_map = 0 or (with_depth = 1 and num_channels = 3 and depth_bits >= 8)
    report "screen: an edge map needs three channels and a depth of at least 8 bits"
    severity failure;
  assert with_depth = 0 or single_port_memory = 0
    report "screen: a memory of one port has no z-buffer beside it"
    severity failure;
  assert with_video = 0 or single_port_memory = 0
    report "screen: a memory of one port cannot be read for a monitor while pixels are drawn"
    severity failure;

  free <= depth_idle and framebuffer_idle;
  idle <= quiet;
  clear_ready <= quiet;
  clear <= clear_valid and quiet;
  swap_ready <= quiet and blank;
  swap <= swap_valid and quiet and blank;

  depth_gen : if with_depth = 1 generate
    signal look_depth : u_unsigned(depth_bits - 1 downto 0);
  begin
    depth_inst : entity work.depth_test
      generic map (
        width => width, height => height, coord_bits => coord_bits, value_bits => value_bits,
        depth_bits => depth_bits, bank_words => bank_words
      )
      port map (
        clk => clk, reset => reset, clear => clear, busy => open, drained => clear_picture,
        pixel_valid => pixel_valid, pixel_ready => depth_ready, pixel_x => pixel_x, pixel_y => pixel_y,
        pixel_value => pixel_value, pixel_depth => pixel_depth,
        idle => depth_idle, look => held, look_enable => memory_enable, look_address => memory_address,
        look_depth => look_depth,
        kept_valid => kept_valid, kept_x => kept_x, kept_y => kept_y,
        kept_value => kept_value, kept_depth => open
      );
    -- A clear is over in the framebuffer before the first pixel behind it leaves the depth test: kept_ready
    -- is high for every kept pixel.
    pixel_ready <= depth_ready;
    stored <= resize(look_depth, 8 * depth_bytes) & stored_value;
  end generate;

  painter_gen : if with_depth = 0 generate
    kept_valid <= pixel_valid and not held;
    kept_x <= pixel_x;
    kept_y <= pixel_y;
    kept_value <= pixel_value;
    depth_ready <= '0';
    depth_idle <= '1';
    clear_picture <= clear;
    pixel_ready <= kept_ready and not held;
    stored <= stored_value;
  end generate;

  framebuffer_inst : entity work.framebuffer
    generic map (
      width => width, height => height, coord_bits => coord_bits, value_bits => value_bits,
      single_port => single_port_memory, buffers => buffers, colour_bits => colour_bits,
      bank_words => bank_words
    )
    port map (
      clk => clk, reset => reset, clear => clear_picture,
      clear_value => u_unsigned(clear_colour(value_bits - 1 downto 0)), busy => open,
      idle => framebuffer_idle, swap => swap,
      pixel_valid => kept_valid, pixel_ready => kept_ready, pixel_x => kept_x, pixel_y => kept_y,
      pixel_value => kept_value,
      read_enable => memory_enable, read_address => memory_address, read_value => stored_value,
      show_address => scan_address, show_value => shown_value
    );

  requests_inst : entity work.plane_requests
    generic map (
      width => width, height => height, coord_bits => coord_bits, num_channels => num_channels,
      depth_bytes => depth_bytes, crc_cycles => crc_cycles
    )
    port map (
      clk => clk, reset => reset, read_reset => read_reset, free => free, quiet => quiet, held => held,
      resting => resting,
      read_valid => read_valid, read_ready => read_ready, read_x => read_x, read_y => read_y,
      read_width => read_width, read_count => read_count, read_plane => read_plane,
      read_data_valid => read_data_valid, read_data_ready => read_data_ready, read_data => read_data,
      frame_crc_valid => frame_crc_valid, frame_crc_ready => frame_crc_ready,
      frame_crc_plane => frame_crc_plane, frame_crc_done => frame_crc_done,
      frame_crc_value => frame_crc_value,
      area_start => starting, area_stop => reader_reset, area_x => x, area_y => y, area_width => columns,
      area_plane => plane,
      pixel_valid => chosen_valid, pixel_ready => chosen_ready, pixel_data => area_data,
      pixel_edges => edges
    );

  area_x <= x when plane(1) = '0' else (others => '0');
  area_y <= y when plane(1) = '0' else (others => '0');
  area_width <= columns when plane(1) = '0' else to_unsigned(width, coord_bits + 1);

  area_inst : entity work.read_out
    generic map (
      width => width, height => height, coord_bits => coord_bits, num_channels => data_bytes, with_count => 0,
      with_crc => 0, read_stages => 5 - 3 * single_port_memory
    )
    port map (
      clk => clk, reset => reader_reset,
      area_valid => starting, area_ready => open, area_x => area_x, area_y => area_y,
      area_width => area_width, area_count => to_unsigned(num_pixels, address_width + 1), refused => open,
      read_enable => memory_enable, read_address => area_address, read_value => stored,
      pixel_valid => area_valid, pixel_ready => area_taken, pixel_last => open, pixel_value => area_data,
      crc => open
    );

  -- With two buffers the monitor has a port of its own.
  memory_address <= scan_address when scan_reads = '1' and buffers = 1 else area_address;
  scan_free <= resting when buffers = 1 else '1';
  scan_value <= stored_value when buffers = 1 else shown_value;

  video_gen : if with_video = 1 generate
    scan_inst : entity work.scan_out
      generic map (
        width => width, height => height, num_channels => num_channels, clocks_per_pixel => clocks_per_pixel
      )
      port map (
        clk => clk, reset => reset, may_read => scan_free, blank => blank, reads => scan_reads,
        read_address => scan_address, read_value => scan_value, word_next => video_next, words => video_words
      );
  end generate;

  no_video_gen : if with_video = 0 generate
    blank <= '1';
    scan_reads <= '0';
    scan_address <= (others => '0');
    video_next <= '0';
    video_words <= (others => '0');
  end generate;

  edges_gen : if with_edge_map = 1 generate
    -- The top bits of the depth.
    constant map_bits : positive := minimum(depth_bits, 16);
    signal map_ready, map_valid, edge_taken, edge_shown : std_ulogic;
    signal map_depth : u_unsigned(map_bits - 1 downto 0);
    signal map_normal, map_jump : u_unsigned(7 downto 0);
    signal pixel_into : std_ulogic;
    -- Where the edge behind this one is; this one is in the area.
    signal next_x, next_y : coord_t := (others => '0');
    signal edge_here : std_ulogic := '0';
  begin
    map_depth <= area_data(value_bits + depth_bits - 1 downto value_bits + depth_bits - map_bits);
    pixel_into <= area_valid and plane(1);

    map_inst : entity work.edge_map
      generic map (max_width => width, coord_bits => coord_bits, depth_bits => map_bits)
      port map (
        clk => clk, reset => reader_reset,
        frame_valid => starting, frame_ready => open,
        frame_width => to_unsigned(width, coord_bits + 1),
        frame_height => to_unsigned(height, coord_bits + 1), frame_variant => plane(0), refused => open,
        pixel_valid => pixel_into, pixel_ready => map_ready,
        pixel_normal => area_data(23 downto 0), pixel_depth => map_depth,
        edge_valid => map_valid, edge_ready => edge_taken, edge_last => open,
        edge_normal => map_normal, edge_depth => map_jump
      );

    -- Of the whole frame's edges those of the area are taken.
    walk : process (clk)
    begin
      if rising_edge(clk) then
        if map_valid = '1' and edge_taken = '1' then
          edge_here <= '0';
          if next_y >= y and next_x >= x and next_x < x + columns then
            edge_here <= '1';
          end if;
          next_x <= next_x + 1;
          if next_x = width - 1 then
            next_x <= (others => '0');
            next_y <= next_y + 1;
          end if;
        end if;
        -- A frame of edges has at least three columns.
        if starting = '1' then
          edge_here <= '0';
          if x = 0 and y = 0 then
            edge_here <= '1';
          end if;
          next_x <= to_unsigned(1, coord_bits);
          next_y <= (others => '0');
        end if;
      end if;
    end process;

    edge_shown <= map_valid and edge_here;
    edge_taken <= chosen_ready or not edge_here;
    edges <= map_jump & map_normal;
    area_taken <= map_ready when plane(1) = '1' else chosen_ready;
    chosen_valid <= edge_shown when plane(1) = '1' else area_valid;
  end generate;

  no_edges_gen : if with_edge_map = 0 generate
    area_taken <= chosen_ready;
    chosen_valid <= area_valid;
    edges <= (others => '0');
  end generate;

end architecture;
