-- SPDX-License-Identifier: Apache-2.0
--
-- A board between two pins, without any vendor's cell: the serial line's commands, the core that draws, the
-- screen that keeps the picture, and the answers. synth/boards has a top for each real board.
--
-- Model: board.py.  Test: test_board.py.  Latency: that of its parts.
-- Throughput: the line's; a pixel per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
use work.link_pkg.all;

entity board is
  generic (
    num_channels : natural := default_formats.num_channels;
    max_order : natural := default_formats.max_order;
    with_depth : natural := default_formats.with_depth;
    word_width : natural := default_formats.word_width;
    frac_bits : natural := default_formats.frac_bits;
    value_bits : natural := default_formats.value_bits;
    depth_bits : natural := default_formats.depth_bits;
    subpixel_bits : natural := default_formats.subpixel_bits;
    coord_bits : natural := default_formats.coord_bits;
    stream_width : natural := default_formats.stream_width;
    span_depth : natural := default_formats.span_depth;
    with_shade : natural := default_formats.with_shade;
    num_specular : natural := default_formats.num_specular;
    shade_guard_bits : natural := default_formats.shade_guard_bits;
    clk_frequency_hz : positive := 100_000_000;
    -- After power-up and after a break.
    baud : positive := 1_000_000;
    fifo_words : positive := 1024;
    screen_width : positive := 320;
    screen_height : positive := 240;
    with_edge_map : natural := 0;
    -- A framebuffer of single-port memory, with painter's order: see single_port_ram.
    single_port_memory : natural := 0;
    -- 1: what scan_out makes of the picture, for a monitor of 640 x 480: 25 million pixels a second.
    with_video : natural := 0;
    clocks_per_pixel : positive := 4;
    -- 2: one buffer is shown while the other is drawn, until SWAP.
    buffers : positive := 1;
    -- Bits that the picture keeps of a colour: 8, or dithered 6 (of channel 1 five), 5 (six) or 4.
    colour_bits : positive := 8;
    -- pixel_packer, so that reading takes fewer bytes on the line.
    with_packed_read : natural := 1;
    -- Words of a block of the device's memory, a bit wide: see block_ram.
    bank_words : positive := 16384;
    -- vertex_unpacker, so that triangles take fewer bytes on the line.
    with_vertices : natural := 0;
    -- 1: sdram_screen, two buffers in the chip at the pins; its organisation, and clocks between refreshes.
    with_sdram : natural := 0;
    sdram_row_bits : positive := 13;
    sdram_column_bits : positive := 9;
    sdram_refresh_clocks : positive := 780;
    -- For small devices: STATUS counts in fewer bits; the core has no room for the next packet's words, and
    -- the FIFO no registers before its block; a byte of a CRC takes that many cycles, at most as many as a
    -- character of the line.
    most_counter_bits : positive := 32;
    single_buffer : natural := 0;
    crc_cycles : positive := 1
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    rx : in std_ulogic;
    tx : out std_ulogic;
    -- In the last sixteenth of a second: 0 a good frame came, 1 something was drawn, 2 a frame was damaged or
    -- refused, 3 something was sent.
    led : out std_ulogic_vector(7 downto 0);
    -- Of scan_out.
    video_next : out std_ulogic;
    video_words : out std_ulogic_vector(29 downto 0);
    -- Of sdram_controller: RAS, CAS and WE.
    sdram_command : out std_ulogic_vector(2 downto 0);
    sdram_mask : out std_ulogic;
    sdram_bank : out u_unsigned(1 downto 0);
    sdram_address : out u_unsigned(sdram_row_bits - 1 downto 0);
    sdram_drive : out std_ulogic;
    sdram_data_out : out std_ulogic_vector(15 downto 0);
    sdram_data_in : in std_ulogic_vector(15 downto 0) := (others => '0')
  );
end entity;

architecture rtl of board is

  constant formats : formats_t := (
    num_channels, max_order, with_depth, word_width, frac_bits, value_bits, depth_bits, subpixel_bits,
    coord_bits, stream_width, span_depth, with_shade, num_specular, shade_guard_bits
  );
  constant colours : positive := emitted_channels(formats);
  constant depth_bytes : natural := with_depth * ((depth_bits + 7) / 8);
  constant features : natural :=
    with_depth * feature_depth_test + with_shade * feature_shade + with_edge_map * feature_edge_map
    + with_video * feature_display + (buffers - 1) * feature_two_buffers
    + boolean'pos(colour_bits = 6) * feature_colours_656 + boolean'pos(colour_bits = 4) * feature_colours_444
    + boolean'pos(colour_bits = 5) * feature_colours_565
    + with_packed_read * feature_packed_read + with_vertices * feature_vertices
    + single_buffer * feature_single_buffer;

  constant num_lights : positive := 4;
  constant tick_cycles : positive := clk_frequency_hz / 16 + 1;

  signal line_valid, line_error, break_seen, send_valid, send_ready, send_busy : std_ulogic;
  signal line_data, send_data : std_ulogic_vector(7 downto 0);
  signal phase_step : u_unsigned(phase_bits - 1 downto 0);

  signal link_reset : std_ulogic;
  signal core_reset, everything_idle : std_ulogic := '0';
  signal word_valid, word_ready, packed_valid, packed_ready, unpacked_valid, unpacked_ready : std_ulogic;
  signal unpacking, placing, setup_valid, setup_ready, core_done : std_ulogic;
  signal word_data, packed_data, unpacked_data, setup_data : std_ulogic_vector(31 downto 0);

  signal drawn_valid, drawn_ready, drawn_last, drawing_done, pixel_done, primitive_done : std_ulogic;
  signal drawn_x, drawn_y : u_unsigned(coord_bits - 1 downto 0);
  signal drawn_value : u_unsigned(8 * colours - 1 downto 0);
  signal drawn_depth : u_unsigned(depth_bits - 1 downto 0);

  signal state_valid, state_ready : std_ulogic;
  signal state_address : u_unsigned(31 downto 0);
  signal state_data : std_ulogic_vector(31 downto 0);

  signal screen_idle, clear_valid, clear_ready, swap_valid, swap_ready, read_valid, read_ready : std_ulogic;
  signal clear_colour : std_ulogic_vector(31 downto 0);
  signal read_x, read_y, read_width, read_count : u_unsigned(15 downto 0);
  signal read_plane, crc_plane : u_unsigned(1 downto 0);
  signal read_packed, answer_valid, answer_ready, area_valid, area_ready : std_ulogic;
  signal read_bytes : u_unsigned(9 downto 0);
  signal answer_data : std_ulogic_vector(7 downto 0);
  signal bytes_valid, bytes_ready, crc_valid, crc_ready, crc_done : std_ulogic;
  signal bytes_data : std_ulogic_vector(7 downto 0);
  signal crc_value : std_ulogic_vector(31 downto 0);

  signal frame_seen, fault_seen : std_ulogic;
  signal events, seen, lights : std_ulogic_vector(num_lights - 1 downto 0) := (others => '0');
  signal ticks : natural range 0 to tick_cycles - 1 := 0;

begin

  assert value_bits = 8
    report "board: value_bits is " & integer'image(value_bits) & ", must be 8: a channel is a byte"
    severity failure;
  assert stream_width = 32
    report "board: stream_width is " & integer'image(stream_width) & ", the line gives 32 bits at a time"
    severity failure;
  assert baud <= clk_frequency_hz / 4 and clk_frequency_hz < 2**30
    report "board: " & integer'image(baud) & " baud at " & integer'image(clk_frequency_hz)
      & " Hz, must be at least four clocks a bit, and less than 2**30 Hz"
    severity failure;

  receiver : entity work.uart_rx
    port map (
      clk => clk, reset => reset, phase_step => phase_step, rx => rx,
      byte_valid => line_valid, byte_data => line_data, framing_error => line_error, break_seen => break_seen
    );

  transmitter : entity work.uart_tx
    port map (
      clk => clk, reset => reset, phase_step => phase_step,
      byte_valid => send_valid, byte_ready => send_ready, byte_data => send_data, busy => send_busy, tx => tx
    );

  decoder : entity work.command_decoder
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
      subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
      span_depth => span_depth, with_shade => with_shade, num_specular => num_specular,
      shade_guard_bits => shade_guard_bits,
      clk_frequency_hz => clk_frequency_hz, default_phase_step => phase_step_of(baud, clk_frequency_hz),
      fifo_words => fifo_words, features => features,
      screen_width => screen_width, screen_height => screen_height, colour_bytes => colours,
      depth_bytes => depth_bytes, most_counter_bits => most_counter_bits,
      crc_cycles => crc_cycles, fifo_stages => 4 - 2 * single_buffer
    )
    port map (
      clk => clk, reset => reset,
      line_valid => line_valid, line_data => line_data, line_error => line_error, break_seen => break_seen,
      send_valid => send_valid, send_ready => send_ready, send_data => send_data, send_busy => send_busy,
      phase_step => phase_step,
      core_reset => link_reset, core_idle => everything_idle,
      pixel_done => pixel_done, primitive_done => primitive_done,
      frame_seen => frame_seen, fault_seen => fault_seen,
      setup_valid => word_valid, setup_ready => word_ready, setup_data => word_data,
      state_valid => state_valid, state_ready => state_ready, state_address => state_address,
      state_data => state_data,
      clear_valid => clear_valid, clear_ready => clear_ready, clear_colour => clear_colour,
      swap_valid => swap_valid, swap_ready => swap_ready,
      read_valid => read_valid, read_ready => read_ready, read_x => read_x, read_y => read_y,
      read_width => read_width, read_count => read_count, read_pixels => open, read_plane => read_plane,
      read_packed => read_packed, read_bytes => read_bytes,
      read_data_valid => answer_valid, read_data_ready => answer_ready, read_data => answer_data,
      frame_crc_valid => crc_valid, frame_crc_ready => crc_ready, frame_crc_plane => crc_plane,
      frame_crc_done => crc_done, frame_crc_value => crc_value
    );

  drawing_done <= core_done and not unpacking and not placing;

  -- Registers, for the units are far apart. A command comes later than that after the one before it, and the
  -- link, which is reset a clock earlier, gives nothing then.
  settled : process (clk)
  begin
    if rising_edge(clk) then
      everything_idle <= drawing_done and screen_idle;
      core_reset <= reset or link_reset;
    end if;
  end process;

  unpacker : entity work.word_unpacker
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, subpixel_bits => subpixel_bits, coord_bits => coord_bits,
      stream_width => stream_width, with_shade => with_shade, num_specular => num_specular
    )
    port map (
      clk => clk, reset => core_reset,
      packed_valid => packed_valid, packed_ready => packed_ready, packed_data => packed_data,
      setup_valid => unpacked_valid, setup_ready => unpacked_ready, setup_data => unpacked_data,
      busy => unpacking
    );

  vertices_gen : if with_vertices = 1 generate
    vertices : entity work.vertex_unpacker
      generic map (
        num_channels => num_channels, max_order => max_order, with_depth => with_depth,
        word_width => word_width, frac_bits => frac_bits, depth_bits => depth_bits,
        subpixel_bits => subpixel_bits, coord_bits => coord_bits
      )
      port map (
        clk => clk, reset => core_reset,
        line_valid => word_valid, line_ready => word_ready, line_data => word_data,
        packed_valid => packed_valid, packed_ready => packed_ready, packed_data => packed_data,
        unpacking => unpacking, unpacked_valid => unpacked_valid, unpacked_ready => unpacked_ready,
        unpacked_data => unpacked_data,
        setup_valid => setup_valid, setup_ready => setup_ready, setup_data => setup_data, busy => placing
      );
  end generate;

  words_gen : if with_vertices = 0 generate
    packed_valid <= word_valid;
    word_ready <= packed_ready;
    packed_data <= word_data;
    setup_valid <= unpacked_valid;
    unpacked_ready <= setup_ready;
    setup_data <= unpacked_data;
    placing <= '0';
  end generate;

  core : entity work.render_core
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
      subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
      span_depth => span_depth, with_shade => with_shade, num_specular => num_specular,
      shade_guard_bits => shade_guard_bits, single_buffer => single_buffer
    )
    port map (
      clk => clk, reset => core_reset,
      setup_valid => setup_valid, setup_ready => setup_ready, setup_data => setup_data,
      state_valid => state_valid, state_ready => state_ready, state_address => state_address,
      state_data => state_data,
      pixel_valid => drawn_valid, pixel_ready => drawn_ready, pixel_last => drawn_last,
      pixel_x => drawn_x, pixel_y => drawn_y, pixel_value => drawn_value, pixel_depth => drawn_depth,
      idle => core_done
    );

  -- What the core still gives in the clock of its reset is counted by nobody.
  pixel_done <= drawn_valid and drawn_ready and not core_reset;
  primitive_done <= pixel_done and drawn_last;

  block_gen : if with_sdram = 0 generate
    picture : entity work.screen
      generic map (
        width => screen_width, height => screen_height, coord_bits => coord_bits, num_channels => colours,
        with_depth => with_depth, depth_bits => depth_bits, with_edge_map => with_edge_map,
        single_port_memory => single_port_memory, with_video => with_video, buffers => buffers,
        colour_bits => colour_bits, crc_cycles => crc_cycles, clocks_per_pixel => clocks_per_pixel,
        bank_words => bank_words
      )
      port map (
        clk => clk, reset => reset, read_reset => link_reset, idle => screen_idle,
        clear_valid => clear_valid, clear_ready => clear_ready, clear_colour => clear_colour,
        swap_valid => swap_valid, swap_ready => swap_ready,
        pixel_valid => drawn_valid, pixel_ready => drawn_ready, pixel_x => drawn_x, pixel_y => drawn_y,
        pixel_value => drawn_value, pixel_depth => drawn_depth,
        read_valid => area_valid, read_ready => area_ready, read_x => read_x, read_y => read_y,
        read_width => read_width, read_count => read_count, read_plane => read_plane,
        read_data_valid => bytes_valid, read_data_ready => bytes_ready, read_data => bytes_data,
        frame_crc_valid => crc_valid, frame_crc_ready => crc_ready, frame_crc_plane => crc_plane,
        frame_crc_done => crc_done, frame_crc_value => crc_value,
        video_next => video_next, video_words => video_words
      );
    sdram_command <= (others => '1');
    sdram_mask <= '1';
    sdram_drive <= '0';
    sdram_bank <= (others => '0');
    sdram_address <= (others => '0');
    sdram_data_out <= (others => '0');
  end generate;

  sdram_gen : if with_sdram = 1 generate
    assert buffers = 2 and with_depth = 1 and with_edge_map = 0
      report "board: a screen in SDRAM has two buffers, depth and no edge map"
      severity failure;

    picture : entity work.sdram_screen
      generic map (
        width => screen_width, height => screen_height, coord_bits => coord_bits, num_channels => colours,
        colour_bits => colour_bits, depth_bits => depth_bits, with_video => with_video,
        clocks_per_pixel => clocks_per_pixel, crc_cycles => crc_cycles, row_bits => sdram_row_bits,
        column_bits => sdram_column_bits, refresh_clocks => sdram_refresh_clocks
      )
      port map (
        clk => clk, reset => reset, read_reset => link_reset, idle => screen_idle,
        clear_valid => clear_valid, clear_ready => clear_ready, clear_colour => clear_colour,
        swap_valid => swap_valid, swap_ready => swap_ready,
        pixel_valid => drawn_valid, pixel_ready => drawn_ready, pixel_x => drawn_x, pixel_y => drawn_y,
        pixel_value => drawn_value, pixel_depth => drawn_depth,
        read_valid => area_valid, read_ready => area_ready, read_x => read_x, read_y => read_y,
        read_width => read_width, read_count => read_count, read_plane => read_plane,
        read_data_valid => bytes_valid, read_data_ready => bytes_ready, read_data => bytes_data,
        frame_crc_valid => crc_valid, frame_crc_ready => crc_ready, frame_crc_plane => crc_plane,
        frame_crc_done => crc_done, frame_crc_value => crc_value,
        video_next => video_next, video_words => video_words,
        sdram_ras_n => sdram_command(2), sdram_cas_n => sdram_command(1), sdram_we_n => sdram_command(0),
        sdram_mask => sdram_mask, sdram_bank => sdram_bank, sdram_address => sdram_address,
        sdram_drive => sdram_drive, sdram_data_out => sdram_data_out, sdram_data_in => sdram_data_in
      );
  end generate;

  packed_gen : if with_packed_read = 1 generate
    signal asked_valid, asked_ready, byte_valid, byte_ready : std_ulogic;
    signal byte_data : std_ulogic_vector(7 downto 0);
  begin
    -- The answer's ready would go on through the reader and the edge map, over the whole die.
    buffer_inst : entity work.skid_buffer
      generic map (data_bits => 8)
      port map (
        clk => clk, reset => core_reset,
        input_valid => bytes_valid, input_ready => bytes_ready, input_data => bytes_data,
        output_valid => byte_valid, output_ready => byte_ready, output_data => byte_data
      );

    -- The screen is done with an area before its last byte is taken: the next one waits for that.
    area_valid <= asked_valid and not byte_valid;
    asked_ready <= area_ready and not byte_valid;

    packer : entity work.pixel_packer
      generic map (value_bytes => colours, depth_bytes => depth_bytes)
      port map (
        clk => clk, reset => core_reset,
        read_valid => read_valid, read_ready => read_ready, read_packed => read_packed,
        read_count => read_count, read_plane => read_plane, answer_bytes => read_bytes,
        data_valid => answer_valid, data_ready => answer_ready, data => answer_data,
        area_valid => asked_valid, area_ready => asked_ready,
        byte_valid => byte_valid, byte_ready => byte_ready, byte_data => byte_data
      );
  end generate;

  raw_gen : if with_packed_read = 0 generate
    area_valid <= read_valid;
    read_ready <= area_ready;
    read_bytes <= read_count(9 downto 0);
    answer_valid <= bytes_valid;
    bytes_ready <= answer_ready;
    answer_data <= bytes_data;
  end generate;

  -- Lights: what happened since the last tick but one.
  events <= (send_busy, fault_seen, not core_done, frame_seen);

  show : process (clk)
  begin
    if rising_edge(clk) then
      seen <= seen or events;
      if ticks /= tick_cycles - 1 then
        ticks <= ticks + 1;
      else
        ticks <= 0;
        lights <= seen;
        seen <= events;
      end if;
      if reset = '1' then
        ticks <= 0;
        seen <= (others => '0');
        lights <= (others => '0');
      end if;
    end if;
  end process;

  led <= std_ulogic_vector(resize(unsigned(lights), 8));

end architecture;
