-- SPDX-License-Identifier: Apache-2.0
--
-- Packed words of the line to set-up words of the core, a bit per clock: where a field's bits are not sent it
-- puts zeros below and the field's fill above. Widths stay in a memory from packet to packet.
--   packet = start bit, changed widths, 3 flags, orders or the last ones, fields, differences by channel
--
-- Model: word_unpacker.py.  Test: test_word_unpacker.py.
-- Latency: 1 cycle from a set-up word's last bit. Throughput: about 36 cycles per set-up word.
-- A packet ends after a bounded number of bits whatever they say; zeros between packets are skipped.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.packed_pkg.all;
use work.quadshade_pkg.all;

entity word_unpacker is
  generic (
    num_channels : positive := default_formats.num_channels;
    max_order : natural := default_formats.max_order;
    with_depth : natural := default_formats.with_depth;
    word_width : positive := default_formats.word_width;
    subpixel_bits : natural := default_formats.subpixel_bits;
    coord_bits : positive := default_formats.coord_bits;
    stream_width : positive := default_formats.stream_width;
    with_shade : natural := default_formats.with_shade;
    num_specular : positive := default_formats.num_specular
  );
  port (
    clk : in std_ulogic;
    -- Forgets a begun packet, and after some cycles the widths.
    reset : in std_ulogic;

    packed_valid : in std_ulogic;
    packed_ready : out std_ulogic;
    packed_data : in std_ulogic_vector(setup_word_bits - 1 downto 0);

    setup_valid : out std_ulogic;
    setup_ready : in std_ulogic;
    setup_data : out std_ulogic_vector(setup_word_bits - 1 downto 0);

    -- A packet is begun, a set-up word waits, or the widths are forgotten, one a cycle after a reset.
    busy : out std_ulogic
  );
end entity;

architecture rtl of word_unpacker is

  -- What is not a generic here does not matter.
  constant formats : formats_t := (
    num_channels, max_order, with_depth, word_width, 4, 4, 1, subpixel_bits, coord_bits, stream_width, 1,
    with_shade, num_specular, 4
  );
  constant carried : positive := carried_channels(formats);
  -- A position within a field is a number of a bit, as a width is.
  constant width_size : positive := width_bits(formats);
  constant address_size : positive := width_address_bits(formats);
  constant num_addresses : positive := 2 ** address_size;
  constant change_size : positive := address_size + width_size;
  constant num_orders : positive := 2 * carried;

  subtype position_t is u_unsigned(width_size - 1 downto 0);
  subtype address_t is u_unsigned(address_size - 1 downto 0);
  constant kind_bits : natural_vector_t(0 to num_packed_kinds - 1) := packed_kind_bits(formats);

  type step_t is (
    clearing, waiting, listing, changing, storing, flagging, asking, ordering,
    fetching, reading, running, padding
  );

  type state_t is record
    step : step_t;
    -- The next bit of packed_data.
    index : u_unsigned(4 downto 0);
    position : position_t;
    -- A width's address, and above it the width.
    change : u_unsigned(change_size - 1 downto 0);
    changes : address_t;
    has_second : std_ulogic;
    same : std_ulogic;
    -- Of all channels, the one whose turn it is lowest.
    orders : std_ulogic_vector(num_orders - 1 downto 0);
    in_words : std_ulogic;
    -- A field's kind, or the number of a difference.
    part : u_unsigned(2 downto 0);
    -- An edge, of rows the first or the second; a channel.
    group_index : u_unsigned(3 downto 0);
    below : position_t;
    fill : std_ulogic;
    lane_bit : u_unsigned(4 downto 0);
    full : std_ulogic;
  end record;

  constant state_init : state_t := (
    clearing, (others => '0'), (others => '0'), (others => '0'), (others => '0'), '0', '0', (others => '0'),
    '0', (others => '0'), (others => '0'), (others => '0'), '0', (others => '0'), '0'
  );

  type widths_t is array (0 to num_addresses - 1) of position_t;
  signal widths : widths_t;
  signal fetched : position_t;
  signal address, read_address : address_t;
  signal write_data : position_t;

  signal state : state_t := state_init;
  signal state_next : state_t;
  signal lane : std_ulogic_vector(setup_word_bits - 1 downto 0) := (others => '0');
  signal write_enable, give, given : std_ulogic;
  signal last_plane : u_unsigned(2 downto 0);

begin

  assert stream_width = setup_word_bits
    report "generic stream_width is " & integer'image(stream_width) & "; give 32 for packed words"
    severity failure;
  assert check_formats(formats)
    report "word_unpacker: generics out of range"
    severity failure;

  setup_valid <= state.full;
  setup_data <= lane;
  address <= state.change(address_size - 1 downto 0);
  busy <= '0' when state.step = waiting and state.full = '0' else '1';

  -- Of the channel whose turn it is; the address of a width.
  channel : process (all)
    variable is_depth : boolean;
    variable kind_base : address_t;
  begin
    is_depth := with_depth = 1 and state.group_index = num_channels;
    kind_base := to_unsigned(kind_widths * kind_colour, address_size);
    if is_depth then
      kind_base := to_unsigned(kind_widths * kind_depth, address_size);
    elsif with_shade = 1 and state.group_index >= num_channels - num_specular then
      -- Without shade there is no such address.
      kind_base := to_unsigned((kind_widths * kind_specular) mod num_addresses, address_size);
    end if;
    last_plane <= to_unsigned(differences_of_order(order_constant) - 1, 3);
    if max_order >= 2 and state.orders(1) = '1' and not is_depth then
      last_plane <= to_unsigned(differences_of_order(order_quadratic) - 1, 3);
    elsif (max_order >= 1 or is_depth) and (state.orders(1) = '1' or state.orders(0) = '1') then
      last_plane <= to_unsigned(differences_of_order(order_linear) - 1, 3);
    end if;
    read_address <= to_unsigned(field_widths, address_size) + state.part;
    if state.in_words = '1' then
      read_address <= kind_base + (state.part & '1');
      if state.step = fetching then
        read_address <= kind_base + (state.part & '0');
      end if;
    end if;
  end process;

  control : process (all)
    variable v : state_t;
    variable line_bit, sent, take, room : std_ulogic;
    variable last : position_t;
    variable fill : natural range 0 to 3;
  begin
    v := state;
    line_bit := packed_data(to_integer(state.index));
    room := not state.full;
    take := '0';
    give <= '0';
    given <= line_bit;
    write_enable <= '0';
    write_data <= state.change(change_size - 1 downto address_size);
    v.full := state.full and not setup_ready;
    sent := '0';
    if state.position >= state.below and state.position <= fetched then
      sent := '1';
    end if;
    -- A field's last bit and fill; an array of constants would be a memory, and unknown to proofs.
    last := to_unsigned(word_width - 1, width_size);
    fill := fill_sign;
    for kind in 0 to num_packed_kinds - 1 loop
      if state.in_words = '0' and state.part = kind then
        last := to_unsigned(kind_bits(kind) - 1, width_size);
        fill := packed_fills(kind);
      end if;
    end loop;
    -- A case would be a latch in GHDL's netlist: not every code is a step.
    if state.step = clearing then
      write_enable <= '1';
      write_data <= (others => '0');
      v.change(address_size - 1 downto 0) := address + 1;
      if address = num_addresses - 1 then
        v.step := waiting;
      end if;
    elsif state.step = waiting then
      take := packed_valid;
      v.changes := (others => '0');
      if packed_valid = '1' and line_bit = '1' then
        v.step := listing;
      end if;
    elsif state.step = listing then
      take := packed_valid;
      v.position := (others => '0');
      if packed_valid = '1' then
        v.step := flagging;
        if line_bit = '1' then
          v.step := changing;
        end if;
      end if;
    elsif state.step = changing then
      take := packed_valid;
      if packed_valid = '1' then
        v.change := line_bit & state.change(change_size - 1 downto 1);
        v.position := state.position + 1;
        if state.position = change_size - 1 then
          v.step := storing;
        end if;
      end if;
    elsif state.step = storing then
      write_enable <= '1';
      v.changes := state.changes + 1;
      v.position := (others => '0');
      v.step := listing;
      if state.changes = num_addresses - 1 then
        v.step := flagging;
      end if;
    elsif state.step = flagging then
      take := packed_valid and room;
      give <= packed_valid and room;
      if packed_valid = '1' and room = '1' then
        v.position := state.position + 1;
        if state.position = 0 then
          v.has_second := line_bit;
        end if;
        if state.position = num_raw_fields - 1 then
          v.step := asking;
        end if;
      end if;
    elsif state.step = asking then
      take := packed_valid;
      v.same := line_bit;
      v.position := (others => '0');
      v.in_words := '0';
      v.part := (others => '0');
      v.group_index := (others => '0');
      if packed_valid = '1' then
        v.step := ordering;
      end if;
    elsif state.step = ordering then
      if state.same = '1' then
        given <= state.orders(0);
      end if;
      if room = '1' and (packed_valid = '1' or state.same = '1') then
        take := not state.same;
        give <= '1';
        v.orders := line_bit & state.orders(num_orders - 1 downto 1);
        if state.same = '1' then
          v.orders := state.orders(0) & state.orders(num_orders - 1 downto 1);
        end if;
        v.position := state.position + 1;
        if state.position = num_orders - 1 then
          v.step := reading;
        end if;
      end if;
    elsif state.step = fetching then
      v.step := reading;
    elsif state.step = reading then
      v.position := (others => '0');
      v.below := (others => '0');
      v.fill := '0';
      if state.in_words = '1' then
        v.below := fetched;
      elsif fill = fill_one then
        v.fill := '1';
      end if;
      v.step := running;
    elsif state.step = running then
      given <= state.fill;
      if sent = '1' then
        given <= line_bit;
      elsif state.position < state.below then
        given <= '0';
      end if;
      if room = '1' and (sent = '0' or packed_valid = '1') then
        take := sent;
        give <= '1';
        if sent = '1' and fill = fill_sign then
          v.fill := line_bit;
        end if;
        v.position := state.position + 1;
        if state.position = last then
          v.step := reading;
          v.part := state.part + 1;
          if state.in_words = '1' then
            v.step := padding;
            v.part := state.part;
          elsif state.part = packed_rows and state.group_index(0) = '0' then
            -- Both counts of rows.
            v.part := state.part;
            v.group_index(0) := '1';
          elsif state.part = packed_rows then
            v.group_index(0) := '0';
          elsif state.part = num_packed_kinds - 1 then
            v.part := to_unsigned(packed_column, 3);
            v.group_index(0) := '1';
            if state.group_index /= 0 then
              v.step := padding;
            end if;
          end if;
        end if;
      end if;
    elsif state.step = padding then
      given <= '0';
      if state.lane_bit /= 0 then
        give <= room;
      elsif state.in_words = '0' and state.has_second = '1' and state.group_index(1) = '0' then
        v.group_index(1) := '1';
        v.step := reading;
      elsif state.in_words = '0' then
        v.in_words := '1';
        v.part := (others => '0');
        v.group_index := (others => '0');
        v.step := fetching;
      elsif state.part /= last_plane then
        v.part := state.part + 1;
        v.step := fetching;
      else
        v.orders := state.orders(1 downto 0) & state.orders(num_orders - 1 downto 2);
        v.part := (others => '0');
        v.group_index := state.group_index + 1;
        v.step := fetching;
        if state.group_index = carried - 1 then
          v.step := waiting;
        end if;
      end if;
    end if;

    packed_ready <= '0';
    if take = '1' then
      v.index := state.index + 1;
      if state.index = setup_word_bits - 1 then
        packed_ready <= '1';
      end if;
    end if;

    state_next <= v;
  end process;

  registers : process (clk)
  begin
    if rising_edge(clk) then
      state <= state_next;
      if give = '1' then
        lane <= given & lane(setup_word_bits - 1 downto 1);
        state.lane_bit <= state.lane_bit + 1;
        if state.lane_bit = setup_word_bits - 1 then
          state.full <= '1';
        end if;
      end if;
      if reset = '1' then
        state <= state_init;
      end if;
    end if;
  end process;

  memory : process (clk)
  begin
    if rising_edge(clk) then
      if write_enable = '1' then
        widths(to_integer(address)) <= write_data;
      end if;
      fetched <= widths(to_integer(read_address));
    end if;
  end process;

end architecture;
