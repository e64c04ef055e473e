-- SPDX-License-Identifier: Apache-2.0
--
-- Number formats and the layout of the set-up packet, as functions of the core's generics.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/formats.py: change them, then `make rtl`.
-- A section's layout function gives the lowest and the highest bit of every field, its bits and its beats.

package quadshade_pkg is

  -- Bits of a set-up word: the set-up stream is a row of them.
  constant setup_word_bits : positive := 32;

  -- Orders of a channel, and how many differences each needs.
  constant order_constant : natural := 0;
  constant order_linear : natural := 1;
  constant order_quadratic : natural := 2;
  type natural_vector_t is array (natural range <>) of natural;
  constant differences_of_order : natural_vector_t(0 to 2) := (1, 3, 6);

  -- Differences of a channel, in the order in which they are sent; the first is its value.
  constant num_differences : positive := 6;
  constant difference_value : natural := 0;
  constant difference_d_row : natural := 1;
  constant difference_d_col : natural := 2;
  constant difference_dd_row : natural := 3;
  constant difference_dd_mixed : natural := 4;
  constant difference_dd_col : natural := 5;

  -- The shade unit: operands, fractions, a power table's values and index, stages, addresses.
  constant factor_bits : positive := 18;
  constant coefficient_frac_bits : positive := 16;
  constant power_bits : positive := 16;
  constant power_mantissa_bits : positive := 5;
  constant power_stages : positive := 8;
  constant table_words : positive := 512;
  constant state_registers : positive := 4096;
  constant ambient_row : positive := 8;
  constant shaded_colours : positive := 3;

  -- Generics of the core:
  --   num_channels: colour channels, 1 to 8
  --   max_order: highest order the channels are built for: 0 constant, 1 linear, 2 quadratic
  --   with_depth: 1: a linear depth channel is built
  --   word_width: bits of a channel's registers and words, 12 to 60
  --   frac_bits: fraction bits of a colour word
  --   value_bits: bits of an emitted colour value
  --   depth_bits: bits of an emitted depth value
  --   subpixel_bits: fraction bits of a vertex coordinate, 0 to 12
  --   coord_bits: screen coordinates are 0 .. 2**coord_bits - 1
  --   stream_width: bits of the set-up stream: 32, 64 or 128
  --   span_depth: spans held between edge walker and span walker, 1 to 16
  --   with_shade: 1: diffuse and specular channels become a colour behind the core
  --   num_specular: with shade: how many of the channels, the last ones, are raised to a power
  --   shade_guard_bits: with shade: bits that channels carry below value_bits
  type formats_t is record
    num_channels : natural;
    max_order : natural;
    with_depth : natural;
    word_width : natural;
    frac_bits : natural;
    value_bits : natural;
    depth_bits : natural;
    subpixel_bits : natural;
    coord_bits : natural;
    stream_width : natural;
    span_depth : natural;
    with_shade : natural;
    num_specular : natural;
    shade_guard_bits : natural;
  end record formats_t;

  constant default_formats : formats_t := (
    num_channels => 3,
    max_order => 2,
    with_depth => 1,
    word_width => 32,
    frac_bits => 22,
    value_bits => 8,
    depth_bits => 16,
    subpixel_bits => 8,
    coord_bits => 12,
    stream_width => 32,
    span_depth => 2,
    with_shade => 0,
    num_specular => 1,
    shade_guard_bits => 10
  );

  -- True, or a failure that names the first generic out of range and the value got.
  function check_formats(f : formats_t) return boolean;

  -- colour channels and, last, depth
  function carried_channels(f : formats_t) return integer;
  -- a column is 0 .. 2**coord_bits, both included
  function column_bits(f : formats_t) return integer;
  -- an edge's height: the guard band is 3 screens high
  function edge_bits(f : formats_t) return integer;
  -- the DDA's error lies in -height .. height - 1
  function error_bits(f : formats_t) return integer;
  -- one bit of overshoot and the sign stay free
  function depth_frac_bits(f : formats_t) return integer;
  -- set-up words of a beat
  function beat_words(f : formats_t) return integer;
  -- set-up words of one difference
  function difference_words(f : formats_t) return integer;
  -- what a colour channel's lane emits
  function lane_value_bits(f : formats_t) return integer;
  -- fraction below what a lane emits: the same word, cut lower
  function lane_frac_bits(f : formats_t) return integer;
  -- colours of a pixel
  function emitted_channels(f : formats_t) return integer;
  -- of the tree that adds up to 8 channels: the binary logarithm, rounded up
  function sum_levels(f : formats_t) return integer;
  -- power, operand, product, sums, ambient, clamp; the output's registers come behind
  function shade_stages(f : formats_t) return integer;

  type edge_layout_t is record
    has_second_low : natural;
    has_second_high : natural;
    mirror_low : natural;
    mirror_high : natural;
    fractional_low : natural;
    fractional_high : natural;
    orders_low : natural;
    orders_high : natural;
    y_low : natural;
    y_high : natural;
    rows_first_low : natural;
    rows_first_high : natural;
    rows_second_low : natural;
    rows_second_high : natural;
    major_column_low : natural;
    major_column_high : natural;
    major_error_low : natural;
    major_error_high : natural;
    major_step_low : natural;
    major_step_high : natural;
    major_increment_low : natural;
    major_increment_high : natural;
    major_decrement_low : natural;
    major_decrement_high : natural;
    minor_column_low : natural;
    minor_column_high : natural;
    minor_error_low : natural;
    minor_error_high : natural;
    minor_step_low : natural;
    minor_step_high : natural;
    minor_increment_low : natural;
    minor_increment_high : natural;
    minor_decrement_low : natural;
    minor_decrement_high : natural;
    bits : natural;
    beats : natural;
  end record edge_layout_t;

  function edge_layout(f : formats_t) return edge_layout_t;

  type second_layout_t is record
    second_column_low : natural;
    second_column_high : natural;
    second_error_low : natural;
    second_error_high : natural;
    second_step_low : natural;
    second_step_high : natural;
    second_increment_low : natural;
    second_increment_high : natural;
    second_decrement_low : natural;
    second_decrement_high : natural;
    bits : natural;
    beats : natural;
  end record second_layout_t;

  function second_layout(f : formats_t) return second_layout_t;

end package quadshade_pkg;

package body quadshade_pkg is

  function check_formats(f : formats_t) return boolean is
  begin
    assert f.stream_width = 32 or f.stream_width = 64 or f.stream_width = 128
      report "generic stream_width is " & integer'image(f.stream_width)
        & "; give one of 32, 64, 128"
      severity failure;
    assert f.num_channels >= 1 and f.num_channels <= 8
      report "generic num_channels is " & integer'image(f.num_channels)
        & "; give a value from 1 to 8"
      severity failure;
    assert f.max_order >= 0 and f.max_order <= 2
      report "generic max_order is " & integer'image(f.max_order)
        & "; give a value from 0 to 2"
      severity failure;
    assert f.with_depth >= 0 and f.with_depth <= 1
      report "generic with_depth is " & integer'image(f.with_depth)
        & "; give a value from 0 to 1"
      severity failure;
    assert f.word_width >= 12 and f.word_width <= 60
      report "generic word_width is " & integer'image(f.word_width)
        & "; give a value from 12 to 60"
      severity failure;
    assert f.value_bits >= 1 and f.value_bits <= 18
      report "generic value_bits is " & integer'image(f.value_bits)
        & "; give a value from 1 to 18"
      severity failure;
    assert f.depth_bits >= 1 and f.depth_bits <= 31
      report "generic depth_bits is " & integer'image(f.depth_bits)
        & "; give a value from 1 to 31"
      severity failure;
    assert f.subpixel_bits >= 0 and f.subpixel_bits <= 12
      report "generic subpixel_bits is " & integer'image(f.subpixel_bits)
        & "; give a value from 0 to 12"
      severity failure;
    assert f.coord_bits >= 3 and f.coord_bits <= 13
      report "generic coord_bits is " & integer'image(f.coord_bits)
        & "; give a value from 3 to 13"
      severity failure;
    assert f.span_depth >= 1 and f.span_depth <= 16
      report "generic span_depth is " & integer'image(f.span_depth)
        & "; give a value from 1 to 16"
      severity failure;
    assert f.frac_bits >= 0 and f.frac_bits <= f.word_width - f.value_bits - 2
      report "generic frac_bits is " & integer'image(f.frac_bits)
        & "; give a value from 0 to word_width - value_bits - 2"
      severity failure;
    assert f.with_depth = 0
      or (f.depth_bits >= 1 and f.depth_bits <= f.word_width - 2)
      report "generic depth_bits is " & integer'image(f.depth_bits)
        & "; give a value from 1 to word_width - 2"
      severity failure;
    assert f.with_shade >= 0 and f.with_shade <= 1
      report "generic with_shade is " & integer'image(f.with_shade)
        & "; give a value from 0 to 1"
      severity failure;
    assert f.with_shade = 0
      or (f.num_specular >= 1 and f.num_specular <= f.num_channels)
      report "generic num_specular is " & integer'image(f.num_specular)
        & "; give a value from 1 to num_channels"
      severity failure;
    assert f.with_shade = 0
      or (f.value_bits >= 4 and f.value_bits <= 14)
      report "generic value_bits is " & integer'image(f.value_bits)
        & "; give a value from 4 to 14"
      severity failure;
    assert f.with_shade = 0
      or (f.shade_guard_bits >= 4 and f.shade_guard_bits <= 18 - f.value_bits)
      report "generic shade_guard_bits is " & integer'image(f.shade_guard_bits)
        & "; give a value from 4 to 18 - value_bits"
      severity failure;
    assert f.with_shade = 0
      or (f.frac_bits >= f.shade_guard_bits and f.frac_bits <= f.word_width - f.value_bits - 2)
      report "generic frac_bits is " & integer'image(f.frac_bits)
        & "; give a value from shade_guard_bits to word_width - value_bits - 2"
      severity failure;
    return true;
  end function check_formats;

  function carried_channels(f : formats_t) return integer is
  begin
    return f.num_channels + f.with_depth;
  end function carried_channels;

  function column_bits(f : formats_t) return integer is
  begin
    return f.coord_bits + 1;
  end function column_bits;

  function edge_bits(f : formats_t) return integer is
  begin
    return f.coord_bits + f.subpixel_bits + 2;
  end function edge_bits;

  function error_bits(f : formats_t) return integer is
  begin
    return edge_bits(f) + 1;
  end function error_bits;

  function depth_frac_bits(f : formats_t) return integer is
  begin
    return f.word_width - f.depth_bits - 2;
  end function depth_frac_bits;

  function beat_words(f : formats_t) return integer is
  begin
    return f.stream_width / 32;
  end function beat_words;

  function difference_words(f : formats_t) return integer is
  begin
    return (f.word_width + 31) / 32;
  end function difference_words;

  function lane_value_bits(f : formats_t) return integer is
  begin
    return f.value_bits + f.with_shade * f.shade_guard_bits;
  end function lane_value_bits;

  function lane_frac_bits(f : formats_t) return integer is
  begin
    return f.frac_bits - f.with_shade * f.shade_guard_bits;
  end function lane_frac_bits;

  function emitted_channels(f : formats_t) return integer is
  begin
    return f.num_channels * (1 - f.with_shade) + 3 * f.with_shade;
  end function emitted_channels;

  function sum_levels(f : formats_t) return integer is
  begin
    return (f.num_channels + 6) / 8 + (f.num_channels + 5) / 8 + (f.num_channels + 3) / 8;
  end function sum_levels;

  function shade_stages(f : formats_t) return integer is
  begin
    return (8 + 4 + sum_levels(f)) * f.with_shade;
  end function shade_stages;

  function edge_layout(f : formats_t) return edge_layout_t is
    variable layout : edge_layout_t;
  begin
    -- the minor side changes its edge at the middle vertex
    layout.has_second_low := 0;
    layout.has_second_high := layout.has_second_low + 1 - 1;
    -- the major edge is on the right: x is the bitwise NOT of u
    layout.mirror_low := layout.has_second_high + 1;
    layout.mirror_high := layout.mirror_low + 1 - 1;
    -- colour steps at the fractional edge (Abbas et al., section 5), not at pixel centres
    layout.fractional_low := layout.mirror_high + 1;
    layout.fractional_high := layout.fractional_low + 1 - 1;
    -- order of each channel, two bits each, channel 0 lowest
    layout.orders_low := layout.fractional_high + 1;
    layout.orders_high := layout.orders_low + 2 * carried_channels(f) - 1;
    -- first scanline
    layout.y_low := layout.orders_high + 1;
    layout.y_high := layout.y_low + f.coord_bits - 1;
    -- scanlines along the first minor edge, minus 2, two's complement
    layout.rows_first_low := layout.y_high + 1;
    layout.rows_first_high := layout.rows_first_low + column_bits(f) - 1;
    -- scanlines along the second minor edge, minus 2
    layout.rows_second_low := layout.rows_first_high + 1;
    layout.rows_second_high := layout.rows_second_low + column_bits(f) - 1;
    -- u at the first scanline
    layout.major_column_low := layout.rows_second_high + 1;
    layout.major_column_high := layout.major_column_low + column_bits(f) - 1;
    -- e + increment - height at the first scanline: its sign says no carry
    layout.major_error_low := layout.major_column_high + 1;
    layout.major_error_high := layout.major_error_low + error_bits(f) - 1;
    -- dx div height: whole pixels a scanline
    layout.major_step_low := layout.major_error_high + 1;
    layout.major_step_high := layout.major_step_low + column_bits(f) - 1;
    -- dx mod height
    layout.major_increment_low := layout.major_step_high + 1;
    layout.major_increment_high := layout.major_increment_low + edge_bits(f) - 1;
    -- increment - height
    layout.major_decrement_low := layout.major_increment_high + 1;
    layout.major_decrement_high := layout.major_decrement_low + error_bits(f) - 1;
    -- u at the first scanline
    layout.minor_column_low := layout.major_decrement_high + 1;
    layout.minor_column_high := layout.minor_column_low + column_bits(f) - 1;
    -- e + increment - height at the first scanline: its sign says no carry
    layout.minor_error_low := layout.minor_column_high + 1;
    layout.minor_error_high := layout.minor_error_low + error_bits(f) - 1;
    -- dx div height: whole pixels a scanline
    layout.minor_step_low := layout.minor_error_high + 1;
    layout.minor_step_high := layout.minor_step_low + column_bits(f) - 1;
    -- dx mod height
    layout.minor_increment_low := layout.minor_step_high + 1;
    layout.minor_increment_high := layout.minor_increment_low + edge_bits(f) - 1;
    -- increment - height
    layout.minor_decrement_low := layout.minor_increment_high + 1;
    layout.minor_decrement_high := layout.minor_decrement_low + error_bits(f) - 1;
    layout.bits := layout.minor_decrement_high + 1;
    layout.beats := (layout.bits + f.stream_width - 1) / f.stream_width;
    return layout;
  end function edge_layout;

  function second_layout(f : formats_t) return second_layout_t is
    variable layout : second_layout_t;
  begin
    -- u at the first scanline
    layout.second_column_low := 0;
    layout.second_column_high := layout.second_column_low + column_bits(f) - 1;
    -- e + increment - height at the first scanline: its sign says no carry
    layout.second_error_low := layout.second_column_high + 1;
    layout.second_error_high := layout.second_error_low + error_bits(f) - 1;
    -- dx div height: whole pixels a scanline
    layout.second_step_low := layout.second_error_high + 1;
    layout.second_step_high := layout.second_step_low + column_bits(f) - 1;
    -- dx mod height
    layout.second_increment_low := layout.second_step_high + 1;
    layout.second_increment_high := layout.second_increment_low + edge_bits(f) - 1;
    -- increment - height
    layout.second_decrement_low := layout.second_increment_high + 1;
    layout.second_decrement_high := layout.second_decrement_low + error_bits(f) - 1;
    layout.bits := layout.second_decrement_high + 1;
    layout.beats := (layout.bits + f.stream_width - 1) / f.stream_width;
    return layout;
  end function second_layout;

end package body quadshade_pkg;
