-- SPDX-License-Identifier: Apache-2.0
--
-- The whole board between its UART pins, in lock-step with a program on standard input and output: whenever
-- the line to rx is free this writes a line of hexadecimal bytes that came from tx meanwhile, and reads a
-- line: two digits for a byte that goes to rx, an empty line for nothing yet (idle_bits pass), "r" and
-- eight digits for another baud rate, "q" to stop.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use std.env.all;
use std.textio.all;

use work.quadshade_pkg.all;

entity board_tb is
  generic (
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
    clk_frequency_hz : positive := 5_000_000;
    baud : positive := 1_000_000;
    fifo_words : positive := 1024;
    screen_width : positive := 16;
    screen_height : positive := 12;
    with_edge_map : natural := 0;
    single_port_memory : natural := 0;
    with_video : natural := 0;
    buffers : positive := 1;
    colour_bits : positive := 8;
    with_packed_read : natural := 1;
    with_vertices : natural := 0;
    most_counter_bits : positive := 32;
    single_buffer : natural := 0;
    crc_cycles : positive := 1;
    clocks_per_pixel : positive := 4;
    bank_words : positive := 16384;
    with_sdram : natural := 0;
    sdram_row_bits : positive := 13;
    sdram_column_bits : positive := 9;
    sdram_refresh_clocks : positive := 780
  );
end entity;

architecture sim of board_tb is

  constant idle_bits : positive := 10;

  signal clk, tx : std_ulogic := '0';
  signal reset, rx : std_ulogic := '1';
  signal running : boolean := true;
  signal sdram_command : std_ulogic_vector(2 downto 0);
  signal sdram_mask : std_ulogic;
  signal sdram_bank : u_unsigned(1 downto 0);
  signal sdram_address : u_unsigned(sdram_row_bits - 1 downto 0);
  signal sdram_data_out, sdram_data_in : std_ulogic_vector(15 downto 0) := (others => '0');
  -- Clocks and rate in units of which a bit has clk_frequency_hz.
  signal rate : positive := baud;
  -- A free queue of bytes from tx: one is taken for good when the other process has written it.
  signal received : std_ulogic_vector(7 downto 0) := (others => '0');
  signal num_received : natural := 0;

begin

  clock : process
  begin
    while running loop
      clk <= '0';
      wait for 5 ns;
      clk <= '1';
      wait for 5 ns;
    end loop;
    wait;
  end process;

  dut : entity work.board
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
      subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
      span_depth => span_depth, with_shade => with_shade, num_specular => num_specular,
      shade_guard_bits => shade_guard_bits, clk_frequency_hz => clk_frequency_hz, baud => baud,
      fifo_words => fifo_words, screen_width => screen_width, screen_height => screen_height,
      with_edge_map => with_edge_map, single_port_memory => single_port_memory,
      with_video => with_video, buffers => buffers, colour_bits => colour_bits,
      with_packed_read => with_packed_read, with_vertices => with_vertices,
      most_counter_bits => most_counter_bits, single_buffer => single_buffer, crc_cycles => crc_cycles,
      clocks_per_pixel => clocks_per_pixel, bank_words => bank_words, with_sdram => with_sdram,
      sdram_row_bits => sdram_row_bits, sdram_column_bits => sdram_column_bits,
      sdram_refresh_clocks => sdram_refresh_clocks
    )
    port map (
      clk => clk, reset => reset, rx => rx, tx => tx, led => open,
      sdram_command => sdram_command, sdram_mask => sdram_mask, sdram_bank => sdram_bank,
      sdram_address => sdram_address, sdram_drive => open, sdram_data_out => sdram_data_out,
      sdram_data_in => sdram_data_in
    );

  -- An SDRAM that checks nothing: a word leaves it two clocks after its command, as with a latency of three.
  memory_gen : if with_sdram = 1 generate
    memory : process (clk)
      constant banks : positive := 4;
      constant columns : positive := 2**sdram_column_bits;
      type words_t is array (0 to banks * 2**sdram_row_bits * columns - 1)
        of std_ulogic_vector(15 downto 0);
      type rows_t is array (0 to banks - 1) of natural;
      type words_ptr_t is access words_t;
      variable words : words_ptr_t := new words_t;
      variable rows : rows_t := (others => 0);
      variable place : natural;
      variable leaving, following : std_ulogic_vector(15 downto 0) := (others => '0');
    begin
      if rising_edge(clk) then
        sdram_data_in <= leaving;
        leaving := following;
        place := (to_integer(sdram_bank) * 2**sdram_row_bits + rows(to_integer(sdram_bank))) * columns
          + to_integer(sdram_address(sdram_column_bits - 1 downto 0));
        if sdram_command = "011" then
          rows(to_integer(sdram_bank)) := to_integer(sdram_address);
        elsif sdram_command = "101" then
          following := words(place);
        elsif sdram_command = "100" and sdram_mask = '0' then
          words(place) := sdram_data_out;
        end if;
      end if;
    end process;
  end generate;

  -- Samples in the middle of bits, from the start bit's edge on.
  receive : process
    variable phase : natural;
    variable data : std_ulogic_vector(7 downto 0);
    variable is_start : boolean;
  begin
    wait until rising_edge(clk) and tx = '0' and reset = '0';
    phase := clk_frequency_hz / 2;
    for position in 0 to 9 loop
      loop
        phase := phase + rate;
        exit when phase >= clk_frequency_hz;
        wait until rising_edge(clk);
      end loop;
      phase := phase - clk_frequency_hz;
      if position = 0 then
        is_start := tx = '0';
      elsif position < 9 then
        data(position - 1) := tx;
      end if;
      exit when not is_start;
      if position < 9 then
        wait until rising_edge(clk);
      end if;
    end loop;
    if is_start and tx = '1' then
      received <= data;
      num_received <= num_received + 1;
    end if;
  end process;

  -- Bytes from tx are gathered here, so that one process alone writes.
  talk : process
    variable said, heard : line;
    variable kind : character;
    variable number : std_ulogic_vector(31 downto 0);
    variable data : std_ulogic_vector(7 downto 0);
    variable num_told : natural := 0;
    variable phase : natural := 0;
    variable good, stop : boolean := false;

    procedure pass_bit(level : std_ulogic) is
    begin
      rx <= level;
      loop
        wait until rising_edge(clk);
        if num_received /= num_told then
          hwrite(said, received);
          num_told := num_received;
        end if;
        phase := phase + rate;
        exit when phase >= clk_frequency_hz;
      end loop;
      phase := phase - clk_frequency_hz;
    end procedure;
  begin
    wait until rising_edge(clk);
    wait until rising_edge(clk);
    reset <= '0';
    said := new string'("");
    while not stop loop
      writeline(output, said);
      flush(output);
      if endfile(input) then
        stop := true;
      else
        readline(input, heard);
        if heard'length = 0 then
          for index in 1 to idle_bits loop
            pass_bit('1');
          end loop;
        elsif heard'length = 1 then
          stop := true;
        elsif heard'length = 2 then
          hread(heard, data, good);
          pass_bit('0');
          for index in 0 to 7 loop
            pass_bit(data(index));
          end loop;
          pass_bit('1');
        else
          read(heard, kind);
          hread(heard, number, good);
          rate <= to_integer(unsigned(number(30 downto 0)));
          wait until rising_edge(clk);
        end if;
      end if;
    end loop;
    running <= false;
    finish;
  end process;

end architecture;
