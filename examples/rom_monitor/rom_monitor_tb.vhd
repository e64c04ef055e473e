-- SPDX-License-Identifier: Apache-2.0
--
-- A monitor at rom_monitor's pins: it finds the frame by its pulses, decodes the words of TMDS and writes the
-- first whole frame after the picture is done as monitor.ppm, as large as the signal says.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use std.env.all;

entity rom_monitor_tb is
  generic (
    columns : positive := 640;
    lines : positive := 480;
    picture_file : string := "monitor.ppm"
  );
end entity;

architecture sim of rom_monitor_tb is

  constant most_pixels : positive := 2048 * 2048;

  subtype word_t is std_ulogic_vector(9 downto 0);
  subtype byte_t is natural range 0 to 255;
  -- Blue with the pulses, green, red.
  type words_t is array (0 to 2) of word_t;

  signal clk : std_ulogic := '0';
  signal reset : std_ulogic := '1';
  signal done, video_next : std_ulogic;
  signal video_words : std_ulogic_vector(29 downto 0);

  function is_control(word : word_t) return boolean is
  begin
    return word = "1101010100" or word = "0010101011" or word = "0101010100" or word = "1010101011";
  end function;

  -- In a control word of blue: the lines' pulse, which is low.
  function lines_pulse(word : word_t) return boolean is
  begin
    return word = "1101010100" or word = "0010101011";
  end function;

  -- Digital Visual Interface, revision 1.0, figure 3-6.
  function decoded(word : word_t) return byte_t is
    variable bits, value : std_ulogic_vector(7 downto 0);
  begin
    bits := word(7 downto 0) xor (7 downto 0 => word(9));
    value(0) := bits(0);
    for index in 1 to 7 loop
      value(index) := bits(index) xor bits(index - 1) xor not word(8);
    end loop;
    return to_integer(unsigned(value));
  end function;

begin

  clk <= not clk after 20 ns;
  reset <= '0' after 90 ns;

  rom_monitor_inst : entity work.rom_monitor
    generic map (columns => columns, lines => lines)
    port map (
      clk => clk, reset => reset, done => done, video_next => video_next, video_words => video_words
    );

  monitor : process
    type file_t is file of character;
    file picture : file_t;
    type picture_t is array (0 to 3 * most_pixels - 1) of character;
    type picture_pointer_t is access picture_t;
    variable bytes : picture_pointer_t := new picture_t;
    variable count, shown_lines : natural := 0;
    variable pulse, was_pulse, active, was_active, recording : boolean := false;
    variable words : words_t;

    procedure write_text(text : string) is
    begin
      for index in text'range loop
        write(picture, text(index));
      end loop;
    end procedure;
  begin
    wait until rising_edge(clk) and reset = '0' and video_next = '1';
    loop
      wait until rising_edge(clk);
      for channel in words'range loop
        words(channel) := video_words(10 * channel + 9 downto 10 * channel);
      end loop;
      active := not is_control(words(0));
      pulse := lines_pulse(words(0));
      if pulse and not was_pulse then
        exit when recording;
        recording := done = '1';
      end if;
      if recording and active then
        for channel in words'reverse_range loop
          assert not is_control(words(channel)) report "a channel does not show" severity failure;
          bytes(count) := character'val(decoded(words(channel)));
          count := count + 1;
        end loop;
        if not was_active then
          shown_lines := shown_lines + 1;
        end if;
      end if;
      was_pulse := pulse;
      was_active := active;
    end loop;

    file_open(picture, picture_file, write_mode);
    write_text("P6" & LF & integer'image(count / 3 / shown_lines) & " " & integer'image(shown_lines)
      & LF & "255" & LF);
    for index in 0 to count - 1 loop
      write(picture, bytes(index));
    end loop;
    file_close(picture);
    report "a frame of " & integer'image(count / 3) & " pixels";
    stop;
    wait;
  end process;

end architecture;
