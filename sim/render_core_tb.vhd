-- SPDX-License-Identifier: Apache-2.0
--
-- Writes the state of a file (hexadecimal, address and word a line), then feeds the core from a file of
-- set-up beats (hexadecimal, a line each) and writes the pixels it emits (hexadecimal, a line each: last y x
-- depth values), stream always valid, sink ready but for one clock in stall_period (counted from the first
-- beat; 0: always). The last line is "clocks N": cycles from the first beat accepted to the last pixel out,
-- both included.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use std.env.all;
use std.textio.all;

use work.quadshade_pkg.all;

entity render_core_tb is
  generic (
    state_file : string;
    beats_file : string;
    pixels_file : string;
    stall_period : natural := 0;
    num_channels : positive := default_formats.num_channels;
    max_order : natural := default_formats.max_order;
    with_depth : natural := default_formats.with_depth;
    word_width : positive := default_formats.word_width;
    frac_bits : natural := default_formats.frac_bits;
    value_bits : positive := default_formats.value_bits;
    depth_bits : positive := default_formats.depth_bits;
    subpixel_bits : natural := default_formats.subpixel_bits;
    coord_bits : positive := default_formats.coord_bits;
    stream_width : positive := default_formats.stream_width;
    span_depth : positive := default_formats.span_depth;
    with_shade : natural := default_formats.with_shade;
    num_specular : positive := default_formats.num_specular;
    shade_guard_bits : positive := default_formats.shade_guard_bits
  );
end entity;

architecture sim of render_core_tb is

  constant period : time := 10 ns;

  signal clk : std_ulogic := '0';
  signal reset : std_ulogic := '1';
  signal running : boolean := true;
  signal setup_valid, setup_ready, pixel_valid, pixel_last, idle : std_ulogic := '0';
  signal setup_data : std_ulogic_vector(stream_width - 1 downto 0) := (others => '0');
  signal state_valid, state_ready : std_ulogic := '0';
  signal state_address : u_unsigned(31 downto 0) := (others => '0');
  signal state_data : std_ulogic_vector(31 downto 0) := (others => '0');
  signal pixel_x, pixel_y : u_unsigned(coord_bits - 1 downto 0);
  signal pixel_value :
    u_unsigned((num_channels * (1 - with_shade) + shaded_colours * with_shade) * value_bits - 1 downto 0);
  signal pixel_depth : u_unsigned(depth_bits - 1 downto 0);
  signal all_sent : boolean := false;
  signal pixel_ready : std_ulogic := '1';

begin

  clock : process
  begin
    while running loop
      clk <= '0';
      wait for period / 2;
      clk <= '1';
      wait for period / 2;
    end loop;
    wait;
  end process;

  core_inst : entity work.render_core
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
      subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
      span_depth => span_depth, with_shade => with_shade, num_specular => num_specular,
      shade_guard_bits => shade_guard_bits
    )
    port map (
      clk => clk, reset => reset,
      setup_valid => setup_valid, setup_ready => setup_ready, setup_data => setup_data,
      state_valid => state_valid, state_ready => state_ready, state_address => state_address,
      state_data => state_data,
      pixel_valid => pixel_valid, pixel_ready => pixel_ready, pixel_last => pixel_last,
      pixel_x => pixel_x, pixel_y => pixel_y, pixel_value => pixel_value, pixel_depth => pixel_depth,
      idle => idle
    );

  source : process
    file states : text open read_mode is state_file;
    file beats : text open read_mode is beats_file;
    variable row : line;
    variable address, word : std_logic_vector(31 downto 0);
    variable beat : std_logic_vector(stream_width - 1 downto 0);
  begin
    wait until rising_edge(clk);
    reset <= '0';
    while not endfile(states) loop
      readline(states, row);
      hread(row, address);
      hread(row, word);
      state_valid <= '1';
      state_address <= unsigned(address);
      state_data <= std_ulogic_vector(word);
      wait until rising_edge(clk) and state_ready = '1';
    end loop;
    state_valid <= '0';
    while not endfile(beats) loop
      readline(beats, row);
      hread(row, beat);
      setup_valid <= '1';
      setup_data <= std_ulogic_vector(beat);
      wait until rising_edge(clk) and setup_ready = '1';
    end loop;
    setup_valid <= '0';
    all_sent <= true;
    wait;
  end process;

  sink : process (clk)
    file pixels : text open write_mode is pixels_file;
    variable row : line;
    variable cycle, first_beat, last_pixel : natural := 0;
    variable started, emitted : boolean := false;
  begin
    if rising_edge(clk) and running then
      cycle := cycle + 1;
      if setup_valid = '1' and setup_ready = '1' and not started then
        started := true;
        first_beat := cycle;
      end if;
      if started and stall_period > 0 then
        pixel_ready <= '1';
        if (cycle - first_beat + 2) mod stall_period = 0 then
          pixel_ready <= '0';
        end if;
      end if;
      if pixel_valid = '1' and pixel_ready = '1' then
        emitted := true;
        last_pixel := cycle;
        hwrite(row, std_logic_vector'("000" & pixel_last));
        write(row, ' ');
        hwrite(row, std_logic_vector(pixel_y));
        write(row, ' ');
        hwrite(row, std_logic_vector(pixel_x));
        write(row, ' ');
        hwrite(row, std_logic_vector(pixel_depth));
        write(row, ' ');
        hwrite(row, std_logic_vector(pixel_value));
        writeline(pixels, row);
      end if;
      if all_sent and idle = '1' then
        if emitted then
          cycle := last_pixel - first_beat + 1;
        else
          cycle := 0;
        end if;
        write(row, string'("clocks "));
        write(row, cycle);
        writeline(pixels, row);
        running <= false;
      end if;
    end if;
  end process;

end architecture;
