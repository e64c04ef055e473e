-- SPDX-License-Identifier: Apache-2.0
--
-- Walks a primitive once from top to bottom, a scanline per cycle: the major edge, and on the minor side
-- the first edge, then from the middle vertex on the second. For each scanline it says where the span
-- starts, how many pixels it has (minus 2: the sign marks the last), and whether the major edge carried.
--
-- Model: edge_walker.py.  Test: test_edge_walker.py.  Latency: `walk_stages` enabled cycles.
-- Throughput: one scanline per enabled cycle, no bubble at the middle vertex or between primitives.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity edge_walker is
  generic (
    coord_bits : positive := 12;
    column_bits : positive := 13;
    edge_bits : positive := 22;
    -- Stages from a loaded scanline to its span: the channels need them all, the columns only four.
    walk_stages : positive := 7;
    -- 1: what stands at the set-up inputs stays until the unit is not busy; it keeps no copy of it.
    inputs_stay : natural := 0
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    -- All stages move together.
    enable : in std_ulogic;
    -- A scanline is in some stage.
    busy : out std_ulogic;

    setup_valid : in std_ulogic;
    setup_ready : out std_ulogic;
    setup_has_second : in std_ulogic;
    setup_mirror : in std_ulogic;
    setup_fractional : in std_ulogic;
    setup_y : in u_unsigned(coord_bits - 1 downto 0);
    -- Scanlines minus 2, so that the sign marks the last one.
    setup_rows_first : in u_signed(column_bits - 1 downto 0);
    setup_rows_second : in u_signed(column_bits - 1 downto 0);
    -- column, error, step, increment, decrement of three edges.
    setup_major_column, setup_minor_column, setup_second_column : in u_unsigned(column_bits - 1 downto 0);
    setup_major_error, setup_minor_error, setup_second_error : in u_signed(edge_bits downto 0);
    setup_major_step, setup_minor_step, setup_second_step : in u_unsigned(column_bits - 1 downto 0);
    setup_major_increment : in u_unsigned(edge_bits - 1 downto 0);
    setup_minor_increment : in u_unsigned(edge_bits - 1 downto 0);
    setup_second_increment : in u_unsigned(edge_bits - 1 downto 0);
    setup_major_decrement, setup_minor_decrement, setup_second_decrement : in u_signed(edge_bits downto 0);

    -- A primitive's first scanline is in stage 0: its channel words are still to be copied.
    words_pending : out std_ulogic;
    -- It has just come to stage 1: copy them now, whether the stages move or not.
    words_copy : out std_ulogic;

    -- To the channels: a primitive's first scanline is in stage 1; the carry of the scanline in stage 2.
    channel_first_coming : out std_ulogic;
    channel_carry : out std_ulogic;

    -- A span with at least one pixel, in the last stage but one.
    span_coming : out std_ulogic;
    -- The same in the last stage.
    span_valid : out std_ulogic;
    span_last : out std_ulogic;
    span_mirror : out std_ulogic;
    span_column : out u_unsigned(column_bits - 1 downto 0);
    span_y : out u_unsigned(coord_bits - 1 downto 0);
    span_count : out u_signed(column_bits - 1 downto 0)
  );
end entity;

architecture rtl of edge_walker is

  -- Stage 0: which scanline.
  signal valid_0, first_0 : std_ulogic := '0';
  -- A primitive's first scanline is in stage 0 or 1.
  signal spacing : std_ulogic := '0';
  signal second_pending : std_ulogic := '0';
  signal rows, rows_second : u_signed(column_bits - 1 downto 0) := (others => '1');
  signal mirror_0, fractional_0 : std_ulogic := '0';
  signal y_0 : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  -- What the DDAs take with the scanline that moves to stage 1: decided here, loaded there, so that the
  -- decision need not reach their registers within its cycle.
  signal minor_load_0 : std_ulogic := '0';
  signal major_column_0, major_step_0, minor_column_0, minor_step_0 : u_unsigned(column_bits - 1 downto 0) :=
    (others => '0');
  signal major_error_0, major_decrement_0, minor_error_0, minor_decrement_0 : u_signed(edge_bits downto 0) :=
    (others => '0');
  signal major_increment_0, minor_increment_0 : u_unsigned(edge_bits - 1 downto 0) := (others => '0');
  signal second_column, second_step : u_unsigned(column_bits - 1 downto 0) := (others => '0');
  signal second_error, second_decrement : u_signed(edge_bits downto 0) := (others => '0');
  signal second_increment : u_unsigned(edge_bits - 1 downto 0) := (others => '0');

  signal last_0, take, take_possible, switch : std_ulogic;

  -- Stage 1: the DDAs' errors.
  signal copy : std_ulogic := '0';
  signal valid_1, first_1, last_1, mirror_1, fractional_1 : std_ulogic := '0';
  signal y_1 : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  signal carry_1, minor_carry_1 : std_ulogic;

  -- Stage 2: its columns.
  signal valid_2, carry_2, last_2, mirror_2 : std_ulogic := '0';
  signal y_2 : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  signal column_2, minor_column_2 : u_unsigned(column_bits - 1 downto 0);

  -- Stage 3: its number of pixels. From there on the span waits for its colours.
  signal valid_3 : std_ulogic := '0';
  type columns_t is array (3 to walk_stages - 1) of u_unsigned(column_bits - 1 downto 0);
  type counts_t is array (3 to walk_stages - 1) of u_signed(column_bits - 1 downto 0);
  type ys_t is array (3 to walk_stages - 1) of u_unsigned(coord_bits - 1 downto 0);
  signal columns : columns_t := (others => (others => '0'));
  signal counts : counts_t := (others => (others => '0'));
  signal ys : ys_t := (others => (others => '0'));
  signal lasts, mirrors : std_ulogic_vector(3 to walk_stages - 1) := (others => '0');
  signal valids : std_ulogic_vector(4 to walk_stages - 1) := (others => '0');

begin

  assert walk_stages >= 6
    report "edge_walker: walk_stages is " & integer'image(walk_stages) & ", needs at least 6"
    severity failure;

  -- True as well while there is no scanline.
  last_0 <= rows(column_bits - 1) and not second_pending;
  -- Primitives enter at least three stages apart: the channels copy a primitive's words twice on the way.
  take_possible <= last_0 and not spacing;
  take <= setup_valid and take_possible;
  setup_ready <= take_possible and enable;
  switch <= rows(column_bits - 1) and second_pending;

  stage_0 : process (clk)
  begin
    if rising_edge(clk) then
      if enable = '1' then
        first_0 <= take;
        spacing <= take or first_0;
        if take = '1' then
          valid_0 <= '1';
          second_pending <= setup_has_second;
          rows <= setup_rows_first;
          mirror_0 <= setup_mirror;
          fractional_0 <= setup_fractional;
        else
          if last_0 = '1' then
            valid_0 <= '0';
          elsif switch = '1' then
            second_pending <= '0';
            rows <= rows_second;
          else
            rows <= rows - 1;
          end if;
        end if;
      end if;
      if reset = '1' then
        valid_0 <= '0';
        first_0 <= '0';
        spacing <= '0';
        second_pending <= '0';
        rows <= (others => '1');
      end if;
    end if;
  end process;

  copies_gen : if inputs_stay = 0 generate
    -- No decision reaches these registers: they take what is there until they hold what was taken.
    copies : process (clk)
    begin
      if rising_edge(clk) then
        if first_0 = '0' then
          y_0 <= setup_y;
          major_column_0 <= setup_major_column;
          major_error_0 <= setup_major_error;
          major_step_0 <= setup_major_step;
          major_increment_0 <= setup_major_increment;
          major_decrement_0 <= setup_major_decrement;
        end if;
        if second_pending = '0' then
          rows_second <= setup_rows_second;
          second_column <= setup_second_column;
          second_error <= setup_second_error;
          second_step <= setup_second_step;
          second_increment <= setup_second_increment;
          second_decrement <= setup_second_decrement;
        end if;
      end if;
    end process;
  end generate;

  wires_gen : if inputs_stay = 1 generate
    y_0 <= setup_y;
    major_column_0 <= setup_major_column;
    major_error_0 <= setup_major_error;
    major_step_0 <= setup_major_step;
    major_increment_0 <= setup_major_increment;
    major_decrement_0 <= setup_major_decrement;
    rows_second <= setup_rows_second;
    second_column <= setup_second_column;
    second_error <= setup_second_error;
    second_step <= setup_second_step;
    second_increment <= setup_second_increment;
    second_decrement <= setup_second_decrement;
  end generate;

  minor_edge : process (clk)
  begin
    if rising_edge(clk) then
      if enable = '1' then
        minor_load_0 <= take or switch;
        if second_pending = '1' then
          minor_column_0 <= second_column;
          minor_error_0 <= second_error;
          minor_step_0 <= second_step;
          minor_increment_0 <= second_increment;
          minor_decrement_0 <= second_decrement;
        else
          minor_column_0 <= setup_minor_column;
          minor_error_0 <= setup_minor_error;
          minor_step_0 <= setup_minor_step;
          minor_increment_0 <= setup_minor_increment;
          minor_decrement_0 <= setup_minor_decrement;
        end if;
      end if;
    end if;
  end process;

  major_inst : entity work.edge_dda
    generic map (column_bits => column_bits, edge_bits => edge_bits)
    port map (
      clk => clk, enable => enable, load => first_0,
      load_column => major_column_0, load_error => major_error_0, load_step => major_step_0,
      load_increment => major_increment_0, load_decrement => major_decrement_0,
      carry => carry_1, column => column_2
    );

  minor_inst : entity work.edge_dda
    generic map (column_bits => column_bits, edge_bits => edge_bits)
    port map (
      clk => clk, enable => enable, load => minor_load_0,
      load_column => minor_column_0, load_error => minor_error_0, load_step => minor_step_0,
      load_increment => minor_increment_0, load_decrement => minor_decrement_0,
      carry => minor_carry_1, column => minor_column_2
    );

  stage_1 : process (clk)
  begin
    if rising_edge(clk) then
      copy <= first_0 and enable;
      if enable = '1' then
        valid_1 <= valid_0;
        first_1 <= first_0;
        last_1 <= last_0;
        mirror_1 <= mirror_0;
        fractional_1 <= fractional_0;
        if first_0 = '1' then
          y_1 <= y_0;
        else
          y_1 <= y_1 + 1;
        end if;
      end if;
      if reset = '1' then
        valid_1 <= '0';
        first_1 <= '0';
      end if;
    end if;
  end process;

  stage_2 : process (clk)
  begin
    if rising_edge(clk) then
      if enable = '1' then
        valid_2 <= valid_1;
        last_2 <= last_1;
        mirror_2 <= mirror_1;
        y_2 <= y_1;
        carry_2 <= carry_1 and not fractional_1;
      end if;
      if reset = '1' then
        valid_2 <= '0';
      end if;
    end if;
  end process;

  spans : process (clk)
  begin
    if rising_edge(clk) then
      if enable = '1' then
        valid_3 <= valid_2;
        counts(3) <= signed(minor_column_2 - column_2) - 2;
        columns(3) <= column_2;
        ys(3) <= y_2;
        lasts(3) <= last_2;
        mirrors(3) <= mirror_2;
        -- An empty span counts -2; one of a single pixel -1.
        valids(4) <= valid_3 and (counts(3)(0) or not counts(3)(column_bits - 1));
        for stage in 4 to walk_stages - 1 loop
          counts(stage) <= counts(stage - 1);
          columns(stage) <= columns(stage - 1);
          ys(stage) <= ys(stage - 1);
          lasts(stage) <= lasts(stage - 1);
          mirrors(stage) <= mirrors(stage - 1);
        end loop;
        for stage in 5 to walk_stages - 1 loop
          valids(stage) <= valids(stage - 1);
        end loop;
      end if;
      if reset = '1' then
        valid_3 <= '0';
        valids <= (others => '0');
      end if;
    end if;
  end process;

  busy <= valid_0 or valid_1 or valid_2 or valid_3 or (or valids);
  words_copy <= copy;
  words_pending <= first_0;
  channel_first_coming <= first_1;
  channel_carry <= carry_2;
  span_coming <= valids(walk_stages - 2);
  span_valid <= valids(walk_stages - 1);
  span_last <= lasts(walk_stages - 1);
  span_mirror <= mirrors(walk_stages - 1);
  span_column <= columns(walk_stages - 1);
  span_y <= ys(walk_stages - 1);
  span_count <= counts(walk_stages - 1);

end architecture;
