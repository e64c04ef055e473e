-- SPDX-License-Identifier: Apache-2.0
--
-- One answer as bytes of a frame: opcode, number, length, link state, words, then bytes of a stream, CRC-32.
-- The words are asked for by their number while the answer is sent: 0 is the link state.
--
-- Model: answer_sender.py.  Test: test_answer_sender.py.  Latency: 1 cycle.  4 bytes in 5 cycles.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity answer_sender is
  generic (
    -- Of crc32: a byte takes at least as many.
    crc_cycles : positive := 1
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    -- Taken in a cycle with `answer_ready`; then free to change.
    answer_valid : in std_ulogic;
    answer_ready : out std_ulogic;
    answer_opcode : in std_ulogic_vector(7 downto 0);
    answer_number : in std_ulogic_vector(7 downto 0);
    -- Words, link state included, and bytes after them.
    answer_words : in u_unsigned(5 downto 0);
    answer_bytes : in u_unsigned(9 downto 0);
    -- The word that is asked for stands at word_data in the same cycle; it is taken in one with word_taken.
    word_index : out u_unsigned(5 downto 0);
    word_taken : out std_ulogic;
    word_data : in std_ulogic_vector(31 downto 0);
    data_valid : in std_ulogic;
    data_ready : out std_ulogic;
    data : in std_ulogic_vector(7 downto 0);
    byte_valid : out std_ulogic;
    byte_ready : in std_ulogic;
    byte_data : out std_ulogic_vector(7 downto 0);
    byte_last : out std_ulogic
  );
end entity;

architecture rtl of answer_sender is

  type place_t is (waiting, header, words, stream, finish, checksum);

  signal place : place_t := waiting;
  signal words_left, index : u_unsigned(5 downto 0) := (others => '0');
  signal bytes_left : u_unsigned(9 downto 0) := (others => '0');
  -- Four bytes on their way, the lowest first, and how many are left of them.
  signal shift : std_ulogic_vector(31 downto 0) := (others => '0');
  signal left : u_unsigned(2 downto 0) := (others => '0');
  signal length : u_unsigned(15 downto 0);
  signal crc : std_ulogic_vector(31 downto 0);
  signal crc_byte : std_ulogic_vector(7 downto 0);
  signal crc_valid, crc_clear, crc_busy, idle : std_ulogic;
  signal valid, accepted, loads_word : std_ulogic;

begin

  length <= resize(answer_words & "00", 16) + resize(answer_bytes, 16);
  idle <= '1' when place = waiting else '0';

  crc_unit : entity work.crc32
    generic map (cycles => crc_cycles)
    port map (
      clk => clk, clear => crc_clear, byte_valid => crc_valid, byte_data => crc_byte, busy => crc_busy,
      crc => crc
    );

  crc_clear <= idle;
  crc_valid <= accepted when place /= checksum else '0';

  output : process (all)
  begin
    valid <= '0';
    crc_byte <= shift(7 downto 0);
    if place = stream then
      valid <= data_valid and not crc_busy;
      crc_byte <= data;
    elsif left /= 0 then
      valid <= not crc_busy;
    end if;
  end process;

  byte_data <= crc_byte;
  byte_valid <= valid;
  accepted <= valid and byte_ready;
  byte_last <= '1' when place = checksum and left = 1 else '0';
  data_ready <= byte_ready and not crc_busy when place = stream else '0';
  answer_ready <= idle;
  word_index <= index;
  -- The word before it is out: header and words are followed by a word while there is one.
  loads_word <= '1' when (place = header or place = words) and left = 0 and words_left /= 0 else '0';
  word_taken <= loads_word;

  send : process (clk)
  begin
    if rising_edge(clk) then
      if accepted = '1' and place /= stream then
        shift <= x"00" & shift(31 downto 8);
        left <= left - 1;
      end if;
      -- No case statement: GHDL 2.0 gives that of all places no default, and Yosys a latch.
      if place = waiting then
        index <= (others => '0');
        words_left <= answer_words;
        bytes_left <= answer_bytes;
        if answer_valid = '1' then
          shift <= std_ulogic_vector(length) & answer_number & answer_opcode;
          left <= to_unsigned(4, 3);
          place <= header;
        end if;
      elsif place = header or place = words then
        if loads_word = '1' then
          shift <= word_data;
          left <= to_unsigned(4, 3);
          index <= index + 1;
          words_left <= words_left - 1;
          place <= words;
        elsif left = 0 then
          place <= finish;
          if bytes_left /= 0 then
            place <= stream;
          end if;
        end if;
      elsif place = stream then
        if accepted = '1' then
          bytes_left <= bytes_left - 1;
          if bytes_left = 1 then
            place <= finish;
          end if;
        end if;
      elsif place = finish then
        if crc_busy = '0' then
          shift <= crc;
          left <= to_unsigned(4, 3);
          place <= checksum;
        end if;
      else
        if accepted = '1' and left = 1 then
          place <= waiting;
        end if;
      end if;
      if reset = '1' then
        place <= waiting;
        left <= (others => '0');
      end if;
    end if;
  end process;

end architecture;
