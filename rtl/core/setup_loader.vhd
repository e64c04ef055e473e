-- SPDX-License-Identifier: Apache-2.0
--
-- Collects a packet of set-up words into registers: bit fields of the edges, then the channels' differences,
-- group by group, each up to the group's highest order. Every register belongs to one set-up word of one
-- beat, so there is no multiplexer. A difference that is not sent is zero. A packet ends after a bounded
-- number of beats, whatever its bits say. With with_last, setup_last drops a packet that is not whole there.
--
-- Model: setup_loader.py.  Test: test_setup_loader.py.  Latency: 1 cycle after the last beat.
-- Throughput: one beat per cycle, and one cycle in which the edge walker takes the primitive,
-- or in which one that was cut is dropped.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;

entity setup_loader is
  generic (
    num_channels : positive := default_formats.num_channels;
    max_order : natural := default_formats.max_order;
    with_depth : natural := default_formats.with_depth;
    word_width : positive := default_formats.word_width;
    stream_width : positive := default_formats.stream_width;
    edge_section_bits : positive := 237;
    second_section_bits : positive := 94;
    -- Where the channels' orders stand in the edge section.
    orders_low : natural := 3;
    -- 1: setup_last is looked at.
    with_last : natural := 0
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    setup_valid : in std_ulogic;
    setup_ready : out std_ulogic;
    setup_data : in std_ulogic_vector(stream_width - 1 downto 0);
    -- The sender's last beat: what follows begins a packet.
    setup_last : in std_ulogic := '0';
    -- For a cycle: it came amid a packet, which is dropped.
    setup_cut : out std_ulogic;

    -- A packet is begun or waits.
    busy : out std_ulogic;

    -- A whole packet is there; it is given up in the cycle in which it is taken.
    packet_valid : out std_ulogic;
    packet_taken : in std_ulogic;
    -- The channels have yet to copy the words of the packet that was taken.
    words_pending : in std_ulogic;

    edge_data : out std_ulogic_vector(edge_section_bits - 1 downto 0);
    second_data : out std_ulogic_vector(second_section_bits - 1 downto 0);
    -- The differences, channel by channel.
    words : out u_unsigned((num_channels + with_depth) * num_differences * word_width - 1 downto 0)
  );
end entity;

architecture rtl of setup_loader is

  function ceil_div(a, b : positive) return positive is
  begin
    return (a + b - 1) / b;
  end function;

  function group_size_of(words_of_beat, words_of_difference : positive) return positive is
  begin
    if words_of_beat < words_of_difference then
      return 1;
    end if;
    return words_of_beat / words_of_difference;
  end function;

  function minimum_of(a, b : natural) return natural is
  begin
    if a < b then
      return a;
    end if;
    return b;
  end function;

  constant carried : positive := num_channels + with_depth;
  constant words_of_beat : positive := stream_width / setup_word_bits;
  constant words_of_difference : positive := ceil_div(word_width, setup_word_bits);
  constant edge_beats : positive := ceil_div(edge_section_bits, stream_width);
  constant second_beats : positive := ceil_div(second_section_bits, stream_width);
  -- Channels that share a beat; a difference wider than a beat makes a group of one channel.
  constant group_size : positive := group_size_of(words_of_beat, words_of_difference);
  constant num_groups : positive := ceil_div(carried, group_size);
  constant difference_beats : positive := ceil_div(words_of_difference, words_of_beat);

  constant difference_places : positive := num_groups * num_differences * difference_beats;

  -- One hot over all three vectors: which registers the next beat goes to.
  type state_t is record
    edge_at : std_ulogic_vector(0 to edge_beats - 1);
    second_at : std_ulogic_vector(0 to second_beats - 1);
    plane_at : std_ulogic_vector(0 to difference_places - 1);
    -- From the last beat of the edge section on, the differences are written.
    writes_words : std_ulogic;
  end record;

  -- A one in the first place.
  function first_of(length : positive) return std_ulogic_vector is
    variable v : std_ulogic_vector(0 to length - 1) := (others => '0');
  begin
    v(0) := '1';
    return v;
  end function;

  -- The place before the edge section's last; a section of one beat has none, and does not read it.
  function place_before_last return natural is
  begin
    if edge_beats = 1 then
      return 0;
    end if;
    return edge_beats - 2;
  end function;

  function writes_at_start return std_ulogic is
  begin
    if edge_beats = 1 then
      return '1';
    end if;
    return '0';
  end function;

  constant state_init : state_t := (
    edge_at => first_of(edge_beats),
    second_at => (others => '0'),
    plane_at => (others => '0'),
    writes_words => writes_at_start
  );

  -- Highest order that a group's channels are built for; depth is linear at most.
  function built_order(index : natural) return natural is
  begin
    if index * group_size < num_channels then
      if max_order = 0 and with_depth = 1 and (index + 1) * group_size > num_channels then
        return 1;
      end if;
      return max_order;
    end if;
    return 1;
  end function;

  signal state : state_t := state_init;
  signal state_next : state_t;
  signal full, cut : std_ulogic := '0';
  signal packet_done : std_ulogic;
  signal ready, accept, clear_words : std_ulogic;
  signal beat : std_ulogic_vector(stream_width - 1 downto 0) := (others => '0');
  signal edge_write : std_ulogic_vector(0 to edge_beats - 1) := (others => '0');
  signal second_write : std_ulogic_vector(0 to second_beats - 1) := (others => '0');
  signal plane_write : std_ulogic_vector(0 to difference_places - 1) := (others => '0');
  -- Of the packet that is coming in, from its first beat.
  signal has_second : std_ulogic := '0';
  signal orders : std_ulogic_vector(2 * carried - 1 downto 0) := (others => '0');
  signal edge_words : std_ulogic_vector(edge_beats * stream_width - 1 downto 0) := (others => '0');
  signal second_words : std_ulogic_vector(second_beats * stream_width - 1 downto 0) := (others => '0');
  -- By group: it has a channel of linear, of quadratic order.
  signal linear, quadratic : std_ulogic_vector(0 to num_groups - 1);

begin

  ready <= not full and not cut and not (state.writes_words and words_pending);
  accept <= setup_valid and ready;
  setup_ready <= ready;
  packet_valid <= full;
  setup_cut <= cut;
  busy <= full or not state.edge_at(0);

  order_gen : for index in 0 to num_groups - 1 generate
    levels : process (all)
      variable low, high : std_ulogic;
    begin
      low := '0';
      high := '0';
      for channel in index * group_size to minimum_of((index + 1) * group_size, carried) - 1 loop
        low := low or orders(2 * channel);
        high := high or orders(2 * channel + 1);
      end loop;
      linear(index) <= '0';
      quadratic(index) <= '0';
      if built_order(index) >= 1 then
        linear(index) <= low or high;
      end if;
      if built_order(index) >= 2 then
        quadratic(index) <= high;
      end if;
    end process;
  end generate;

  control : process (all)
    variable v : state_t;
    variable begins_differences, to_second, done, ends : std_ulogic;
    variable place : natural;
  begin
    v := state;
    done := '0';

    to_second := has_second;
    if edge_beats = 1 then
      to_second := setup_data(0);
    end if;

    if accept = '1' then
      for place_index in 1 to edge_beats - 1 loop
        v.edge_at(place_index) := state.edge_at(place_index - 1);
      end loop;
      v.second_at(0) := state.edge_at(edge_beats - 1) and to_second;
      for place_index in 1 to second_beats - 1 loop
        v.second_at(place_index) := state.second_at(place_index - 1);
      end loop;
      begins_differences :=
        (state.edge_at(edge_beats - 1) and not to_second) or state.second_at(second_beats - 1);
      for index in 0 to num_groups - 1 loop
        -- The first difference follows whatever ended before it.
        place := index * num_differences * difference_beats;
        v.plane_at(place) := begins_differences;
        begins_differences := '0';
        for difference in 0 to num_differences - 1 loop
          for part in 1 to difference_beats - 1 loop
            v.plane_at(place + part) := state.plane_at(place + part - 1);
          end loop;
          place := place + difference_beats;
          ends := '0';
          if difference = differences_of_order(0) - 1 then
            ends := not linear(index);
          elsif difference = differences_of_order(1) - 1 then
            ends := not quadratic(index);
          elsif difference = differences_of_order(2) - 1 then
            ends := '1';
          end if;
          begins_differences := begins_differences or (state.plane_at(place - 1) and ends);
          if difference < num_differences - 1 then
            v.plane_at(place) := state.plane_at(place - 1) and not ends;
          end if;
        end loop;
      end loop;
      done := begins_differences;
      v.edge_at(0) := done;
      v.writes_words := writes_at_start;
      if edge_beats > 1 then
        v.writes_words := (state.writes_words or state.edge_at(place_before_last)) and not done;
      end if;
    end if;

    packet_done <= done;
    state_next <= v;
  end process;

  state_register : process (clk)
  begin
    if rising_edge(clk) then
      state <= state_next;
      -- Nothing is accepted while it is full, so there is no order between the two.
      full <= packet_done or (full and not packet_taken);
      cut <= '0';
      if with_last = 1 then
        cut <= accept and setup_last and not packet_done;
      end if;
      -- Nor in the cycle behind a cut, so the length of a packet has a whole cycle to reach either flag.
      if reset = '1' or cut = '1' then
        state <= state_init;
      end if;
      if reset = '1' then
        full <= '0';
        cut <= '0';
      end if;
    end if;
  end process;

  -- A beat waits one cycle beside its write strobes, so that a strobe reaches its registers without logic.
  -- The packet may be valid meanwhile: the words written last are copied later than the edges are taken.
  beat_stage : process (clk)
  begin
    if rising_edge(clk) then
      beat <= setup_data;
      edge_write <= (others => '0');
      second_write <= (others => '0');
      plane_write <= (others => '0');
      if accept = '1' then
        edge_write <= state.edge_at;
        second_write <= state.second_at;
        plane_write <= state.plane_at;
        if state.edge_at(0) = '1' then
          has_second <= setup_data(0);
          orders <= setup_data(orders_low + 2 * carried - 1 downto orders_low);
        end if;
      end if;
    end if;
  end process;

  edge_gen : for index in 0 to edge_beats - 1 generate
    store : process (clk)
    begin
      if rising_edge(clk) then
        if edge_write(index) = '1' then
          edge_words((index + 1) * stream_width - 1 downto index * stream_width) <= beat;
        end if;
      end if;
    end process;
  end generate;

  second_gen : for index in 0 to second_beats - 1 generate
    store : process (clk)
    begin
      if rising_edge(clk) then
        if second_write(index) = '1' then
          second_words((index + 1) * stream_width - 1 downto index * stream_width) <= beat;
        end if;
      end if;
    end process;
  end generate;

  edge_data <= edge_words(edge_section_bits - 1 downto 0);
  second_data <= second_words(second_section_bits - 1 downto 0);

  -- Differences that the packet will not bring must be zero: cleared with the last beat of the edge section.
  clear_words <= edge_write(edge_beats - 1);

  channel_gen : for channel in 0 to carried - 1 generate
    plane_gen : for difference in 0 to num_differences - 1 generate
      constant base : natural := (channel * num_differences + difference) * word_width;
      -- Set-up words, counted from the first of the group's difference.
      constant first_word : natural := (channel mod group_size) * words_of_difference;
    begin
      part_gen : for part in 0 to words_of_difference - 1 generate
        constant word_of_beat : natural := (first_word + part) mod words_of_beat;
        constant place : natural :=
          ((channel / group_size) * num_differences + difference) * difference_beats
          + (first_word + part) / words_of_beat;
        constant width : natural := minimum_of(setup_word_bits, word_width - part * setup_word_bits);
        signal word : u_unsigned(width - 1 downto 0) := (others => '0');
      begin
        store : process (clk)
        begin
          if rising_edge(clk) then
            if difference > 0 and clear_words = '1' then
              word <= (others => '0');
            elsif plane_write(place) = '1' then
              word <= unsigned(
                beat(word_of_beat * setup_word_bits + width - 1 downto word_of_beat * setup_word_bits));
            end if;
          end if;
        end process;
        words(base + part * setup_word_bits + width - 1 downto base + part * setup_word_bits) <= word;
      end generate;
    end generate;
  end generate;

end architecture;
