-- SPDX-License-Identifier: Apache-2.0
--
-- Starts the painter, waits until it is done, and writes its memory as a picture that viewers open (PPM).

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use std.env.all;
use std.textio.all;

use work.picture_pkg.all;

entity painter_tb is
  generic (picture_file : string);
end entity;

architecture sim of painter_tb is

  signal clk : std_ulogic := '0';
  signal reset : std_ulogic := '1';
  signal start, done : std_ulogic := '0';
  signal read_address : natural range 0 to screen_width * screen_height - 1 := 0;
  signal read_colour : std_ulogic_vector(23 downto 0);

begin

  clk <= not clk after 5 ns;

  painter_inst : entity work.painter
    port map (
      clk => clk, reset => reset, start => start, done => done,
      read_address => read_address, read_colour => read_colour
    );

  stimulus : process
    file picture : text open write_mode is picture_file;
    variable row : line;
    variable cycles : natural := 0;
  begin
    wait until rising_edge(clk);
    reset <= '0';
    start <= '1';
    wait until rising_edge(clk);
    start <= '0';
    wait until rising_edge(clk);
    while done = '0' loop
      wait until rising_edge(clk);
      cycles := cycles + 1;
    end loop;
    report "painted in " & integer'image(cycles) & " cycles";

    write(row, "P3 " & integer'image(screen_width) & " " & integer'image(screen_height) & " 255");
    writeline(picture, row);
    for address in 0 to screen_width * screen_height - 1 loop
      read_address <= address;
      wait until rising_edge(clk);
      wait until rising_edge(clk);
      for colour in 2 downto 0 loop
        write(row, to_integer(unsigned(read_colour(8 * colour + 7 downto 8 * colour))));
        write(row, ' ');
      end loop;
      writeline(picture, row);
    end loop;
    finish;
  end process;

end architecture;
