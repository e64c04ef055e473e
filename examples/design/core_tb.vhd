-- SPDX-License-Identifier: Apache-2.0
--
-- A bench around the core: it sends words.hex, and each pixel must be the next line of words.pixels.csv.
-- Both are what `quadshade words triangles.json -o words.hex` writes. The core has its default generics
-- and is in a library of its own.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use std.env.all;
use std.textio.all;

library quadshade;

entity core_tb is
  generic (
    words_file : string := "words.hex";
    pixels_file : string := "words.pixels.csv"
  );
end entity;

architecture sim of core_tb is

  signal clk, setup_valid, setup_ready, pixel_valid, pixel_ready, pixel_last, idle : std_ulogic := '0';
  signal reset : std_ulogic := '1';
  signal setup_data : std_ulogic_vector(31 downto 0) := (others => '0');
  signal pixel_x, pixel_y : u_unsigned(11 downto 0);
  signal pixel_value : u_unsigned(23 downto 0);
  signal pixel_depth : u_unsigned(15 downto 0);
  signal all_sent : boolean := false;

begin

  clk <= not clk after 5 ns;
  reset <= '0' after 25 ns;

  core_inst : entity quadshade.raster_core
    port map (
      clk => clk, reset => reset,
      setup_valid => setup_valid, setup_ready => setup_ready, setup_data => setup_data,
      pixel_valid => pixel_valid, pixel_ready => pixel_ready, pixel_last => pixel_last,
      pixel_x => pixel_x, pixel_y => pixel_y, pixel_value => pixel_value, pixel_depth => pixel_depth,
      idle => idle
    );

  send : process
    file words : text;
    variable row : line;
    variable word : std_ulogic_vector(31 downto 0);
  begin
    file_open(words, words_file, read_mode);
    wait until reset = '0';
    while not endfile(words) loop
      readline(words, row);
      hread(row, word);
      setup_data <= word;
      setup_valid <= '1';
      wait until rising_edge(clk) and setup_ready = '1';
    end loop;
    setup_valid <= '0';
    all_sent <= true;
    wait;
  end process;

  -- Ready in two of three clocks.
  take : process
  begin
    pixel_ready <= '1';
    wait until rising_edge(clk);
    wait until rising_edge(clk);
    pixel_ready <= '0';
    wait until rising_edge(clk);
  end process;

  compare : process
    file pixels : text;
    variable row : line;
    variable comma : character;
    -- packet, x, y, three colours, depth, last
    type columns_t is array (0 to 7) of integer;
    variable expected, got : columns_t;
    variable count : natural := 0;
  begin
    file_open(pixels, pixels_file, read_mode);
    readline(pixels, row);
    while not endfile(pixels) loop
      readline(pixels, row);
      for index in expected'range loop
        read(row, expected(index));
        if index < expected'high then
          read(row, comma);
        end if;
      end loop;
      wait until rising_edge(clk) and pixel_valid = '1' and pixel_ready = '1';
      got := (
        expected(0), to_integer(pixel_x), to_integer(pixel_y), to_integer(pixel_value(7 downto 0)),
        to_integer(pixel_value(15 downto 8)), to_integer(pixel_value(23 downto 16)),
        to_integer(pixel_depth), 0
      );
      if pixel_last = '1' then
        got(7) := 1;
      end if;
      assert got = expected
        report "pixel " & integer'image(count) & " is wrong"
        severity failure;
      count := count + 1;
    end loop;
    -- Nothing may be left over.
    for clocks in 1 to 100 loop
      wait until rising_edge(clk);
    end loop;
    assert all_sent and idle = '1' and pixel_valid = '0'
      report "the core has not ended"
      severity failure;
    report integer'image(count) & " pixels are equal";
    finish;
  end process;

end architecture;
