-- SPDX-License-Identifier: Apache-2.0
--
-- Commands, one after the other: TRIANGLES' words go to the core, all others wait until it is idle.
-- STATE gives a word to each of consecutive addresses; READ and FRAME_CRC end when their answer is begun,
-- SWAP when it is taken, which on a board with a monitor is in its vertical blank.
--
-- Model: command_executor.py.  Test: test_command_executor.py.
-- Latency: 1 cycle from header to TRIANGLES' first word.  One word per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;

entity command_executor is
  generic (
    -- 1: two buffers, which SWAP swaps; else there is no such command.
    with_swap : natural := 0
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    core_idle : in std_ulogic;

    -- Frames in order: a header word, then the payload's.
    fifo_valid : in std_ulogic;
    fifo_ready : out std_ulogic;
    fifo_data : in std_ulogic_vector(31 downto 0);

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

    swap_valid : out std_ulogic;
    swap_ready : in std_ulogic := '0';

    read_valid : out std_ulogic;
    read_ready : in std_ulogic;
    read_x : out u_unsigned(15 downto 0);
    read_y : out u_unsigned(15 downto 0);
    read_width : out u_unsigned(15 downto 0);
    -- Bytes that are taken from read_data.
    read_count : out u_unsigned(15 downto 0);
    read_pixels : out u_unsigned(15 downto 0);
    read_plane : out u_unsigned(1 downto 0);
    read_packed : out std_ulogic;

    frame_crc_valid : out std_ulogic;
    frame_crc_ready : in std_ulogic;
    frame_crc_plane : out u_unsigned(1 downto 0);
    frame_crc_done : in std_ulogic;
    frame_crc_value : in std_ulogic_vector(31 downto 0);

    -- READ and FRAME_CRC wait for their answer: number, the bytes of read_count, or the CRC; what is here
    -- stays until result_taken.
    result_due : out std_ulogic;
    result_taken : in std_ulogic;
    command : out std_ulogic_vector(7 downto 0);
    number : out std_ulogic_vector(7 downto 0);
    crc : out std_ulogic_vector(31 downto 0)
  );
end entity;

architecture rtl of command_executor is

  subtype word_t is std_ulogic_vector(31 downto 0);
  type place_t is (header, gather, settle, dispatch, pass, answer);

  signal place : place_t := header;
  signal ready, due : std_ulogic;
  signal code, code_number : std_ulogic_vector(7 downto 0) := (others => '0');
  signal words_left : u_unsigned(7 downto 0) := (others => '0');
  -- The last words, the newest in 0.
  signal word_0, word_1, word_2 : word_t := (others => '0');
  signal address : u_unsigned(31 downto 0) := (others => '0');
  signal crc_known : std_ulogic := '0';
  signal crc_value : word_t := (others => '0');

begin

  ready <= setup_ready when place = pass and code = opcode_triangles else
    '1' when place = header or place = gather else
    state_ready when place = pass else
    '0';
  fifo_ready <= ready;
  setup_valid <= fifo_valid when place = pass and code = opcode_triangles else '0';
  setup_data <= fifo_data;
  state_valid <= fifo_valid when place = pass and code = opcode_state else '0';
  state_data <= fifo_data;
  state_address <= address;
  clear_valid <= '1' when place = dispatch and code = opcode_clear else '0';
  clear_colour <= word_0;
  swap_valid <= '1' when with_swap = 1 and place = dispatch and code = opcode_swap else '0';
  read_valid <= '1' when place = dispatch and code = opcode_read else '0';
  read_x <= unsigned(word_2(15 downto 0));
  read_y <= unsigned(word_2(31 downto 16));
  read_width <= unsigned(word_1(15 downto 0));
  read_count <= unsigned(word_1(31 downto 16));
  read_pixels <= unsigned(word_0(15 downto 0));
  read_plane <= unsigned(word_0(17 downto 16));
  read_packed <= '1' when (unsigned(word_0(31 downto 16)) and to_unsigned(packed, 16)) /= 0 else '0';
  frame_crc_valid <= '1' when place = dispatch and code = opcode_frame_crc else '0';
  frame_crc_plane <= unsigned(word_0(17 downto 16));
  due <= '1' when place = answer and (code = opcode_read or crc_known = '1') else '0';
  result_due <= due;

  execute : process (clk)
  begin
    if rising_edge(clk) then
      if frame_crc_done = '1' then
        crc_known <= '1';
        crc_value <= frame_crc_value;
      end if;
      -- No case statement: GHDL 2.0 gives that of all places no default, and Yosys a latch.
      if place = header then
        crc_known <= '0';
        code <= fifo_data(7 downto 0);
        code_number <= fifo_data(15 downto 8);
        words_left <= unsigned(fifo_data(25 downto 18));
        if fifo_valid = '1' then
          place <= gather;
          if fifo_data(7 downto 0) = opcode_triangles then
            place <= pass;
          end if;
          -- It has no words.
          if with_swap = 1 and fifo_data(7 downto 0) = opcode_swap then
            place <= settle;
          end if;
        end if;
      elsif place = gather then
        if fifo_valid = '1' then
          word_0 <= fifo_data;
          word_1 <= word_0;
          word_2 <= word_1;
          address <= unsigned(fifo_data);
          words_left <= words_left - 1;
          if code = opcode_state or words_left = 1 then
            place <= settle;
          end if;
        end if;
      elsif place = settle then
        if core_idle = '1' then
          place <= dispatch;
          if code = opcode_state then
            place <= pass;
          end if;
        end if;
      elsif place = dispatch then
        if code = opcode_clear then
          if clear_ready = '1' then
            place <= header;
          end if;
        elsif with_swap = 1 and code = opcode_swap then
          if swap_ready = '1' then
            place <= header;
          end if;
        elsif code = opcode_read then
          if read_ready = '1' then
            place <= answer;
          end if;
        elsif frame_crc_ready = '1' then
          place <= answer;
        end if;
      elsif place = pass then
        if fifo_valid = '1' and ready = '1' then
          address <= address + 1;
          words_left <= words_left - 1;
          if words_left = 1 then
            place <= header;
          end if;
        end if;
      else
        if due = '1' and result_taken = '1' then
          place <= header;
        end if;
      end if;
      if reset = '1' then
        place <= header;
      end if;
    end if;
  end process;

  command <= code;
  number <= code_number;
  crc <= crc_value;

end architecture;
