-- SPDX-License-Identifier: Apache-2.0
--
-- The link protocol: opcodes, lengths, reasons, counters, and what HELLO says of a board.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/protocol.py: change that, then `make rtl`.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;

package link_pkg is

  constant header_bytes : positive := 4;
  constant crc_bytes : positive := 4;
  constant max_body : positive := 1024;
  constant phase_bits : positive := 24;
  constant break_bits : positive := 20;
  constant max_read : positive := 1012;
  constant edge_bytes : positive := 2;
  constant packed : positive := 256;
  constant escape_ones : positive := 5;
  constant protocol_version : positive := 1;

  -- Opcodes; bit 7 is set in answers, bit 4 in requests that are executed once and in order.
  constant opcode_hello : std_ulogic_vector(7 downto 0) := x"01";
  constant opcode_status : std_ulogic_vector(7 downto 0) := x"02";
  constant opcode_reset : std_ulogic_vector(7 downto 0) := x"03";
  constant opcode_baud : std_ulogic_vector(7 downto 0) := x"04";
  constant opcode_clear : std_ulogic_vector(7 downto 0) := x"10";
  constant opcode_state : std_ulogic_vector(7 downto 0) := x"11";
  constant opcode_triangles : std_ulogic_vector(7 downto 0) := x"12";
  constant opcode_read : std_ulogic_vector(7 downto 0) := x"13";
  constant opcode_frame_crc : std_ulogic_vector(7 downto 0) := x"14";
  constant opcode_swap : std_ulogic_vector(7 downto 0) := x"15";
  constant opcode_ack : std_ulogic_vector(7 downto 0) := x"80";
  constant opcode_hello_answer : std_ulogic_vector(7 downto 0) := x"81";
  constant opcode_status_answer : std_ulogic_vector(7 downto 0) := x"82";
  constant opcode_reset_answer : std_ulogic_vector(7 downto 0) := x"83";
  constant opcode_baud_answer : std_ulogic_vector(7 downto 0) := x"84";
  constant opcode_read_answer : std_ulogic_vector(7 downto 0) := x"93";
  constant opcode_frame_crc_answer : std_ulogic_vector(7 downto 0) := x"94";
  constant opcode_nak : std_ulogic_vector(7 downto 0) := x"c0";

  -- Why a frame was refused.
  constant reason_none : std_ulogic_vector(7 downto 0) := x"00";
  constant reason_out_of_order : std_ulogic_vector(7 downto 0) := x"01";
  constant reason_unknown_opcode : std_ulogic_vector(7 downto 0) := x"02";
  constant reason_bad_length : std_ulogic_vector(7 downto 0) := x"03";
  constant reason_bad_field : std_ulogic_vector(7 downto 0) := x"04";
  constant reason_no_room : std_ulogic_vector(7 downto 0) := x"05";

  -- Counters of STATUS, in their order, and their bits.
  constant num_counters : positive := 13;
  constant counter_frames : natural := 0;
  constant counter_primitives : natural := 1;
  constant counter_pixels : natural := 2;
  constant counter_clocks_busy : natural := 3;
  constant counter_clocks_idle : natural := 4;
  constant counter_bad_cobs : natural := 5;
  constant counter_bad_crc : natural := 6;
  constant counter_bad_length : natural := 7;
  constant counter_refused : natural := 8;
  constant counter_framing_errors : natural := 9;
  constant counter_overruns : natural := 10;
  constant counter_duplicates : natural := 11;
  constant counter_gaps : natural := 12;
  constant counter_bits : natural_vector_t(0 to num_counters - 1) := (
    32, 32, 32, 32, 32, 16, 16, 16, 16, 16, 16, 16, 16
  );

  -- Bits of the identity's features.
  constant feature_depth_test : natural := 1;
  constant feature_shade : natural := 2;
  constant feature_edge_map : natural := 4;
  constant feature_display : natural := 8;
  constant feature_two_buffers : natural := 16;
  constant feature_colours_656 : natural := 32;
  constant feature_colours_444 : natural := 64;
  constant feature_packed_read : natural := 128;
  constant feature_vertices : natural := 256;
  constant feature_single_buffer : natural := 512;
  constant feature_colours_565 : natural := 1024;

  -- What a board says of itself:
  --   clk_frequency_hz: system clock
  --   default_phase_step: phase step after power-up and after a break
  --   fifo_words: words of the command FIFO
  --   features: what it has, a bit each
  --   screen_width: pixels
  --   screen_height: pixels
  --   colour_bytes: bytes of a pixel in plane 0
  --   depth_bytes: bytes of a pixel in plane 1, 0 if there is none
  type board_t is record
    clk_frequency_hz : natural;
    default_phase_step : natural;
    fifo_words : natural;
    features : natural;
    screen_width : natural;
    screen_height : natural;
    colour_bytes : natural;
    depth_bytes : natural;
  end record board_t;

  constant identity_length : positive := 11;
  type identity_t is array (0 to identity_length - 1) of std_ulogic_vector(31 downto 0);
  function identity_of(f : formats_t; board : board_t) return identity_t;

  function least_words(opcode : std_ulogic_vector(7 downto 0)) return u_unsigned;
  function most_words(opcode : std_ulogic_vector(7 downto 0)) return u_unsigned;
  function is_request(opcode : std_ulogic_vector(7 downto 0); with_swap : natural) return std_ulogic;
  function phase_step_of(baud : positive; frequency : positive) return natural;

end package link_pkg;

package body link_pkg is

  -- What HELLO's answer says after link state and session, word by word.
  function identity_of(f : formats_t; board : board_t) return identity_t is
    variable words : identity_t;
  begin
    words(0) := std_ulogic_vector'(x"44485351");
    words(1) := std_ulogic_vector'(x"12ba1e01");
    words(2) := std_ulogic_vector(to_unsigned(num_counters, 16))
        & std_ulogic_vector(to_unsigned(protocol_version, 16));
    words(3) := std_ulogic_vector(to_unsigned(board.clk_frequency_hz, 32));
    words(4) := std_ulogic_vector(to_unsigned(board.default_phase_step, 32));
    words(5) := std_ulogic_vector(to_unsigned(board.features, 16))
        & std_ulogic_vector(to_unsigned(board.fifo_words, 16));
    words(6) := std_ulogic_vector(to_unsigned(board.screen_height, 16))
        & std_ulogic_vector(to_unsigned(board.screen_width, 16));
    words(7) := std_ulogic_vector(to_unsigned(f.max_order, 8))
        & std_ulogic_vector(to_unsigned(f.num_channels, 8))
        & std_ulogic_vector(to_unsigned(board.depth_bytes, 8))
        & std_ulogic_vector(to_unsigned(board.colour_bytes, 8));
    words(8) := std_ulogic_vector(to_unsigned(f.value_bits, 8))
        & std_ulogic_vector(to_unsigned(f.frac_bits, 8))
        & std_ulogic_vector(to_unsigned(f.word_width, 8))
        & std_ulogic_vector(to_unsigned(f.with_depth, 8));
    words(9) := std_ulogic_vector(to_unsigned(f.stream_width, 8))
        & std_ulogic_vector(to_unsigned(f.coord_bits, 8))
        & std_ulogic_vector(to_unsigned(f.subpixel_bits, 8))
        & std_ulogic_vector(to_unsigned(f.depth_bits, 8));
    words(10) := std_ulogic_vector(to_unsigned(f.shade_guard_bits, 8))
        & std_ulogic_vector(to_unsigned(f.num_specular, 8))
        & std_ulogic_vector(to_unsigned(f.with_shade, 8))
        & std_ulogic_vector(to_unsigned(f.span_depth, 8));
    return words;
  end function identity_of;

  -- Words of a request's shortest payload.
  function least_words(opcode : std_ulogic_vector(7 downto 0)) return u_unsigned is
    variable words : u_unsigned(7 downto 0) := (others => '0');
  begin
    if opcode = opcode_reset then
      words := to_unsigned(1, 8);
    end if;
    if opcode = opcode_baud then
      words := to_unsigned(1, 8);
    end if;
    if opcode = opcode_clear then
      words := to_unsigned(1, 8);
    end if;
    if opcode = opcode_state then
      words := to_unsigned(2, 8);
    end if;
    if opcode = opcode_triangles then
      words := to_unsigned(1, 8);
    end if;
    if opcode = opcode_read then
      words := to_unsigned(3, 8);
    end if;
    if opcode = opcode_frame_crc then
      words := to_unsigned(1, 8);
    end if;
    return words;
  end function least_words;

  -- Words of a request's longest payload.
  function most_words(opcode : std_ulogic_vector(7 downto 0)) return u_unsigned is
    variable words : u_unsigned(7 downto 0) := (others => '0');
  begin
    if opcode = opcode_reset then
      words := to_unsigned(1, 8);
    end if;
    if opcode = opcode_baud then
      words := to_unsigned(1, 8);
    end if;
    if opcode = opcode_clear then
      words := to_unsigned(1, 8);
    end if;
    if opcode = opcode_state then
      words := to_unsigned(254, 8);
    end if;
    if opcode = opcode_triangles then
      words := to_unsigned(254, 8);
    end if;
    if opcode = opcode_read then
      words := to_unsigned(3, 8);
    end if;
    if opcode = opcode_frame_crc then
      words := to_unsigned(1, 8);
    end if;
    return words;
  end function most_words;

  function is_request(opcode : std_ulogic_vector(7 downto 0); with_swap : natural) return std_ulogic is
    variable known : std_ulogic := '0';
  begin
    if opcode = opcode_hello then
      known := '1';
    end if;
    if opcode = opcode_status then
      known := '1';
    end if;
    if opcode = opcode_reset then
      known := '1';
    end if;
    if opcode = opcode_baud then
      known := '1';
    end if;
    if opcode = opcode_clear then
      known := '1';
    end if;
    if opcode = opcode_state then
      known := '1';
    end if;
    if opcode = opcode_triangles then
      known := '1';
    end if;
    if opcode = opcode_read then
      known := '1';
    end if;
    if opcode = opcode_frame_crc then
      known := '1';
    end if;
    if with_swap = 1 and opcode = opcode_swap then
      known := '1';
    end if;
    return known;
  end function is_request;

  -- 2**phase_bits * baud / frequency to nearest, bit by bit: the product has more than 32 bits.
  function phase_step_of(baud : positive; frequency : positive) return natural is
    variable rest : natural := baud;
    variable quotient : natural := 0;
  begin
    for index in 0 to phase_bits loop
      rest := 2 * rest;
      quotient := 2 * quotient;
      if rest >= frequency then
        rest := rest - frequency;
        quotient := quotient + 1;
      end if;
    end loop;
    return (quotient + 1) / 2;
  end function phase_step_of;

end package body link_pkg;
