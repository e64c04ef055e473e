-- SPDX-License-Identifier: Apache-2.0
--
-- A screen whose two pictures and z-buffer are in an SDRAM: one picture is drawn and read while the other is
-- shown, until a swap. Colours are kept in fewer bits, dithered, as a pixel has one word; planes 0 and 1 can
-- be read. The monitor's scanlines go before everything else that asks the memory. A reset fills both
-- pictures with black.
--
-- Model: sdram_screen.py.  Test: test_sdram_screen.py.
-- Latency: that of a run from a request to its first byte.  A pixel as sdram_depth_test takes it, a cycle
-- later; a word of what is read in three cycles.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;
use work.memory_pkg.all;
use work.screen_pkg.all;

entity sdram_screen is
  generic (
    -- A multiple of run_words.
    width : positive := 640;
    height : positive := 480;
    coord_bits : positive := 12;
    -- A channel is a byte, of which the memory keeps colour_bits: see screen_pkg.
    num_channels : positive := 3;
    colour_bits : positive := 5;
    depth_bits : positive := 15;
    -- 1: what scan_out makes of the picture, for a monitor.
    with_video : natural := 1;
    clocks_per_pixel : positive := 4;
    -- Of crc32.
    crc_cycles : positive := 1;
    -- Of sdram_controller.
    row_bits : positive := 13;
    column_bits : positive := 9;
    run_words : positive := 64;
    refresh_clocks : positive := 780;
    power_up_refreshes : positive := 26
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    -- Ends what is read.
    read_reset : in std_ulogic;
    -- No pixel is on its way, nothing is filled or read.
    idle : out std_ulogic;

    clear_valid : in std_ulogic;
    clear_ready : out std_ulogic;
    clear_colour : in std_ulogic_vector(31 downto 0);

    -- Taken in the monitor's vertical blank, without a monitor as soon as it is idle.
    swap_valid : in std_ulogic;
    swap_ready : out std_ulogic;

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    pixel_x : in u_unsigned(coord_bits - 1 downto 0);
    pixel_y : in u_unsigned(coord_bits - 1 downto 0);
    pixel_value : in u_unsigned(8 * num_channels - 1 downto 0);
    pixel_depth : in u_unsigned(depth_bits - 1 downto 0);

    -- Of plane_requests.
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
    video_words : out std_ulogic_vector(29 downto 0);

    -- Of sdram_controller.
    sdram_ras_n : out std_ulogic;
    sdram_cas_n : out std_ulogic;
    sdram_we_n : out std_ulogic;
    sdram_mask : out std_ulogic;
    sdram_bank : out u_unsigned(1 downto 0);
    sdram_address : out u_unsigned(row_bits - 1 downto 0);
    sdram_drive : out std_ulogic;
    sdram_data_out : out std_ulogic_vector(15 downto 0);
    sdram_data_in : in std_ulogic_vector(15 downto 0)
  );
end entity;

architecture rtl of sdram_screen is

  constant data_bits : positive := 16;
  constant value_bits : positive := 8 * num_channels;
  constant word_bits : positive := kept_bits(value_bits, colour_bits);
  constant depth_bytes : positive := (depth_bits + 7) / 8;
  -- For a clear, which is one colour.
  constant half_step : u_unsigned(3 downto 0) := "1000";
  -- An address of the units here is shorter than the chip's.
  constant place_bits : positive := 2 + address_bits(height) + address_bits(width);
  constant chip_bits : positive := row_bits + 2 + column_bits;

  subtype place_t is u_unsigned(place_bits - 1 downto 0);
  subtype more_t is u_unsigned(address_bits(run_words) - 1 downto 0);

  signal free, quiet, held, blank : std_ulogic;
  -- The picture that is drawn; after a reset 1 is filled, and then 0.
  signal drawn : std_ulogic := '1';
  signal filled : std_ulogic := '0';

  -- A pixel as it is kept: its place, its value, its depth.
  constant pixel_bits : positive := 2 * coord_bits + word_bits + depth_bits;
  signal pixel_given, pixel_room, pixel_waits, pixel_taken : std_ulogic;
  signal pixel_in, pixel_out : std_ulogic_vector(pixel_bits - 1 downto 0);
  signal depth_idle, empties : std_ulogic;
  signal empty_value, kept_value : u_unsigned(word_bits - 1 downto 0);
  signal depth_valid, depth_ready, depth_write, depth_read : std_ulogic;
  signal depth_place : place_t;
  signal depth_more : more_t;

  signal reads_idle, area_start, area_stop, word_valid, word_ready : std_ulogic;
  signal area_x, area_y : u_unsigned(coord_bits - 1 downto 0);
  signal area_width : u_unsigned(coord_bits downto 0);
  signal area_plane, memory_plane : u_unsigned(1 downto 0);
  signal area_valid, area_ready, area_read : std_ulogic;
  signal area_place : place_t;
  signal area_more : more_t;
  signal word : std_ulogic_vector(data_bits - 1 downto 0);
  signal pixel_data : u_unsigned(8 * (num_channels + depth_bytes) - 1 downto 0);

  signal line_valid, line_ready, line_read : std_ulogic;
  signal line_place : place_t;
  signal line_more : more_t;

  signal second_valid, second_ready, second_write, second_read : std_ulogic;
  signal second_place : place_t;
  signal second_more : more_t;
  signal line_address, second_address : u_unsigned(chip_bits - 1 downto 0);
  signal write_next, write_keep : std_ulogic;
  signal write_data, read_word : std_ulogic_vector(data_bits - 1 downto 0);

begin

  assert word_bits <= data_bits
    report "sdram_screen: colour_bits is " & integer'image(colour_bits) & ", a pixel has "
      & integer'image(word_bits) & " bits, must be at most " & integer'image(data_bits)
    severity failure;
  assert place_bits <= chip_bits
    report "sdram_screen: three planes of " & integer'image(width) & " by " & integer'image(height)
      & " need addresses of " & integer'image(place_bits) & " bits, the chip's have "
      & integer'image(chip_bits)
    severity failure;

  free <= depth_idle and not pixel_waits and filled and reads_idle;
  idle <= quiet;
  clear_ready <= quiet;
  swap_ready <= quiet and blank;

  planes : process (clk)
  begin
    if rising_edge(clk) then
      if swap_valid = '1' and quiet = '1' and blank = '1' then
        drawn <= not drawn;
      end if;
      if filled = '0' and depth_idle = '1' then
        drawn <= '0';
        filled <= not drawn;
      end if;
      if reset = '1' then
        drawn <= '1';
        filled <= '0';
      end if;
    end if;
  end process;

  -- Both are taken as they come, for the z-buffer is idle then.
  empties <= (clear_valid and quiet) or (depth_idle and not filled and not drawn);
  empty_value <= dithered(u_unsigned(clear_colour(value_bits - 1 downto 0)), half_step, colour_bits)
    when filled = '1' and reset = '0' else (others => '0');
  kept_value <= dithered(pixel_value, threshold(pixel_x, pixel_y), colour_bits);
  pixel_given <= pixel_valid and filled and not held;
  pixel_ready <= pixel_room and filled and not held;
  pixel_in <= std_ulogic_vector(pixel_x & pixel_y & kept_value & pixel_depth);

  -- What the z-buffer compares decides on its ready: that goes no further within a cycle.
  pixels_inst : entity work.skid_buffer
    generic map (data_bits => pixel_bits)
    port map (
      clk => clk, reset => reset,
      input_valid => pixel_given, input_ready => pixel_room, input_data => pixel_in,
      output_valid => pixel_waits, output_ready => pixel_taken, output_data => pixel_out
    );

  depth_inst : entity work.sdram_depth_test
    generic map (
      width => width, height => height, coord_bits => coord_bits, value_bits => word_bits,
      depth_bits => depth_bits, data_bits => data_bits, run_words => run_words
    )
    port map (
      clk => clk, reset => reset, plane => drawn, idle => depth_idle,
      clear_valid => empties, clear_ready => open, clear_value => empty_value,
      pixel_valid => pixel_waits, pixel_ready => pixel_taken,
      pixel_x => unsigned(pixel_out(pixel_bits - 1 downto pixel_bits - coord_bits)),
      pixel_y => unsigned(pixel_out(pixel_bits - coord_bits - 1 downto word_bits + depth_bits)),
      pixel_value => unsigned(pixel_out(word_bits + depth_bits - 1 downto depth_bits)),
      pixel_depth => unsigned(pixel_out(depth_bits - 1 downto 0)),
      run_valid => depth_valid, run_ready => depth_ready, run_write => depth_write,
      run_address => depth_place, run_more => depth_more, read_valid => depth_read, read_data => read_word,
      write_next => write_next, write_keep => write_keep, write_data => write_data
    );

  requests_inst : entity work.plane_requests
    generic map (
      width => width, height => height, coord_bits => coord_bits, num_channels => num_channels,
      depth_bytes => depth_bytes, crc_cycles => crc_cycles
    )
    port map (
      clk => clk, reset => reset, read_reset => read_reset, free => free, quiet => quiet, held => held,
      resting => open,
      read_valid => read_valid, read_ready => read_ready, read_x => read_x, read_y => read_y,
      read_width => read_width, read_count => read_count, read_plane => read_plane,
      read_data_valid => read_data_valid, read_data_ready => read_data_ready, read_data => read_data,
      frame_crc_valid => frame_crc_valid, frame_crc_ready => frame_crc_ready,
      frame_crc_plane => frame_crc_plane, frame_crc_done => frame_crc_done,
      frame_crc_value => frame_crc_value,
      area_start => area_start, area_stop => area_stop, area_x => area_x, area_y => area_y,
      area_width => area_width, area_plane => area_plane,
      pixel_valid => word_valid, pixel_ready => word_ready, pixel_data => pixel_data,
      pixel_edges => (others => '0')
    );

  memory_plane <= "10" when area_plane(0) = '1' else '0' & drawn;
  -- A place without a depth has a word of ones: the farthest.
  pixel_data <= resize(unsigned(word(depth_bits - 1 downto 0)), 8 * depth_bytes)
    & expanded(unsigned(word(word_bits - 1 downto 0)), value_bits, colour_bits);

  area_inst : entity work.sdram_read_out
    generic map (
      width => width, height => height, coord_bits => coord_bits, data_bits => data_bits,
      run_words => run_words
    )
    port map (
      clk => clk, reset => reset, stop => area_stop, idle => reads_idle,
      area_valid => area_start, area_x => area_x, area_y => area_y, area_width => area_width,
      area_plane => memory_plane,
      run_valid => area_valid, run_ready => area_ready, run_address => area_place, run_more => area_more,
      read_valid => area_read, read_data => read_word,
      word_valid => word_valid, word_ready => word_ready, word_data => word
    );

  -- What is read is read while the z-buffer is idle.
  second_valid <= depth_valid when reads_idle = '1' else area_valid;
  second_write <= depth_write and reads_idle;
  second_place <= depth_place when reads_idle = '1' else area_place;
  second_more <= depth_more when reads_idle = '1' else area_more;
  depth_ready <= second_ready and reads_idle;
  area_ready <= second_ready and not reads_idle;
  depth_read <= second_read and reads_idle;
  area_read <= second_read and not reads_idle;

  line_address <= resize(line_place, chip_bits);
  second_address <= resize(second_place, chip_bits);

  memory_inst : entity work.sdram_controller
    generic map (
      data_bits => data_bits, row_bits => row_bits, column_bits => column_bits, run_words => run_words,
      refresh_clocks => refresh_clocks, power_up_refreshes => power_up_refreshes
    )
    port map (
      clk => clk, reset => reset,
      first_valid => line_valid, first_ready => line_ready, first_address => line_address,
      first_more => line_more, first_data_valid => line_read,
      second_valid => second_valid, second_ready => second_ready, second_write => second_write,
      second_address => second_address, second_more => second_more,
      second_data_valid => second_read,
      write_next => write_next, write_keep => write_keep, write_data => write_data, read_data => read_word,
      sdram_ras_n => sdram_ras_n, sdram_cas_n => sdram_cas_n, sdram_we_n => sdram_we_n,
      sdram_mask => sdram_mask, sdram_bank => sdram_bank, sdram_address => sdram_address,
      sdram_drive => sdram_drive, sdram_data_out => sdram_data_out, sdram_data_in => sdram_data_in
    );

  video_gen : if with_video = 1 generate
    -- A scanline's runs, each behind another one and a refresh.
    constant line_clocks : positive := width / run_words * (run_words + 16) + run_words;
    signal line_start, line_first, shown : std_ulogic;
    signal line_value : u_unsigned(value_bits - 1 downto 0);
  begin
    assert line_clocks < 800 * clocks_per_pixel
      report "sdram_screen: a scanline may take " & integer'image(line_clocks)
        & " clocks to fetch, must be fewer than the monitor's " & integer'image(800 * clocks_per_pixel)
      severity failure;

    shown <= not drawn;

    lines_inst : entity work.sdram_line_fetch
      generic map (width => width, height => height, run_words => run_words)
      port map (
        clk => clk, reset => reset, line_start => line_start, line_first => line_first, plane => shown,
        run_valid => line_valid, run_ready => line_ready, run_address => line_place, run_more => line_more
      );

    line_value <= expanded(unsigned(read_word(word_bits - 1 downto 0)), value_bits, colour_bits);

    scan_inst : entity work.scan_out
      generic map (
        width => width, height => height, num_channels => num_channels, read_stages => 0,
        clocks_per_pixel => clocks_per_pixel
      )
      port map (
        clk => clk, reset => reset, may_read => line_read, blank => blank, reads => open,
        read_address => open, read_value => line_value, line_start => line_start, line_first => line_first,
        word_next => video_next, words => video_words
      );
  end generate;

  no_video_gen : if with_video = 0 generate
    blank <= '1';
    line_valid <= '0';
    line_place <= (others => '0');
    line_more <= (others => '0');
    video_next <= '0';
    video_words <= (others => '0');
  end generate;

end architecture;
