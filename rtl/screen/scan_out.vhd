-- SPDX-License-Identifier: Apache-2.0
--
-- The picture on a monitor: words of three TMDS data channels, pixel after pixel of 640 x 480, every pixel of
-- the framebuffer as a square of them. A scanline is fetched while the one above it is shown, in a burst of a
-- clock a pixel; while the framebuffer is read by others nothing is, and that scanline is black. What a swap
-- of two buffers waits for is said too: the vertical blank, in which nothing is fetched. With read_stages = 0
-- nobody is asked by address: a scanline's values come one by one, and it is black if they come too late,
-- those of the last one even in the vertical blank.
--
-- Model: scan_out.py.  Test: test_scan_out.py.
-- Latency: a scanline and 7 pixels.  A pixel per clocks_per_pixel cycles.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity scan_out is
  generic (
    width : positive := 320;
    height : positive := 240;
    -- A channel is a byte: red, green, blue, or grey.
    num_channels : positive := 3;
    -- Enabled cycles from an address to its value; 0: may_read says that the next value is there.
    read_stages : natural := 5;
    clocks_per_pixel : positive := 4;
    -- What is shown, then a rest, the pulse, a rest.
    columns : positive := 640;
    column_front : positive := 16;
    column_sync : positive := 96;
    column_back : positive := 48;
    lines : positive := 480;
    line_front : positive := 10;
    line_sync : positive := 2;
    line_back : positive := 33
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    -- The memory is free. A clock with `reads` asks it for the address, whose value follows.
    may_read : in std_ulogic;
    -- Below the last scanline, until the next frame's first one is fetched.
    blank : out std_ulogic := '0';
    reads : out std_ulogic;
    read_address : out u_unsigned(address_bits(width * height) - 1 downto 0);
    read_value : in u_unsigned(8 * num_channels - 1 downto 0);
    -- The next scanline's values are wanted from now on; it is the picture's first one.
    line_start : out std_ulogic;
    line_first : out std_ulogic;

    -- Blue with both pulses, green, red; new in the cycle after one with word_next.
    word_next : out std_ulogic;
    words : out std_ulogic_vector(29 downto 0)
  );
end entity;

architecture rtl of scan_out is

  constant scale : positive := columns / width;
  constant all_columns : positive := columns + column_front + column_sync + column_back;
  constant all_lines : positive := lines + line_front + line_sync + line_back;
  constant value_bits : positive := 8 * num_channels;
  constant address_width : positive := address_bits(width * height);
  constant index_bits : positive := address_bits(width);
  constant place_bits : positive := address_bits(2 * width);

  subtype index_t is u_unsigned(index_bits - 1 downto 0);
  subtype place_t is u_unsigned(place_bits - 1 downto 0);
  type indices_t is array (1 to read_stages + 1) of index_t;

  signal pixel_clocks : natural range 0 to clocks_per_pixel - 1 := 0;
  signal step : std_ulogic := '0';

  -- What is shown: column and line, and within a square of the picture's pixel.
  signal column : natural range 0 to all_columns - 1 := 0;
  signal line : natural range 0 to all_lines - 1 := 0;
  signal square_column, square_line : natural range 0 to scale - 1 := 0;
  -- The line buffer that is shown, and the place of the pixel in both.
  signal shown : std_ulogic := '0';
  signal shown_place : place_t := (others => '0');
  signal visible : std_ulogic;
  -- Of the last pixels: the line buffer's two registers.
  signal actives, columns_pulse, lines_pulse : std_ulogic_vector(1 to 3) := (others => '0');
  signal blanks : std_ulogic_vector(1 to 3) := (others => '0');
  signal value_3 : u_unsigned(23 downto 0) := (others => '0');

  -- What is fetched, and whether all of it was, of both line buffers.
  signal starts, fetching, filled : std_ulogic := '0';
  signal begins_whole : std_ulogic;
  signal whole : std_ulogic_vector(0 to 1) := (others => '0');
  signal address : u_unsigned(address_width - 1 downto 0) := (others => '0');
  signal index : index_t := (others => '0');
  -- On their way: address, the memory's registers, one more.
  signal asked : std_ulogic_vector(1 to read_stages + 1) := (others => '0');
  signal indices : indices_t := (others => (others => '0'));
  signal fetched, line_value : std_ulogic_vector(value_bits - 1 downto 0) := (others => '0');
  signal write_place : place_t;

  function place_of(side : std_ulogic; within : index_t) return place_t is
  begin
    if side = '1' then
      return resize(within, place_bits) + to_unsigned(width, place_bits);
    end if;
    return resize(within, place_bits);
  end function;

begin

  assert columns mod width = 0 and lines = height * scale and num_channels /= 2 and num_channels <= 3
    report "scan_out: " & integer'image(width) & " by " & integer'image(height) & " pixels of "
      & integer'image(num_channels) & " channels, must fill " & integer'image(columns) & " by "
      & integer'image(lines) & " as squares, of 1 or 3"
    severity failure;

  positions : process (clk)
  begin
    if rising_edge(clk) then
      starts <= '0';
      step <= '0';
      blank <= '0';
      if line >= lines and line /= all_lines - 1 then
        blank <= '1';
      end if;
      if pixel_clocks = clocks_per_pixel - 1 then
        pixel_clocks <= 0;
        step <= '1';
      else
        pixel_clocks <= pixel_clocks + 1;
      end if;
      if step = '1' then
        if column /= all_columns - 1 then
          column <= column + 1;
          if square_column /= scale - 1 then
            square_column <= square_column + 1;
          else
            square_column <= 0;
            if column < columns - 1 then
              shown_place <= shown_place + 1;
            end if;
          end if;
        else
          column <= 0;
          square_column <= 0;
          if line = all_lines - 1 then
            line <= 0;
            square_line <= 0;
            shown <= '0';
            shown_place <= (others => '0');
          else
            line <= line + 1;
            if square_line /= scale - 1 then
              square_line <= square_line + 1;
              shown_place <= place_of(shown, (others => '0'));
            else
              square_line <= 0;
              shown <= not shown;
              shown_place <= place_of(not shown, (others => '0'));
            end if;
          end if;
        end if;
        -- Scanline 0 during the last line, the others while the one above each is shown.
        if column = 0 and (line = all_lines - 1 or (line < lines - scale and square_line = 0)) then
          starts <= '1';
        end if;
      end if;
      if reset = '1' then
        starts <= '0';
        blank <= '0';
        column <= 0;
        line <= 0;
        square_column <= 0;
        square_line <= 0;
        shown <= '0';
        shown_place <= (others => '0');
      end if;
    end if;
  end process;

  begins_whole <= '1' when read_stages /= 0 else '0';

  fetch : process (clk)
  begin
    if rising_edge(clk) then
      asked <= (fetching and may_read) & asked(1 to read_stages);
      indices <= index & indices(1 to read_stages);
      fetched <= std_ulogic_vector(read_value);
      if fetching = '1' and (may_read = '1' or read_stages /= 0) then
        address <= address + 1;
        index <= index + 1;
        if index = width - 1 then
          fetching <= '0';
          -- Not where it is shown already.
          if read_stages = 0 and filled = '1' and shown = '0' then
            whole(1) <= '1';
          elsif read_stages = 0 and filled = '0' and (shown = '1' or line = all_lines - 1) then
            whole(0) <= '1';
          end if;
        end if;
        -- An address of the next scanline stands there even if this one is not whole.
        if may_read = '0' then
          if filled = '1' then
            whole(1) <= '0';
          else
            whole(0) <= '0';
          end if;
        end if;
      end if;
      if starts = '1' then
        fetching <= '1';
        index <= (others => '0');
        filled <= not shown;
        if line = all_lines - 1 then
          address <= (others => '0');
          filled <= '0';
          whole(0) <= begins_whole;
        elsif shown = '1' then
          whole(0) <= begins_whole;
        else
          whole(1) <= begins_whole;
        end if;
      end if;
      if reset = '1' then
        -- The first frame begins without its first scanline.
        address <= resize(to_unsigned(width, address_width + 1), address_width);
        fetching <= '0';
        whole <= (others => '0');
      end if;
    end if;
  end process;

  reads <= fetching and may_read;
  read_address <= address;
  line_start <= starts;
  line_first <= '1' when line = all_lines - 1 else '0';
  write_place <= place_of(filled, indices(read_stages + 1));

  lines_inst : entity work.block_ram
    generic map (num_words => 2 * width, data_bits => value_bits, slice_bits => 18)
    port map (
      clk => clk,
      write_enable => asked(read_stages + 1), write_address => write_place, write_data => fetched,
      read_enable => step, read_address => shown_place, read_data => line_value
    );

  visible <= '1' when column < columns and line < lines else '0';

  pixels : process (clk)
  begin
    if rising_edge(clk) then
      if step = '1' then
        actives <= visible & actives(1 to 2);
        blanks <= not whole(0) & blanks(1 to 2);
        if shown = '1' then
          blanks(1) <= not whole(1);
        end if;
        -- Both pulses are low.
        columns_pulse <= '1' & columns_pulse(1 to 2);
        if column >= columns + column_front and column < columns + column_front + column_sync then
          columns_pulse(1) <= '0';
        end if;
        lines_pulse <= '1' & lines_pulse(1 to 2);
        if line >= lines + line_front and line < lines + line_front + line_sync then
          lines_pulse(1) <= '0';
        end if;
        value_3 <= (others => '0');
        if blanks(2) = '0' then
          for channel in 0 to 2 loop
            value_3(8 * channel + 7 downto 8 * channel) <= unsigned(
              line_value(8 * (channel mod num_channels) + 7 downto 8 * (channel mod num_channels)));
          end loop;
        end if;
      end if;
      if reset = '1' then
        actives <= (others => '0');
      end if;
    end if;
  end process;

  -- Red is colour channel 0 and TMDS data channel 2.
  lane_gen : for data_channel in 0 to 2 generate
    constant channel : natural := 2 - data_channel;
    signal control : std_ulogic_vector(1 downto 0);
  begin
    blue_gen : if data_channel = 0 generate
      control <= lines_pulse(3) & columns_pulse(3);
    end generate;

    other_gen : if data_channel /= 0 generate
      control <= "00";
    end generate;

    encoder_inst : entity work.tmds_encoder
      port map (
        clk => clk, enable => step, active => actives(3),
        value => value_3(8 * channel + 7 downto 8 * channel), control => control,
        word => words(10 * data_channel + 9 downto 10 * data_channel)
      );
  end generate;

  word_next <= step;

end architecture;
