-- SPDX-License-Identifier: Apache-2.0
--
-- The board's end of the link between the UART's bytes and the units that draw: frames that are whole and
-- next in order become commands, once each; set-up words go to the core, the others wait until it is idle.
--
-- Model: command_decoder.py.  Test: test_command_decoder.py.  Latency: that of its parts.
-- Throughput: a set-up word every 4 cycles; on the line it takes 160 at least.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
use work.link_pkg.all;
use work.memory_pkg.all;

entity command_decoder is
  generic (
    -- The core's, for HELLO.
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
    -- The board's: see board_t.
    clk_frequency_hz : natural := 100_000_000;
    default_phase_step : natural := 167772;
    fifo_words : positive := 1024;
    features : natural := 0;
    screen_width : natural := 320;
    screen_height : natural := 240;
    colour_bytes : natural := 3;
    depth_bytes : natural := 2;
    -- Counters have no more bits than this; cycles that crc32 takes for a byte; registers of frame_fifo.
    most_counter_bits : positive := 32;
    crc_cycles : positive := 1;
    fifo_stages : positive := 4
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    -- uart_rx and uart_tx.
    line_valid : in std_ulogic;
    line_data : in std_ulogic_vector(7 downto 0);
    line_error : in std_ulogic;
    break_seen : in std_ulogic;
    send_valid : out std_ulogic;
    send_ready : in std_ulogic;
    send_data : out std_ulogic_vector(7 downto 0);
    send_busy : in std_ulogic;
    phase_step : out u_unsigned(phase_bits - 1 downto 0);

    -- RESET, one cycle: forget a begun packet, pixels on their way, reads that are not done.
    core_reset : out std_ulogic;
    -- Everything that was sent has been drawn, and a clear is done.
    core_idle : in std_ulogic;
    -- For counting.
    pixel_done : in std_ulogic;
    primitive_done : in std_ulogic;
    -- For lights: a good frame, and one that is not or has a bad character.
    frame_seen : out std_ulogic;
    fault_seen : out std_ulogic;

    setup_valid : out std_ulogic;
    setup_ready : in std_ulogic;
    setup_data : out std_ulogic_vector(31 downto 0);

    state_valid : out std_ulogic;
    state_ready : in std_ulogic;
    state_address : out u_unsigned(31 downto 0);
    state_data : out std_ulogic_vector(31 downto 0);

    clear_valid : out std_ulogic;
    clear_ready : in std_ulogic;
    clear_colour : out std_ulogic_vector(31 downto 0);

    -- With two_buffers among the features.
    swap_valid : out std_ulogic;
    swap_ready : in std_ulogic := '0';

    read_valid : out std_ulogic;
    read_ready : in std_ulogic;
    read_x : out u_unsigned(15 downto 0);
    read_y : out u_unsigned(15 downto 0);
    read_width : out u_unsigned(15 downto 0);
    -- Bytes, and the pixels that these are.
    read_count : out u_unsigned(15 downto 0);
    read_pixels : out u_unsigned(15 downto 0);
    read_plane : out u_unsigned(1 downto 0);
    -- They may be packed; so many are taken from read_data, known from the cycle after read_ready on.
    read_packed : out std_ulogic;
    read_bytes : in u_unsigned(9 downto 0);
    read_data_valid : in std_ulogic;
    read_data_ready : out std_ulogic;
    read_data : in std_ulogic_vector(7 downto 0);

    frame_crc_valid : out std_ulogic;
    frame_crc_ready : in std_ulogic;
    frame_crc_plane : out u_unsigned(1 downto 0);
    frame_crc_done : in std_ulogic;
    frame_crc_value : in std_ulogic_vector(31 downto 0)
  );
end entity;

architecture rtl of command_decoder is

  constant formats : formats_t := (
    num_channels, max_order, with_depth, word_width, frac_bits, value_bits, depth_bits, subpixel_bits,
    coord_bits, stream_width, span_depth, with_shade, num_specular, shade_guard_bits
  );
  constant board : board_t := (
    clk_frequency_hz, default_phase_step, fifo_words, features, screen_width, screen_height, colour_bytes,
    depth_bytes
  );
  constant identity : identity_t := identity_of(formats, board);
  constant free_bits : positive := address_bits(fifo_words) + 1;
  constant with_swap : natural := (features / feature_two_buffers) mod 2;

  subtype byte_t is std_ulogic_vector(7 downto 0);
  subtype word_t is std_ulogic_vector(31 downto 0);
  type word_vector_t is array (natural range <>) of word_t;

  -- Frames.
  signal byte_valid, frame_end, frame_good : std_ulogic;
  signal byte_data : byte_t;
  signal write_valid, commit, discard, overflow, ack, nak, request : std_ulogic;
  signal write_data, argument : word_t;
  signal expected, reason, opcode, number : byte_t;
  signal free : u_unsigned(free_bits - 1 downto 0);
  signal events : std_ulogic_vector(0 to num_counters - 1);
  signal counters : word_vector_t(0 to num_counters - 1);

  -- RESET has been received: everything but the baud rate begins anew.
  signal link_reset : std_ulogic := '0';
  signal all_reset : std_ulogic;
  signal session : word_t := (others => '0');

  -- The command in execution.
  signal fifo_valid, fifo_ready : std_ulogic;
  signal fifo_data, crc_value, word_data : word_t;
  signal command, command_number, frame_data : byte_t;

  -- Answers that wait, and the one that is sent.
  signal ack_due, nak_due, reply_due : std_ulogic := '0';
  signal ack_number, nak_number, nak_reason, reply_code, reply_number : byte_t := (others => '0');
  signal new_step, step : u_unsigned(phase_bits - 1 downto 0) := to_unsigned(default_phase_step, phase_bits);
  signal step_due : std_ulogic := '0';
  -- The room that the host was told, and what became free since, a cycle late.
  signal free_told : u_unsigned(free_bits - 1 downto 0) := to_unsigned(fifo_words, free_bits);
  signal freed : u_signed(free_bits downto 0) := (others => '0');
  signal answer_valid, answer_ready, result_due, result_taken, word_taken : std_ulogic;
  signal chosen_code, chosen_number, chosen_reason, sent_code, sent_reason : byte_t := (others => '0');
  signal chosen_words, word_index : u_unsigned(5 downto 0);
  signal chosen_bytes : u_unsigned(9 downto 0);
  signal chosen : std_ulogic_vector(3 downto 0);
  signal frame_valid, frame_ready, frame_last, encoding_done : std_ulogic;

begin

  all_reset <= reset or link_reset;
  core_reset <= link_reset;
  frame_seen <= ack or request;
  fault_seen <= line_error or events(counter_bad_cobs) or events(counter_bad_crc) or
    events(counter_bad_length) or events(counter_refused);
  phase_step <= step;

  decoder : entity work.cobs_decoder
    port map (
      clk => clk, reset => reset, line_valid => line_valid, line_data => line_data, line_error => line_error,
      byte_valid => byte_valid, byte_data => byte_data, frame_end => frame_end, frame_good => frame_good
    );

  receiver : entity work.frame_receiver
    generic map (
      screen_width => screen_width, screen_height => screen_height, colour_bytes => colour_bytes,
      depth_bytes => depth_bytes, with_edge_map => (features / feature_edge_map) mod 2,
      with_swap => with_swap, with_packed_read => (features / feature_packed_read) mod 2,
      crc_cycles => crc_cycles
    )
    port map (
      clk => clk, reset => all_reset, byte_valid => byte_valid, byte_data => byte_data,
      frame_end => frame_end, frame_good => frame_good,
      write_valid => write_valid, write_data => write_data, commit => commit, discard => discard,
      overflow => overflow, expected => expected, ack => ack, nak => nak, request => request,
      reason => reason, opcode => opcode, number => number, argument => argument,
      count_frame => events(counter_frames), count_bad_cobs => events(counter_bad_cobs),
      count_bad_crc => events(counter_bad_crc), count_bad_length => events(counter_bad_length),
      count_refused => events(counter_refused), count_overrun => events(counter_overruns),
      count_duplicate => events(counter_duplicates), count_gap => events(counter_gaps)
    );

  fifo : entity work.frame_fifo
    generic map (num_words => fifo_words, data_bits => 32, read_stages => fifo_stages)
    port map (
      clk => clk, reset => all_reset, write_valid => write_valid, write_data => write_data, commit => commit,
      discard => discard, overflow => overflow, free => free,
      read_valid => fifo_valid, read_ready => fifo_ready, read_data => fifo_data
    );

  events(counter_primitives) <= primitive_done;
  events(counter_pixels) <= pixel_done;
  events(counter_clocks_busy) <= not core_idle;
  events(counter_clocks_idle) <= core_idle;
  events(counter_framing_errors) <= line_error;

  counter_gen : for index in 0 to num_counters - 1 generate
    constant bits : positive := minimum(counter_bits(index), most_counter_bits);
    signal value : u_unsigned(bits - 1 downto 0) := (others => '0');
  begin
    count : process (clk)
    begin
      if rising_edge(clk) then
        if events(index) = '1' then
          value <= value + 1;
        end if;
        if all_reset = '1' then
          value <= (others => '0');
        end if;
      end if;
    end process;
    counters(index) <= std_ulogic_vector(resize(value, 32));
  end generate;

  executor : entity work.command_executor
    generic map (with_swap => with_swap)
    port map (
      clk => clk, reset => all_reset, core_idle => core_idle,
      fifo_valid => fifo_valid, fifo_ready => fifo_ready, fifo_data => fifo_data,
      setup_valid => setup_valid, setup_ready => setup_ready, setup_data => setup_data,
      state_valid => state_valid, state_ready => state_ready, state_address => state_address,
      state_data => state_data, clear_valid => clear_valid, clear_ready => clear_ready,
      clear_colour => clear_colour, swap_valid => swap_valid, swap_ready => swap_ready,
      read_valid => read_valid, read_ready => read_ready, read_x => read_x, read_y => read_y,
      read_width => read_width, read_count => read_count, read_pixels => read_pixels,
      read_plane => read_plane, read_packed => read_packed, frame_crc_valid => frame_crc_valid,
      frame_crc_ready => frame_crc_ready, frame_crc_plane => frame_crc_plane,
      frame_crc_done => frame_crc_done, frame_crc_value => frame_crc_value, result_due => result_due,
      result_taken => result_taken, command => command, number => command_number, crc => crc_value
    );

  -- Answers: what was asked at once, refusals, acknowledgements, results, in this order.
  chosen <= "1000" when reply_due = '1' else "0100" when nak_due = '1' else "0010" when ack_due = '1' else
    "0001" when result_due = '1' else "0000";
  answer_valid <= (reply_due or nak_due or ack_due or result_due) and not step_due and not link_reset;
  -- The next command begins when nothing more is needed of this one: its CRC is not overwritten before.
  result_taken <= word_taken when sent_code = opcode_read_answer and word_index = 0 else
    word_taken when sent_code = opcode_frame_crc_answer and word_index = 1 else '0';

  choose : process (all)
  begin
    chosen_reason <= reason_none;
    chosen_words <= to_unsigned(1, 6);
    chosen_bytes <= to_unsigned(0, 10);
    if chosen(3) = '1' then
      chosen_code <= reply_code or x"80";
      chosen_number <= reply_number;
      if reply_code = opcode_hello then
        chosen_words <= to_unsigned(2 + identity_length, 6);
      elsif reply_code = opcode_status then
        chosen_words <= to_unsigned(1 + num_counters, 6);
      end if;
    elsif chosen(2) = '1' then
      chosen_code <= opcode_nak;
      chosen_number <= nak_number;
      chosen_reason <= nak_reason;
    elsif chosen(1) = '1' then
      chosen_code <= opcode_ack;
      chosen_number <= ack_number;
    else
      chosen_code <= command or x"80";
      chosen_number <= command_number;
      if command = opcode_read then
        chosen_bytes <= read_bytes;
      else
        chosen_words <= to_unsigned(2, 6);
      end if;
    end if;
  end process;

  words : process (all)
    variable index : natural;
  begin
    index := to_integer(word_index);
    word_data <= crc_value;
    if index = 0 then
      word_data <= std_ulogic_vector(resize(free, 16)) & sent_reason & expected;
    elsif sent_code = opcode_hello_answer then
      word_data <= session;
      if index >= 2 and index < identity_length + 2 then
        word_data <= identity(index - 2);
      end if;
    elsif sent_code = opcode_status_answer then
      if index <= num_counters then
        word_data <= counters(index - 1);
      end if;
    end if;
  end process;

  answers : process (clk)
  begin
    if rising_edge(clk) then
      link_reset <= '0';
      if answer_valid = '1' and answer_ready = '1' then
        sent_code <= chosen_code;
        sent_reason <= chosen_reason;
        reply_due <= reply_due and not chosen(3);
        nak_due <= nak_due and not chosen(2);
        ack_due <= ack_due and not chosen(1);
        if chosen_code = opcode_baud_answer then
          step_due <= '1';
        end if;
      end if;
      freed <= signed('0' & free) - signed('0' & free_told);
      if word_taken = '1' and word_index = 0 then
        free_told <= free;
      end if;
      -- Credits that became free meanwhile, in quarters, unless an answer is due or begun, which tells them:
      -- else a host that has none would wait.
      if freed >= fifo_words / 4 and chosen = "0000" and answer_ready = '1' then
        ack_due <= '1';
        ack_number <= std_ulogic_vector(unsigned(expected) - 1);
      end if;
      if ack = '1' then
        ack_due <= '1';
        ack_number <= number;
      end if;
      if nak = '1' then
        nak_due <= '1';
        nak_number <= number;
        nak_reason <= reason;
      end if;
      -- The rate changes when the last bit of BAUD's answer is out.
      if step_due = '1' and answer_ready = '1' and encoding_done = '1' and send_busy = '0' then
        step_due <= '0';
        step <= new_step;
      end if;
      if break_seen = '1' then
        step <= to_unsigned(default_phase_step, phase_bits);
        step_due <= '0';
        if reply_code = opcode_baud then
          reply_due <= '0';
        end if;
      end if;
      if link_reset = '1' or reset = '1' then
        ack_due <= '0';
        nak_due <= '0';
        step_due <= '0';
        free_told <= to_unsigned(fifo_words, free_bits);
        freed <= (others => '0');
      end if;
      if request = '1' then
        reply_due <= '1';
        reply_code <= opcode;
        reply_number <= number;
        if opcode = opcode_baud then
          new_step <= unsigned(argument(phase_bits - 1 downto 0));
        elsif opcode = opcode_reset then
          session <= argument;
          link_reset <= '1';
        end if;
      end if;
      if reset = '1' then
        reply_due <= '0';
        link_reset <= '0';
        step <= to_unsigned(default_phase_step, phase_bits);
        session <= (others => '0');
      end if;
    end if;
  end process;

  sender : entity work.answer_sender
    generic map (crc_cycles => crc_cycles)
    port map (
      clk => clk, reset => all_reset, answer_valid => answer_valid, answer_ready => answer_ready,
      answer_opcode => chosen_code, answer_number => chosen_number, answer_words => chosen_words,
      answer_bytes => chosen_bytes, word_index => word_index, word_taken => word_taken,
      word_data => word_data,
      data_valid => read_data_valid, data_ready => read_data_ready, data => read_data,
      byte_valid => frame_valid, byte_ready => frame_ready, byte_data => frame_data, byte_last => frame_last
    );

  encoder : entity work.cobs_encoder
    port map (
      clk => clk, reset => all_reset, byte_valid => frame_valid, byte_ready => frame_ready,
      byte_data => frame_data, byte_last => frame_last, idle => encoding_done,
      line_valid => send_valid, line_ready => send_ready, line_data => send_data
    );

end architecture;
