-- SPDX-License-Identifier: Apache-2.0
--
-- One channel from its set-up words to its output value: scanline_channel, span_chain, pixel_channel and
-- output_clamp, with a copy of the core's handshake (lane_handshake). All lanes move in step with the edge
-- walker.
--
-- Model: channel_lane.py.  Test: test_channel_lane.py.
-- Latency: that of raster_core but for its skid buffer.  One scanline and one pixel per cycle.
-- One handshake for all lanes was tried first: its enables reached 1,100 registers across the chip, and their
-- routing, not the accumulator, set the clock. Synthesis must keep this hierarchy, or it merges the copies.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;

entity channel_lane is
  generic (
    word_width : positive := 32;
    max_order : natural := 2;
    frac_bits : natural := 22;
    value_bits : positive := 8;
    span_depth : positive := 3;
    -- See scanline_channel.
    inputs_stay : natural := 0
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    -- The channel's differences, a word each; copied when a primitive's first scanline has just come to
    -- stage 1.
    setup_words : in u_unsigned(num_differences * word_width - 1 downto 0);
    setup_copy : in std_ulogic;

    -- From the edge walker: whether a primitive's first scanline is in stage 1; the carry of the scanline in
    -- stage 2; whether a span is in the last stage but one.
    walk_first_coming : in std_ulogic;
    walk_carry : in std_ulogic;
    walk_span_coming : in std_ulogic;
    -- From the span walker: the waiting span has one pixel; the pixel after the one shown is the span's last.
    span_single : in std_ulogic;
    span_ending : in std_ulogic;
    -- From the output: what makes the skid buffer's ready.
    clamped_valid : in std_ulogic;
    emitted_valid : in std_ulogic;
    emitted_ready : in std_ulogic;

    clamped_value : out u_unsigned(value_bits - 1 downto 0)
  );
end entity;

architecture rtl of channel_lane is

  type differences_t is array (0 to num_differences - 1) of u_unsigned(word_width - 1 downto 0);
  signal planes : differences_t;

  -- A primitive's first scanline is in stage 2: the lane's own copy, because it chooses all that is loaded.
  signal walk_first : std_ulogic := '0';
  signal walk, walked_valid, chain_full_next : std_ulogic;
  signal walked_value, walked_d_col, walked_dd_col : u_unsigned(word_width - 1 downto 0);

  signal span_valid, span_taken, load, advance : std_ulogic;
  signal walked_words, span_words : std_ulogic_vector(3 * word_width - 1 downto 0);

  signal word : u_unsigned(word_width - 1 downto 0);
  signal value : u_unsigned(value_bits - 1 downto 0);
  signal value_reg : u_unsigned(value_bits - 1 downto 0) := (others => '0');

begin

  plane_gen : for difference in 0 to num_differences - 1 generate
    planes(difference) <= setup_words((difference + 1) * word_width - 1 downto difference * word_width);
  end generate;

  handshake_inst : entity work.lane_handshake
    port map (
      clk => clk, reset => reset,
      walk_span_coming => walk_span_coming, chain_full_next => chain_full_next, span_valid => span_valid,
      span_single => span_single, span_ending => span_ending,
      clamped_valid => clamped_valid, emitted_valid => emitted_valid, emitted_ready => emitted_ready,
      walk => walk, walked_valid => walked_valid, span_taken => span_taken, load => load, advance => advance
    );

  first_stage : process (clk)
  begin
    if rising_edge(clk) then
      if walk = '1' then
        walk_first <= walk_first_coming;
      end if;
      if reset = '1' then
        walk_first <= '0';
      end if;
    end if;
  end process;

  scanline_inst : entity work.scanline_channel
    generic map (word_width => word_width, max_order => max_order, inputs_stay => inputs_stay)
    port map (
      clk => clk, enable => walk, copy => setup_copy,
      setup_value => planes(difference_value),
      setup_d_row => planes(difference_d_row), setup_d_col => planes(difference_d_col),
      setup_dd_row => planes(difference_dd_row), setup_dd_mixed => planes(difference_dd_mixed),
      setup_dd_col => planes(difference_dd_col),
      first => walk_first, carry => walk_carry,
      span_value => walked_value, span_d_col => walked_d_col, span_dd_col => walked_dd_col
    );

  walked_words <=
    std_ulogic_vector(walked_dd_col) & std_ulogic_vector(walked_d_col) & std_ulogic_vector(walked_value);

  chain_inst : entity work.span_chain
    generic map (data_bits => 3 * word_width, depth => span_depth)
    port map (
      clk => clk, reset => reset, busy => open,
      input_valid => walked_valid, input_ready => open, full_next => chain_full_next,
      input_data => walked_words,
      output_valid => span_valid, output_ready => span_taken, output_data => span_words
    );

  pixel_inst : entity work.pixel_channel
    generic map (word_width => word_width, max_order => max_order)
    port map (
      clk => clk, advance => advance, load => load,
      span_value => unsigned(span_words(word_width - 1 downto 0)),
      span_d_col => unsigned(span_words(2 * word_width - 1 downto word_width)),
      span_dd_col => unsigned(span_words(3 * word_width - 1 downto 2 * word_width)),
      pixel_value => word
    );

  clamp_inst : entity work.output_clamp
    generic map (word_width => word_width, frac_bits => frac_bits, value_bits => value_bits)
    port map (word => word, value => value);

  clamp_stage : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        value_reg <= value;
      end if;
    end if;
  end process;

  clamped_value <= value_reg;

end architecture;
