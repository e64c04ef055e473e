-- SPDX-License-Identifier: Apache-2.0
--
-- Diffuse and specular channels to a colour:
--   colour = clamp(floor(ambient + sum(coefficient * factor))),  factor = value, or power(value) if specular
-- A specular channel may be gated: it counts only where the channel of its light's cosine is not 0.
-- From power-up until a state is written the first three channels are the colour.
--
-- Model: shade.py.  Test: test_shade.py.  Latency: shade_stages + 1 cycles (14 for one light, 16 for four).
-- One pixel per cycle. Multipliers: 3 a channel, 1 a specular channel; a block RAM a specular channel.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
use work.memory_pkg.all;

entity shade is
  generic (
    num_channels : positive := 2;
    num_specular : positive := 1;
    value_bits : positive := default_formats.value_bits;
    shade_guard_bits : positive := default_formats.shade_guard_bits;
    -- Of what goes along with a pixel: its place, depth and last.
    along_bits : positive := 41
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    -- Registers and tables; taken only while no pixel is on its way.
    state_valid : in std_ulogic;
    state_ready : out std_ulogic;
    state_address : in u_unsigned(31 downto 0);
    state_data : in std_ulogic_vector(31 downto 0);

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    -- Channel 0 lowest, the specular ones on top.
    pixel_value : in u_unsigned(num_channels * (value_bits + shade_guard_bits) - 1 downto 0);
    pixel_along : in std_ulogic_vector(along_bits - 1 downto 0);

    shaded_valid : out std_ulogic;
    shaded_ready : in std_ulogic;
    -- Red lowest.
    shaded_value : out u_unsigned(shaded_colours * value_bits - 1 downto 0);
    shaded_along : out std_ulogic_vector(along_bits - 1 downto 0);

    -- A pixel is on its way.
    busy : out std_ulogic
  );
end entity;

architecture rtl of shade is

  -- What belongs to the core alone is such that it is in range.
  constant formats : formats_t := (
    num_channels => num_channels, max_order => 0, with_depth => 0, word_width => 60,
    frac_bits => shade_guard_bits, value_bits => value_bits, depth_bits => 1, subpixel_bits => 0,
    coord_bits => 3, stream_width => 32, span_depth => 1, with_shade => 1, num_specular => num_specular,
    shade_guard_bits => shade_guard_bits
  );
  constant lane_width : positive := lane_value_bits(formats);
  constant levels : natural := sum_levels(formats);
  constant stages : positive := shade_stages(formats);
  constant num_diffuse : natural := num_channels - num_specular;

  -- A product of 36 bits, its fraction cut to that of a coefficient.
  constant product_bits : positive := value_bits + factor_bits;
  constant sum_bits : positive := product_bits + levels;
  -- One bit more for the ambient colour.
  constant level_bits : positive := sum_bits + 1;
  constant ambient_bits : positive := value_bits + coefficient_frac_bits;
  constant colour_bits : positive := shaded_colours * value_bits;

  -- The highest bit of a state address tells registers from tables.
  constant place_bits : positive := address_bits(state_registers);
  constant index_bits : positive := address_bits(table_words);

  subtype factor_t is u_unsigned(factor_bits - 1 downto 0);
  type factors_t is array (0 to num_channels - 1) of factor_t;
  -- A tree of adders as a heap: node n is the sum of 2n and 2n + 1; the leaves are the last ones.
  constant num_leaves : positive := 2**levels;
  type nodes_t is array (1 to 2 * num_leaves - 1) of u_unsigned(sum_bits - 1 downto 0);

  signal advance, accept_state, in_use, shown_valid : std_ulogic;
  signal valid : std_ulogic_vector(stages downto 1) := (others => '0');
  signal along : std_ulogic_vector(stages * along_bits - 1 downto 0) := (others => '0');
  -- Stage 9.
  signal factors : factors_t := (others => (others => '0'));
  signal clamped : u_unsigned(colour_bits - 1 downto 0);
  signal emitted, shown : std_ulogic_vector(colour_bits + along_bits - 1 downto 0);

  -- The state word accepted in the cycle before.
  signal write_table, write_register : std_ulogic := '0';
  signal write_place : u_unsigned(place_bits - 1 downto 0) := (others => '0');
  signal write_data : std_ulogic_vector(31 downto 0) := (others => '0');
  signal skips_table : std_ulogic_vector(num_specular - 1 downto 0) := (others => '1');
  signal gated : std_ulogic_vector(num_specular - 1 downto 0) := (others => '0');

  -- Registers stand in rows of four, a row a channel.
  function register_place(row : natural; column : natural) return u_unsigned is
  begin
    return to_unsigned(4 * row + column, place_bits);
  end function;

  -- Channel 0 is red, 1 green, 2 blue.
  function first_coefficients(colour : natural) return factors_t is
    variable first : factors_t := (others => (others => '0'));
  begin
    if colour < num_channels then
      first(colour) := to_unsigned(2**coefficient_frac_bits, factor_bits);
    end if;
    return first;
  end function;

begin

  assert check_formats(formats)
    report "shade: generics out of range"
    severity failure;

  -- State: a word is at its place before a pixel that is accepted with it comes there.
  in_use <= (or valid) or shown_valid;
  busy <= in_use;
  state_ready <= not in_use;
  accept_state <= '1' when state_valid = '1' and in_use = '0' and state_address(31 downto place_bits + 1) = 0
    else '0';

  state : process (clk)
  begin
    if rising_edge(clk) then
      write_table <= accept_state and not state_address(place_bits);
      write_register <= accept_state and state_address(place_bits);
      write_place <= state_address(place_bits - 1 downto 0);
      write_data <= state_data;
      if write_register = '1' and write_place = register_place(ambient_row, 3) then
        skips_table <= write_data(num_specular - 1 downto 0);
        gated <= write_data(8 + num_specular - 1 downto 8);
      end if;
    end if;
  end process;

  pipeline : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        valid <= valid(stages - 1 downto 1) & pixel_valid;
        along <= along((stages - 1) * along_bits - 1 downto 0) & pixel_along;
      end if;
      if reset = '1' then
        valid <= (others => '0');
      end if;
    end if;
  end process;

  -- Stages 1 to 9: what a channel is multiplied as.
  channel_gen : for channel in 0 to num_channels - 1 generate

    signal value : u_unsigned(lane_width - 1 downto 0);
    signal delayed : u_unsigned(power_stages * lane_width - 1 downto 0) := (others => '0');
    -- The value in stage 8, left-aligned.
    signal aligned : factor_t;

  begin

    value <= pixel_value((channel + 1) * lane_width - 1 downto channel * lane_width);
    aligned <= shift_left(
      resize(delayed(power_stages * lane_width - 1 downto (power_stages - 1) * lane_width), factor_bits),
      factor_bits - lane_width);

    delay : process (clk)
    begin
      if rising_edge(clk) then
        if advance = '1' then
          delayed <= delayed((power_stages - 1) * lane_width - 1 downto 0) & value;
        end if;
      end if;
    end process;

    diffuse_gen : if channel < num_diffuse generate

      operand : process (clk)
      begin
        if rising_edge(clk) then
          if advance = '1' then
            factors(channel) <= aligned;
          end if;
        end if;
      end process;

    end generate;

    specular_gen : if channel >= num_diffuse generate

      constant index : natural := channel - num_diffuse;
      signal table_enable : std_ulogic;
      signal power : u_unsigned(power_bits - 1 downto 0);
      signal is_dark : std_ulogic;
      -- The light's cosine is 0; in stage 8 that counts only if the channel is gated.
      signal dark : std_ulogic_vector(power_stages downto 1) := (others => '0');

    begin

      table_enable <= write_table when write_place(place_bits - 1 downto index_bits) = index else '0';

      power_inst : entity work.power_table
        generic map (lane_value_bits => lane_width)
        port map (
          clk => clk, advance => advance, value => value, power => power,
          write_enable => table_enable, write_address => write_place(index_bits - 1 downto 0),
          write_data => write_data
        );

      -- Its light's channel has the same number, if there is one.
      lit_gen : if index < num_diffuse generate
        is_dark <= not (or pixel_value((index + 1) * lane_width - 1 downto index * lane_width));
      end generate;

      free_gen : if index >= num_diffuse generate
        is_dark <= '0';
      end generate;

      operand : process (clk)
      begin
        if rising_edge(clk) then
          if advance = '1' then
            dark <= (dark(power_stages - 1) and gated(index)) & dark(power_stages - 2 downto 1) & is_dark;
            if dark(power_stages) = '1' then
              factors(channel) <= (others => '0');
            elsif skips_table(index) = '1' then
              factors(channel) <= aligned;
            else
              factors(channel) <= shift_left(resize(power, factor_bits), factor_bits - power_bits);
            end if;
          end if;
        end if;
      end process;

    end generate;

  end generate;

  colour_gen : for colour in 0 to shaded_colours - 1 generate

    signal coefficients : factors_t := first_coefficients(colour);
    signal ambient : u_unsigned(ambient_bits - 1 downto 0) := (others => '0');
    signal nodes : nodes_t := (others => (others => '0'));
    signal level : u_unsigned(level_bits - 1 downto 0) := (others => '0');
    signal over : std_ulogic;
    signal clamped_reg : u_unsigned(value_bits - 1 downto 0) := (others => '0');

  begin

    registers : process (clk)
    begin
      if rising_edge(clk) then
        for channel in 0 to num_channels - 1 loop
          if write_register = '1' and write_place = register_place(channel, colour) then
            coefficients(channel) <= unsigned(write_data(factor_bits - 1 downto 0));
          end if;
        end loop;
        if write_register = '1' and write_place = register_place(ambient_row, colour) then
          ambient <= unsigned(write_data(ambient_bits - 1 downto 0));
        end if;
      end if;
    end process;

    -- Stage 10 makes the leaves, the stages behind it the sums.
    sums : process (clk)
      variable product : u_unsigned(2 * factor_bits - 1 downto 0);
    begin
      if rising_edge(clk) then
        if advance = '1' then
          for channel in 0 to num_channels - 1 loop
            product := factors(channel) * coefficients(channel);
            nodes(num_leaves + channel) <=
              resize(product(2 * factor_bits - 1 downto 2 * factor_bits - product_bits), sum_bits);
          end loop;
          for leaf in num_leaves + num_channels to 2 * num_leaves - 1 loop
            nodes(leaf) <= (others => '0');
          end loop;
          for node in 1 to num_leaves - 1 loop
            nodes(node) <= nodes(2 * node) + nodes(2 * node + 1);
          end loop;
          level <= resize(nodes(1), level_bits) + resize(ambient, level_bits);
        end if;
      end if;
    end process;

    over <= or level(level_bits - 1 downto ambient_bits);

    -- The last stage.
    clamp : process (clk)
    begin
      if rising_edge(clk) then
        if advance = '1' then
          for place in 0 to value_bits - 1 loop
            clamped_reg(place) <= level(coefficient_frac_bits + place) or over;
          end loop;
        end if;
      end if;
    end process;

    clamped((colour + 1) * value_bits - 1 downto colour * value_bits) <= clamped_reg;

  end generate;

  emitted <=
    along(stages * along_bits - 1 downto (stages - 1) * along_bits) & std_ulogic_vector(clamped);

  output_inst : entity work.skid_buffer
    generic map (data_bits => colour_bits + along_bits)
    port map (
      clk => clk, reset => reset,
      input_valid => valid(stages), input_ready => advance, input_data => emitted,
      output_valid => shown_valid, output_ready => shaded_ready, output_data => shown
    );

  pixel_ready <= advance;
  shaded_valid <= shown_valid;
  shaded_value <= unsigned(shown(colour_bits - 1 downto 0));
  shaded_along <= shown(colour_bits + along_bits - 1 downto colour_bits);

end architecture;
