-- SPDX-License-Identifier: Apache-2.0
--
-- The rasteriser core: AXI4-Stream of set-up words in, covered pixels with interpolated channels out.
--   setup_loader -> edge_walker -> span_chain -> span_walker -> skid_buffer, and in step with them
--   a channel_lane for each channel
--
-- Model: raster_core.py.  Test: test_raster_core.py.
-- Latency: span_depth + 11 cycles from a packet's last beat to its first pixel.
-- Throughput: one covered pixel per cycle while set-up words keep up; an empty scanline costs a cycle only
-- where no full span hides it.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;

entity raster_core is
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
    -- 1: a packet is taken when the one before has been walked: fewer registers, for slow set-up streams.
    single_buffer : natural := 0;
    -- 1: setup_last, the sender's last beat, drops a packet that is not whole there, and setup_cut says so.
    with_last : natural := 0
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    setup_valid : in std_ulogic;
    setup_ready : out std_ulogic;
    setup_data : in std_ulogic_vector(stream_width - 1 downto 0);
    setup_last : in std_ulogic := '0';
    -- For a cycle.
    setup_cut : out std_ulogic;

    pixel_valid : out std_ulogic;
    pixel_ready : in std_ulogic;
    -- The last pixel of a primitive.
    pixel_last : out std_ulogic;
    pixel_x : out u_unsigned(coord_bits - 1 downto 0);
    pixel_y : out u_unsigned(coord_bits - 1 downto 0);
    -- Channel 0 lowest.
    pixel_value : out u_unsigned(num_channels * value_bits - 1 downto 0);
    -- Zero where the core is built without depth.
    pixel_depth : out u_unsigned(depth_bits - 1 downto 0);

    -- No packet begun, no scanline, span or pixel on its way.
    idle : out std_ulogic
  );
end entity;

architecture rtl of raster_core is

  constant formats : formats_t := (
    num_channels => num_channels, max_order => max_order, with_depth => with_depth,
    word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
    subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
    span_depth => span_depth, with_shade => 0, num_specular => 1, shade_guard_bits => 0
  );
  constant formats_ok : boolean := check_formats(formats);
  constant layout : edge_layout_t := edge_layout(formats);
  constant second : second_layout_t := second_layout(formats);
  constant carried : positive := num_channels + with_depth;
  constant columns : positive := column_bits(formats);
  constant edges : positive := edge_bits(formats);

  -- A span in the chain but for its words: those are in the lanes.
  constant span_bits : positive := 2 * columns + coord_bits + 2;
  constant pixel_bits : positive := num_channels * value_bits + depth_bits + 2 * coord_bits + 1;

  signal packet_valid, packet_ready, packet_taken, words_copy, words_pending : std_ulogic;
  signal edge_data : std_ulogic_vector(layout.bits - 1 downto 0);
  signal second_data : std_ulogic_vector(second.bits - 1 downto 0);
  signal words : u_unsigned(carried * num_differences * word_width - 1 downto 0);

  signal walk : std_ulogic;
  signal channel_first_coming, channel_carry, span_coming : std_ulogic;

  signal walked_valid, walked_last, walked_mirror : std_ulogic;
  signal walked_column : u_unsigned(columns - 1 downto 0);
  signal walked_y : u_unsigned(coord_bits - 1 downto 0);
  signal walked_count : u_signed(columns - 1 downto 0);
  signal walked_span, span_data : std_ulogic_vector(span_bits - 1 downto 0);

  signal chain_full_next, span_valid, span_taken : std_ulogic;
  signal advance, span_single, span_ending : std_ulogic;
  signal drawn_valid, drawn_last : std_ulogic;
  signal drawn_x, drawn_y : u_unsigned(coord_bits - 1 downto 0);

  signal clamped : std_ulogic_vector(pixel_bits - 1 downto 0);
  signal emitted : std_ulogic_vector(pixel_bits - 1 downto 0);
  signal position_reg : std_ulogic_vector(2 * coord_bits downto 0) := (others => '0');
  signal clamped_valid : std_ulogic := '0';
  signal emitted_valid : std_ulogic;
  signal loader_busy, walker_busy, chain_busy : std_ulogic;
  signal loader_open, loader_offered, loader_ready : std_ulogic;

begin

  assert formats_ok
    report "raster_core: generics out of range"
    severity failure;

  -- Between the loader's packet and the walker there is no cycle in which neither is busy.
  loader_open <= '1' when single_buffer = 0 else not walker_busy;
  loader_offered <= setup_valid and loader_open;
  setup_ready <= loader_ready and loader_open;

  loader_inst : entity work.setup_loader
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, stream_width => stream_width,
      edge_section_bits => layout.bits, second_section_bits => second.bits, orders_low => layout.orders_low,
      with_last => with_last
    )
    port map (
      clk => clk, reset => reset,
      setup_valid => loader_offered, setup_ready => loader_ready, setup_data => setup_data,
      setup_last => setup_last, setup_cut => setup_cut,
      busy => loader_busy,
      packet_valid => packet_valid, packet_taken => packet_taken,
      words_pending => words_pending,
      edge_data => edge_data, second_data => second_data, words => words
    );

  packet_taken <= packet_valid and packet_ready;

  walker_inst : entity work.edge_walker
    generic map (
      coord_bits => coord_bits, column_bits => columns, edge_bits => edges, inputs_stay => single_buffer
    )
    port map (
      clk => clk, reset => reset, enable => walk, busy => walker_busy,
      setup_valid => packet_valid, setup_ready => packet_ready,
      setup_has_second => edge_data(layout.has_second_low),
      setup_mirror => edge_data(layout.mirror_low),
      setup_fractional => edge_data(layout.fractional_low),
      setup_y => unsigned(edge_data(layout.y_high downto layout.y_low)),
      setup_rows_first => signed(edge_data(layout.rows_first_high downto layout.rows_first_low)),
      setup_rows_second => signed(edge_data(layout.rows_second_high downto layout.rows_second_low)),
      setup_major_column => unsigned(edge_data(layout.major_column_high downto layout.major_column_low)),
      setup_major_error => signed(edge_data(layout.major_error_high downto layout.major_error_low)),
      setup_major_step => unsigned(edge_data(layout.major_step_high downto layout.major_step_low)),
      setup_major_increment =>
        unsigned(edge_data(layout.major_increment_high downto layout.major_increment_low)),
      setup_major_decrement =>
        signed(edge_data(layout.major_decrement_high downto layout.major_decrement_low)),
      setup_minor_column => unsigned(edge_data(layout.minor_column_high downto layout.minor_column_low)),
      setup_minor_error => signed(edge_data(layout.minor_error_high downto layout.minor_error_low)),
      setup_minor_step => unsigned(edge_data(layout.minor_step_high downto layout.minor_step_low)),
      setup_minor_increment =>
        unsigned(edge_data(layout.minor_increment_high downto layout.minor_increment_low)),
      setup_minor_decrement =>
        signed(edge_data(layout.minor_decrement_high downto layout.minor_decrement_low)),
      setup_second_column => unsigned(second_data(second.second_column_high downto second.second_column_low)),
      setup_second_error => signed(second_data(second.second_error_high downto second.second_error_low)),
      setup_second_step => unsigned(second_data(second.second_step_high downto second.second_step_low)),
      setup_second_increment =>
        unsigned(second_data(second.second_increment_high downto second.second_increment_low)),
      setup_second_decrement =>
        signed(second_data(second.second_decrement_high downto second.second_decrement_low)),
      words_pending => words_pending, words_copy => words_copy,
      channel_first_coming => channel_first_coming, channel_carry => channel_carry,
      span_coming => span_coming, span_valid => open, span_last => walked_last, span_mirror => walked_mirror,
      span_column => walked_column, span_y => walked_y, span_count => walked_count
    );

  -- The position's lane: edge walker, chain and span walker.
  handshake_inst : entity work.lane_handshake
    port map (
      clk => clk, reset => reset,
      walk_span_coming => span_coming, chain_full_next => chain_full_next, span_valid => span_valid,
      span_single => span_single, span_ending => span_ending,
      clamped_valid => clamped_valid, emitted_valid => emitted_valid, emitted_ready => pixel_ready,
      walk => walk, walked_valid => walked_valid, span_taken => span_taken, load => open, advance => advance
    );

  walked_span <=
    walked_last & walked_mirror & std_ulogic_vector(walked_y) & std_ulogic_vector(walked_column)
    & std_ulogic_vector(walked_count);

  channel_gen : for channel in 0 to carried - 1 generate

    function order_of(index : natural) return natural is
    begin
      if index < num_channels then
        return max_order;
      end if;
      return order_linear;
    end function;

    function frac_of(index : natural) return natural is
    begin
      if index < num_channels then
        return frac_bits;
      end if;
      return depth_frac_bits(formats);
    end function;

    function value_bits_of(index : natural) return natural is
    begin
      if index < num_channels then
        return value_bits;
      end if;
      return depth_bits;
    end function;

    constant bits : positive := value_bits_of(channel);
    -- Depth lies above the colour channels.
    constant value_low : natural := channel * value_bits;
    signal value : u_unsigned(bits - 1 downto 0);

  begin

    lane_inst : entity work.channel_lane
      generic map (
        word_width => word_width, max_order => order_of(channel), frac_bits => frac_of(channel),
        value_bits => bits, span_depth => span_depth, inputs_stay => single_buffer
      )
      port map (
        clk => clk, reset => reset,
        setup_words =>
          words((channel + 1) * num_differences * word_width - 1
            downto channel * num_differences * word_width),
        setup_copy => words_copy,
        walk_first_coming => channel_first_coming, walk_carry => channel_carry,
        walk_span_coming => span_coming,
        span_single => span_single, span_ending => span_ending,
        clamped_valid => clamped_valid, emitted_valid => emitted_valid, emitted_ready => pixel_ready,
        clamped_value => value
      );

    clamped(value_low + bits - 1 downto value_low) <= std_ulogic_vector(value);

  end generate;

  no_depth_gen : if with_depth = 0 generate
    clamped(num_channels * value_bits + depth_bits - 1 downto num_channels * value_bits) <= (others => '0');
  end generate;

  chain_inst : entity work.span_chain
    generic map (data_bits => span_bits, depth => span_depth)
    port map (
      clk => clk, reset => reset, busy => chain_busy,
      input_valid => walked_valid, input_ready => open, full_next => chain_full_next,
      input_data => walked_span,
      output_valid => span_valid, output_ready => span_taken, output_data => span_data
    );

  span_inst : entity work.span_walker
    generic map (coord_bits => coord_bits, column_bits => columns)
    port map (
      clk => clk, reset => reset,
      span_valid => span_valid, span_wanted => open,
      span_last => span_data(2 * columns + coord_bits + 1),
      span_mirror => span_data(2 * columns + coord_bits),
      span_y => unsigned(span_data(2 * columns + coord_bits - 1 downto 2 * columns)),
      span_column => unsigned(span_data(2 * columns - 1 downto columns)),
      span_count => signed(span_data(columns - 1 downto 0)),
      span_single => span_single, span_ending => span_ending, advance => advance,
      pixel_valid => drawn_valid, pixel_last => drawn_last, pixel_x => drawn_x, pixel_y => drawn_y
    );

  -- Beside the lanes' clamped values.
  position_stage : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        position_reg <= drawn_last & std_ulogic_vector(drawn_y) & std_ulogic_vector(drawn_x);
        clamped_valid <= drawn_valid;
      end if;
      if reset = '1' then
        clamped_valid <= '0';
      end if;
    end if;
  end process;

  clamped(pixel_bits - 1 downto num_channels * value_bits + depth_bits) <= position_reg;

  skid_inst : entity work.skid_buffer
    generic map (data_bits => pixel_bits)
    port map (
      clk => clk, reset => reset,
      input_valid => clamped_valid, input_ready => open, input_data => clamped,
      output_valid => emitted_valid, output_ready => pixel_ready, output_data => emitted
    );

  pixel_valid <= emitted_valid;
  pixel_value <= unsigned(emitted(num_channels * value_bits - 1 downto 0));
  pixel_depth <=
    unsigned(emitted(num_channels * value_bits + depth_bits - 1 downto num_channels * value_bits));
  pixel_x <= unsigned(emitted(num_channels * value_bits + depth_bits + coord_bits - 1
    downto num_channels * value_bits + depth_bits));
  pixel_y <= unsigned(emitted(pixel_bits - 2 downto pixel_bits - 1 - coord_bits));
  pixel_last <= emitted(pixel_bits - 1);
  idle <= not (loader_busy or walker_busy or chain_busy or drawn_valid or clamped_valid or emitted_valid);

end architecture;
