-- SPDX-License-Identifier: Apache-2.0
--
-- Words in an SDRAM of one data rate, in runs: up to run_words at successive columns of one row, a word per
-- cycle. A run opens its row and closes it; between runs the chip is refreshed. Two ports ask: the first
-- reads, and goes before the second, which reads or writes. No run waits for data amid it, so each is over
-- after a known number of cycles, and neither a refresh nor the first port waits for longer than that.
--
-- Model: sdram_controller.py.  Test: test_sdram_controller.py.
-- Latency: rcd_clocks + cas_clocks + 2 cycles from a request to its first word.
-- A word per cycle of a run, which takes about rcd_clocks + rp_clocks + 1 cycles beside its words.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity sdram_controller is
  generic (
    data_bits : positive := 16;
    bank_bits : positive := 2;
    row_bits : positive := 13;
    column_bits : positive := 9;
    run_words : positive := 64;
    -- The data sheet's times in clocks, upwards: of several chips at 100 MHz if left alone.
    cas_clocks : positive := 3;
    rcd_clocks : positive := 3;
    rp_clocks : positive := 3;
    ras_clocks : positive := 5;
    rc_clocks : positive := 7;
    rfc_clocks : positive := 7;
    mrd_clocks : positive := 2;
    wr_clocks : positive := 2;
    -- Clocks from a refresh to the next; of those, how many times the chip rests after power-up.
    refresh_clocks : positive := 780;
    power_up_refreshes : positive := 26
  );
  port (
    clk : in std_ulogic;
    -- Begins as after power-up; the chip keeps its words.
    reset : in std_ulogic;

    -- Reads so many words beside the one at the address, which is row, bank, column; a column beyond the last
    -- is the row's first one.
    first_valid : in std_ulogic;
    first_ready : out std_ulogic;
    first_address : in u_unsigned(row_bits + bank_bits + column_bits - 1 downto 0);
    first_more : in u_unsigned(address_bits(run_words) - 1 downto 0);
    first_data_valid : out std_ulogic;

    second_valid : in std_ulogic;
    second_ready : out std_ulogic;
    second_write : in std_ulogic;
    second_address : in u_unsigned(row_bits + bank_bits + column_bits - 1 downto 0);
    second_more : in u_unsigned(address_bits(run_words) - 1 downto 0);
    second_data_valid : out std_ulogic;

    -- The next word to write is taken, whatever stands there; with write_keep the chip's word stays.
    write_next : out std_ulogic;
    write_keep : in std_ulogic := '0';
    write_data : in std_ulogic_vector(data_bits - 1 downto 0);
    -- Of either port, in the clock of its data_valid.
    read_data : out std_ulogic_vector(data_bits - 1 downto 0) := (others => '0');

    -- The chip's pins, registers all; chip select is low, clock enable high.
    sdram_ras_n : out std_ulogic;
    sdram_cas_n : out std_ulogic;
    sdram_we_n : out std_ulogic;
    sdram_mask : out std_ulogic := '1';
    sdram_bank : out u_unsigned(bank_bits - 1 downto 0) := (others => '0');
    sdram_address : out u_unsigned(row_bits - 1 downto 0) := (others => '0');
    sdram_drive : out std_ulogic := '0';
    sdram_data_out : out std_ulogic_vector(data_bits - 1 downto 0) := (others => '0');
    sdram_data_in : in std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of sdram_controller is

  constant init_refreshes : positive := 8;
  -- From the last word to closing the row: it was open for long enough, and a written word is in its place.
  constant read_close : positive := maximum(1, ras_clocks - rcd_clocks);
  constant write_close : positive := maximum(wr_clocks, read_close);
  -- The longest run, from its request to that of the next: a refresh waits for it.
  constant longest : positive := rcd_clocks + run_words + write_close + rp_clocks;
  constant most_pause : positive := maximum(
    maximum(maximum(rcd_clocks, rp_clocks), maximum(rfc_clocks, mrd_clocks)), write_close);
  constant most_left : positive := maximum(maximum(run_words, init_refreshes), power_up_refreshes);
  constant left_bits : positive := address_bits(most_left);

  -- RAS, CAS and WE, all low active.
  subtype command_t is std_ulogic_vector(2 downto 0);
  constant nothing : command_t := "111";
  constant open_row : command_t := "011";
  constant read_word : command_t := "101";
  constant write_word : command_t := "100";
  constant close_rows : command_t := "010";
  constant refresh_row : command_t := "001";
  constant set_mode : command_t := "000";

  -- What comes next: after power-up four things, then a request, words, the end of a run.
  type state_t is (rests, closes, refreshes, sets, waits, moves, ends);

  signal state : state_t := rests;
  signal pause : natural range 0 to most_pause - 1 := 0;
  signal left : u_unsigned(left_bits - 1 downto 0) := to_unsigned(power_up_refreshes - 1, left_bits);
  signal interval : natural range 0 to refresh_clocks - 1 := refresh_clocks - 1;
  signal tick : std_ulogic := '0';
  signal due : std_ulogic := '0';

  signal command : command_t := nothing;
  signal column : u_unsigned(column_bits - 1 downto 0) := (others => '0');
  signal second, writes : std_ulogic := '0';
  -- Words on their way: the command's register, the chip, the word's register.
  signal first_coming, second_coming : std_ulogic_vector(0 to cas_clocks + 1) := (others => '0');

  signal free : std_ulogic;
  signal asked : u_unsigned(row_bits + bank_bits + column_bits - 1 downto 0);

  -- Row addresses are longer than columns; bit 10 is that of all banks.
  constant all_banks : u_unsigned(row_bits - 1 downto 0) :=
    shift_left(to_unsigned(1, row_bits), 10);

begin

  assert row_bits >= 11 and column_bits <= 10
    report "sdram_controller: " & integer'image(row_bits) & " bits of a row and " & integer'image(column_bits)
      & " of a column, must be at least 11, at most 10: between them stands the bit of all banks"
    severity failure;
  assert 2**address_bits(run_words) = run_words
    report "sdram_controller: run_words is " & integer'image(run_words) & ", must be a power of two"
    severity failure;
  assert cas_clocks = 2 or cas_clocks = 3
    report "sdram_controller: cas_clocks is " & integer'image(cas_clocks) & ", must be 2 or 3"
    severity failure;
  assert ras_clocks + rp_clocks >= rc_clocks
    report "sdram_controller: rc_clocks is " & integer'image(rc_clocks) & ", a run can be of "
      & integer'image(ras_clocks + rp_clocks)
    severity failure;
  assert refresh_clocks > longest + rfc_clocks and power_up_refreshes > 1
    report "sdram_controller: refresh_clocks is " & integer'image(refresh_clocks)
      & ", must be longer than the longest run and a refresh, " & integer'image(longest + rfc_clocks)
    severity failure;

  free <= '1' when state = waits and pause = 0 and due = '0' else '0';
  first_ready <= free;
  second_ready <= free and not first_valid;
  asked <= first_address when first_valid = '1' else second_address;
  write_next <= '1' when state = moves and pause = 0 and writes = '1' else '0';

  control : process (clk)
  begin
    if rising_edge(clk) then
      command <= nothing;
      first_coming <= '0' & first_coming(0 to cas_clocks);
      second_coming <= '0' & second_coming(0 to cas_clocks);
      sdram_drive <= '0';
      sdram_data_out <= write_data;
      read_data <= sdram_data_in;

      if pause /= 0 then
        pause <= pause - 1;
      elsif state = rests then
        if tick = '1' then
          left <= left - 1;
          if left = 0 then
            left <= to_unsigned(init_refreshes - 1, left_bits);
            state <= closes;
          end if;
        end if;
      elsif state = closes then
        command <= close_rows;
        sdram_address <= all_banks;
        pause <= rp_clocks - 1;
        state <= refreshes;
      elsif state = refreshes then
        command <= refresh_row;
        pause <= rfc_clocks - 1;
        left <= left - 1;
        if left = 0 then
          state <= sets;
        end if;
      elsif state = sets then
        command <= set_mode;
        sdram_bank <= (others => '0');
        -- Bursts of one word.
        sdram_address <= to_unsigned(16 * cas_clocks, row_bits);
        sdram_mask <= '0';
        pause <= mrd_clocks - 1;
        state <= waits;
      elsif state = waits then
        sdram_address <= asked(asked'high downto bank_bits + column_bits);
        sdram_bank <= asked(bank_bits + column_bits - 1 downto column_bits);
        column <= asked(column_bits - 1 downto 0);
        second <= not first_valid;
        writes <= second_write and not first_valid;
        left <= resize(second_more, left_bits);
        if first_valid = '1' then
          left <= resize(first_more, left_bits);
        end if;
        if due = '1' then
          command <= refresh_row;
          pause <= rfc_clocks - 1;
          due <= '0';
        elsif first_valid = '1' or second_valid = '1' then
          command <= open_row;
          pause <= rcd_clocks - 1;
          state <= moves;
        end if;
      elsif state = moves then
        sdram_address <= resize(column, row_bits);
        column <= column + 1;
        left <= left - 1;
        if writes = '1' then
          command <= write_word;
          sdram_drive <= '1';
          sdram_mask <= write_keep;
        else
          command <= read_word;
          first_coming(0) <= not second;
          second_coming(0) <= second;
        end if;
        if left = 0 then
          pause <= read_close - 1;
          if writes = '1' then
            pause <= write_close - 1;
          end if;
          state <= ends;
        end if;
      else
        command <= close_rows;
        sdram_address <= all_banks;
        sdram_mask <= '0';
        pause <= rp_clocks - 1;
        state <= waits;
      end if;

      tick <= '0';
      if interval = 0 then
        interval <= refresh_clocks - 1;
        tick <= '1';
        due <= '1';
      else
        interval <= interval - 1;
      end if;

      if reset = '1' then
        state <= rests;
        pause <= 0;
        left <= to_unsigned(power_up_refreshes - 1, left_bits);
        interval <= refresh_clocks - 1;
        tick <= '0';
        due <= '0';
        command <= nothing;
        first_coming <= (others => '0');
        second_coming <= (others => '0');
        sdram_drive <= '0';
        sdram_mask <= '1';
      end if;
    end if;
  end process;

  sdram_ras_n <= command(2);
  sdram_cas_n <= command(1);
  sdram_we_n <= command(0);
  first_data_valid <= first_coming(cas_clocks + 1);
  second_data_valid <= second_coming(cas_clocks + 1);

end architecture;
