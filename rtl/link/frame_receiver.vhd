-- SPDX-License-Identifier: Apache-2.0
--
-- Judges a frame at its end: CRC, exact length, opcode, fields, number, room; until then nothing has an
-- effect but that its words are written into the FIFO, where they do not count yet.
--
-- Model: frame_receiver.py.  Test: test_frame_receiver.py.  Latency: 2 cycles after the frame's end.
-- Throughput: one byte per cycle; at least 3 cycles from a frame's end to the next frame's fifth byte.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;
use work.memory_pkg.all;

entity frame_receiver is
  generic (
    -- What READ and FRAME_CRC may name: see board_t.
    screen_width : positive := 320;
    screen_height : positive := 240;
    colour_bytes : positive := 3;
    depth_bytes : natural := 2;
    with_edge_map : natural := 0;
    -- 1: SWAP is known.
    with_swap : natural := 0;
    -- 1: READ may ask for packed bytes.
    with_packed_read : natural := 0;
    -- Of crc32: as many cycles at least lie between two bytes, and before a frame's end.
    crc_cycles : positive := 1
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    byte_valid : in std_ulogic;
    byte_data : in std_ulogic_vector(7 downto 0);
    frame_end : in std_ulogic;
    frame_good : in std_ulogic;

    -- Header and payload, word by word.
    write_valid : out std_ulogic;
    write_data : out std_ulogic_vector(31 downto 0);
    commit : out std_ulogic := '0';
    discard : out std_ulogic := '0';
    overflow : in std_ulogic;

    -- The number that is accepted next.
    expected : out std_ulogic_vector(7 downto 0);

    -- For one cycle, what to answer to the frame that ended; the fields hold until the next frame's words.
    ack : out std_ulogic := '0';
    nak : out std_ulogic := '0';
    request : out std_ulogic := '0';
    reason : out std_ulogic_vector(7 downto 0) := reason_none;
    opcode : out std_ulogic_vector(7 downto 0);
    number : out std_ulogic_vector(7 downto 0);
    -- The payload's last word.
    argument : out std_ulogic_vector(31 downto 0);

    -- For one cycle, what to count.
    count_frame : out std_ulogic := '0';
    count_bad_cobs : out std_ulogic := '0';
    count_bad_crc : out std_ulogic := '0';
    count_bad_length : out std_ulogic := '0';
    count_refused : out std_ulogic := '0';
    count_overrun : out std_ulogic := '0';
    count_duplicate : out std_ulogic := '0';
    count_gap : out std_ulogic := '0'
  );
end entity;

architecture rtl of frame_receiver is

  constant crc_residue : std_ulogic_vector(31 downto 0) := x"2144df1c";
  constant count_bits : positive := 11;
  constant too_many : positive := max_body + 1;

  -- Bytes of the frame, up to too_many.
  signal count : u_unsigned(count_bits - 1 downto 0) := (others => '0');
  signal count_words : u_unsigned(count_bits - 3 downto 0);
  signal header : std_ulogic_vector(31 downto 0) := (others => '0');
  -- The payload's last three words, of READ: pixels and plane; width and count; x and y.
  signal last_word, word_before, word_first : std_ulogic_vector(31 downto 0) := (others => '0');
  signal shift : std_ulogic_vector(23 downto 0) := (others => '0');
  signal word : std_ulogic_vector(31 downto 0);
  signal word_done, in_payload : std_ulogic;
  signal length : u_unsigned(15 downto 0);
  signal crc : std_ulogic_vector(31 downto 0);
  -- A byte may come with it, the first of the next frame.
  signal crc_clear : std_ulogic := '0';

  constant width_bits : positive := address_bits(screen_width + 1);
  constant rows_bits : positive := address_bits(screen_height + 1);
  constant pixels_bits : positive := address_bits(max_read + 1);
  constant bytes_bits : positive := pixels_bits + 3;
  -- In three steps while the CRC comes: scanlines from y on, bytes of a pixel; pixels from there on at most,
  -- bytes of the pixels; whether the area is on the screen, and its pixels are what the bytes need.
  signal rows : u_unsigned(rows_bits - 1 downto 0) := (others => '0');
  signal pixel_bytes : u_unsigned(2 downto 0) := (others => '0');
  signal pixels_there : u_unsigned(width_bits + rows_bits - 1 downto 0) := (others => '0');
  signal pixels_bytes : u_unsigned(bytes_bits - 1 downto 0) := (others => '0');
  signal good_place, good_plane, good_area : std_ulogic := '0';

  -- One cycle after the frame's end.
  signal ended, good_cobs, good_size, good_crc, good_length : std_ulogic := '0';
  -- Of the header and the payload's last word, which stand long before the frame's end.
  signal known, good_payload, reads, sums, bad_rate : std_ulogic := '0';
  signal next_number, previous : u_unsigned(7 downto 0) := (others => '0');

  -- Whether no bit from `bits` on is set: what remains is compared in so many.
  function is_below(value : u_unsigned; bits : positive) return boolean is
  begin
    return bits >= value'length or value(value'left downto bits) = 0;
  end function;

  -- A payload of the length that its opcode has.
  function fits(code : std_ulogic_vector(7 downto 0); bytes : u_unsigned(15 downto 0)) return std_ulogic is
    variable words : u_unsigned(13 downto 0);
    variable good : std_ulogic := '1';
  begin
    words := bytes(15 downto 2);
    if bytes(1 downto 0) /= 0 or not is_below(words, 8) or words(7 downto 0) < least_words(code)
      or words(7 downto 0) > most_words(code)
    then
      good := '0';
    end if;
    return good;
  end function;

begin

  clearing : process (clk)
  begin
    if rising_edge(clk) then
      crc_clear <= frame_end or reset;
    end if;
  end process;

  crc_unit : entity work.crc32
    generic map (cycles => crc_cycles)
    port map (
      clk => clk, clear => crc_clear, byte_valid => byte_valid, byte_data => byte_data, busy => open,
      crc => crc
    );

  word <= byte_data & shift;
  count_words <= count(count_bits - 1 downto 2);
  word_done <= byte_valid when count(1 downto 0) = 3 else '0';
  length <= unsigned(header(31 downto 16));
  -- Word 0 is the header; word n of the payload ends with byte 4 n + 3.
  in_payload <= '1' when count_words /= 0 and count_words <= length(15 downto 2) else '0';
  write_valid <= '1' when word_done = '1' and (count = 3 or in_payload = '1') else '0';
  write_data <= word;

  gather : process (clk)
  begin
    if rising_edge(clk) then
      if byte_valid = '1' then
        shift <= byte_data & shift(23 downto 8);
        if count /= too_many then
          count <= count + 1;
        end if;
        if word_done = '1' and count = 3 then
          header <= word;
        end if;
        if word_done = '1' and in_payload = '1' then
          last_word <= word;
          word_before <= last_word;
          word_first <= word_before;
        end if;
      end if;
      ended <= frame_end;
      good_cobs <= frame_good;
      good_size <= '0';
      if count >= header_bytes + crc_bytes and count /= too_many then
        good_size <= '1';
      end if;
      good_crc <= '0';
      if crc = crc_residue then
        good_crc <= '1';
      end if;
      good_length <= '0';
      if is_below(length, count_bits - 1)
        and count = resize(length(count_bits - 2 downto 0), count_bits) + (header_bytes + crc_bytes)
      then
        good_length <= '1';
      end if;
      if frame_end = '1' then
        count <= (others => '0');
      end if;
      if reset = '1' then
        count <= (others => '0');
        ended <= '0';
      end if;
    end if;
  end process;

  area : process (clk)
    variable plane, left, top, columns, pixels, bytes : u_unsigned(15 downto 0);
    variable right : u_unsigned(width_bits downto 0);
    variable rest : u_unsigned(bytes_bits downto 0);
  begin
    if rising_edge(clk) then
      plane := unsigned(last_word(31 downto 16));
      if with_packed_read = 1 and reads = '1' then
        plane := plane and not to_unsigned(packed, 16);
      end if;
      pixels := unsigned(last_word(15 downto 0));
      bytes := unsigned(word_before(31 downto 16));
      columns := unsigned(word_before(15 downto 0));
      left := unsigned(word_first(15 downto 0));
      top := unsigned(word_first(31 downto 16));
      right := resize(left, width_bits + 1) + resize(columns, width_bits);

      good_place <= '0';
      if is_below(left, width_bits) and is_below(columns, width_bits) and columns /= 0
        and right <= screen_width and is_below(top, rows_bits) and top(rows_bits - 1 downto 0) < screen_height
      then
        good_place <= '1';
      end if;
      rows <= to_unsigned(screen_height, rows_bits) - resize(top, rows_bits);
      pixel_bytes <= (others => '0');
      if plane = 0 then
        pixel_bytes <= to_unsigned(colour_bytes, 3);
      elsif plane = 1 then
        pixel_bytes <= to_unsigned(depth_bytes, 3);
      elsif plane < 4 then
        pixel_bytes <= to_unsigned(edge_bytes * with_edge_map, 3);
      end if;

      pixels_there <= resize(columns, width_bits) * rows;
      pixels_bytes <= resize(pixels, pixels_bits) * pixel_bytes;
      good_plane <= '0';
      if pixel_bytes /= 0 then
        good_plane <= '1';
      end if;

      -- Bytes of the pixels that are not asked for: fewer than a pixel has.
      rest := resize(pixels_bytes, bytes_bits + 1) - resize(bytes, pixels_bits);

      good_area <= '0';
      if good_place = '1' and bytes /= 0 and is_below(bytes, pixels_bits)
        and bytes(pixels_bits - 1 downto 0) <= max_read and is_below(pixels, pixels_bits)
        and pixels(pixels_bits - 1 downto 0) <= max_read
        and pixels(pixels_bits - 1 downto 0) <= pixels_there and is_below(rest, 3)
        and rest(2 downto 0) < pixel_bytes
      then
        good_area <= '1';
      end if;
    end if;
  end process;

  opcode <= header(7 downto 0);
  number <= header(15 downto 8);
  argument <= last_word;
  expected <= std_ulogic_vector(next_number);

  fields : process (clk)
    variable code : std_ulogic_vector(7 downto 0);
  begin
    if rising_edge(clk) then
      code := header(7 downto 0);
      known <= is_request(code, with_swap);
      good_payload <= fits(code, length);
      reads <= '0';
      if code = opcode_read then
        reads <= '1';
      end if;
      sums <= '0';
      if code = opcode_frame_crc then
        sums <= '1';
      end if;
      -- A rate of at most a bit in four clocks, and of more than none.
      bad_rate <= '0';
      if code = opcode_baud and (unsigned(last_word) = 0 or unsigned(last_word) > 2 ** (phase_bits - 2)) then
        bad_rate <= '1';
      end if;
    end if;
  end process;

  judge : process (clk)
    variable code : std_ulogic_vector(7 downto 0);
    variable got, behind : u_unsigned(7 downto 0);
    variable bad_field, sequenced : std_ulogic;
    variable why : std_ulogic_vector(7 downto 0);
  begin
    if rising_edge(clk) then
      commit <= '0';
      discard <= '0';
      ack <= '0';
      nak <= '0';
      request <= '0';
      reason <= reason_none;
      count_frame <= '0';
      count_bad_cobs <= '0';
      count_bad_crc <= '0';
      count_bad_length <= '0';
      count_refused <= '0';
      count_overrun <= '0';
      count_duplicate <= '0';
      count_gap <= '0';

      code := header(7 downto 0);
      sequenced := code(4);
      got := unsigned(header(15 downto 8));
      behind := next_number - got;
      bad_field := (reads and not good_area) or ((reads or sums) and not good_plane) or bad_rate;

      why := reason_none;
      if ended = '1' and reset = '0' then
        discard <= '1';
        if good_cobs = '0' then
          count_bad_cobs <= '1';
        elsif good_size = '0' then
          count_bad_length <= '1';
        elsif good_crc = '0' then
          count_bad_crc <= '1';
        elsif good_length = '0' then
          count_bad_length <= '1';
          why := reason_bad_length;
        elsif known = '0' then
          count_refused <= '1';
          why := reason_unknown_opcode;
        elsif good_payload = '0' then
          count_bad_length <= '1';
          why := reason_bad_length;
        elsif bad_field = '1' then
          count_refused <= '1';
          why := reason_bad_field;
        elsif sequenced = '0' then
          request <= '1';
        else
          previous <= got;
          if behind = 0 then
            if overflow = '1' then
              count_overrun <= '1';
              why := reason_no_room;
            else
              discard <= '0';
              commit <= '1';
              ack <= '1';
              count_frame <= '1';
              next_number <= next_number + 1;
            end if;
          elsif behind <= 128 then
            ack <= '1';
            count_duplicate <= '1';
          else
            count_gap <= '1';
            -- Once for each run of numbers.
            if got /= previous + 1 then
              why := reason_out_of_order;
            end if;
          end if;
        end if;
        -- Answers are never answered: a line that echoes causes no storm.
        if why /= reason_none and code(7) = '0' then
          nak <= '1';
          reason <= why;
        end if;
      end if;

      if reset = '1' then
        next_number <= (others => '0');
        previous <= (others => '1');
      end if;
    end if;
  end process;

end architecture;
