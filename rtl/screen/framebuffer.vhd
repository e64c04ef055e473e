-- SPDX-License-Identifier: Apache-2.0
--
-- The picture: a pixel's value is kept at its place until the next one there, or until a clear to a colour. A
-- pixel outside the screen is dropped. A port of its own reads by address, y * width + x. Colours may be kept
-- in fewer bits, dithered. Of two buffers one is drawn and read, the other shown through a port of its own.
--
-- Model: framebuffer.py.  Test: test_framebuffer.py.
-- Latency: 3 cycles from a pixel to the first read of it; 5 enabled cycles from an address to its value, 2
-- with single_port.  One pixel in and one out per cycle.  Clear: width * height + 1 cycles once the pixels
-- ahead are written.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;
use work.screen_pkg.all;

entity framebuffer is
  generic (
    width : positive := 320;
    height : positive := 240;
    coord_bits : positive := 12;
    value_bits : positive := 24;
    -- 1: a memory of one port. What is read in a cycle of any pixel's writing is undefined then.
    single_port : natural := 0;
    -- 2: one is drawn while the other is shown.
    buffers : positive := 1;
    -- 8, or of a value of whole bytes 6 (channel 1 five), 5 (channel 1 six) or 4: see screen_pkg.
    colour_bits : positive := 8;
    -- Of block_ram.
    bank_words : positive := 16384
  );
  port (
    clk : in std_ulogic;
    -- Starts a clear too, to the value that stands there, of both buffers.
    reset : in std_ulogic;

    -- Taken, with its value, in any cycle without busy; a pixel accepted in that cycle is still before it.
    clear : in std_ulogic;
    clear_value : in u_unsigned(value_bits - 1 downto 0);
    busy : out std_ulogic;
    -- No pixel is on its way, no clear in progress.
    idle : out std_ulogic;
    -- Taken in a cycle with idle: the buffer that is shown becomes the one that is drawn and read. A pixel or
    -- a clear of that cycle is behind it.
    swap : in std_ulogic := '0';

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    pixel_x : in u_unsigned(coord_bits - 1 downto 0);
    pixel_y : in u_unsigned(coord_bits - 1 downto 0);
    pixel_value : in u_unsigned(value_bits - 1 downto 0);

    read_enable : in std_ulogic;
    -- Below width * height. What is read in the cycle of its writing is undefined.
    read_address : in u_unsigned(address_bits(width * height) - 1 downto 0);
    read_value : out u_unsigned(value_bits - 1 downto 0);

    -- Of the buffer that is shown, in every cycle. With one buffer there is none.
    show_address : in u_unsigned(address_bits(width * height) - 1 downto 0) := (others => '0');
    show_value : out u_unsigned(value_bits - 1 downto 0)
  );
end entity;

architecture rtl of framebuffer is

  constant num_words : positive := width * height;
  constant address_width : positive := address_bits(num_words);
  constant data_bits : positive := kept_bits(value_bits, colour_bits);
  -- For a clear, which is one colour.
  constant half_step : u_unsigned(3 downto 0) := "1000";

  -- Numbered by stage: row of the pixel, its address.
  signal valid_1, valid_2 : std_ulogic := '0';
  signal x_1 : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  signal row_1, address_2 : u_unsigned(address_width - 1 downto 0) := (others => '0');
  signal value_1, value_2, fill_value : u_unsigned(data_bits - 1 downto 0) := (others => '0');

  signal closed, filling, emptied, accept, on_screen, write_enable : std_ulogic;
  signal fill_address, write_address : u_unsigned(address_width - 1 downto 0);
  signal write_data, read_data : std_ulogic_vector(data_bits - 1 downto 0);

begin

  assert width <= 2**coord_bits and height <= 2**coord_bits
    report "framebuffer: the screen is " & integer'image(width) & " by " & integer'image(height)
      & ", coord_bits = " & integer'image(coord_bits) & " allow " & integer'image(2**coord_bits)
    severity failure;
  assert buffers = 1 or (buffers = 2 and single_port = 0)
    report "framebuffer: buffers is " & integer'image(buffers) & ", must be 1, or 2 with two ports"
    severity failure;
  assert colour_bits = 8 or (colour_bits >= 4 and colour_bits <= 6 and value_bits mod 8 = 0)
    report "framebuffer: colour_bits is " & integer'image(colour_bits)
      & ", must be 8, or 4 to 6 of whole bytes"
    severity failure;

  accept <= pixel_valid and not closed;
  on_screen <= '1' when resize(pixel_x, coord_bits + 1) < to_unsigned(width, coord_bits + 1)
    and resize(pixel_y, coord_bits + 1) < to_unsigned(height, coord_bits + 1) else '0';

  pipeline : process (clk)
  begin
    if rising_edge(clk) then
      valid_1 <= accept and on_screen;
      row_1 <= row_address(pixel_y, width, address_width);
      x_1 <= pixel_x;
      value_1 <= dithered(pixel_value, threshold(pixel_x, pixel_y), colour_bits);
      valid_2 <= valid_1;
      -- What is not on the screen never becomes an address.
      if valid_1 = '1' then
        address_2 <= row_1 + resize(x_1, address_width);
      end if;
      value_2 <= value_1;
      if closed = '0' or reset = '1' then
        fill_value <= dithered(clear_value, half_step, colour_bits);
      end if;
      if reset = '1' then
        valid_1 <= '0';
        valid_2 <= '0';
      end if;
    end if;
  end process;

  emptied <= not (valid_1 or valid_2);

  clear_inst : entity work.memory_clear
    generic map (num_words => num_words)
    port map (
      clk => clk, reset => reset, clear => clear, emptied => emptied,
      busy => closed, drained => open, filling => filling, fill_address => fill_address
    );

  busy <= closed;
  idle <= emptied and not closed;
  pixel_ready <= not closed;

  write_enable <= valid_2 or filling;
  write_address <= fill_address when filling = '1' else address_2;
  write_data <= std_ulogic_vector(fill_value) when filling = '1' else std_ulogic_vector(value_2);

  two_ports_gen : if single_port = 0 and buffers = 1 generate
    memory_inst : entity work.block_ram
      generic map (
        num_words => num_words, data_bits => data_bits, bank_words => bank_words, read_stages => 5
      )
      port map (
        clk => clk,
        write_enable => write_enable, write_address => write_address, write_data => write_data,
        read_enable => read_enable, read_address => read_address, read_data => read_data
      );
  end generate;

  one_port_gen : if single_port = 1 generate
    memory_inst : entity work.single_port_ram
      generic map (num_words => num_words, data_bits => data_bits)
      port map (
        clk => clk,
        write_enable => write_enable, write_address => write_address, write_data => write_data,
        read_enable => read_enable, read_address => read_address, read_data => read_data
      );
  end generate;

  single_gen : if buffers = 1 generate
    show_value <= (others => '0');
  end generate;

  double_gen : if buffers = 2 generate
    type data_t is array (0 to 1) of std_ulogic_vector(data_bits - 1 downto 0);
    signal data : data_t;
    -- The buffer that is shown; a reset's fill is of both.
    signal shown : std_ulogic := '0';
    signal fill_both : std_ulogic := '1';
    signal show_data : std_ulogic_vector(data_bits - 1 downto 0);
  begin
    roles : process (clk)
    begin
      if rising_edge(clk) then
        shown <= shown xor swap;
        fill_both <= fill_both and filling;
        if reset = '1' then
          shown <= '0';
          fill_both <= '1';
        end if;
      end if;
    end process;

    buffer_gen : for index in 0 to 1 generate
      signal shows, writes, reads : std_ulogic;
      signal address : u_unsigned(address_width - 1 downto 0);
    begin
      shows <= shown when index = 1 else not shown;
      writes <= write_enable and (fill_both or not shows);
      reads <= read_enable or shows;
      address <= show_address when shows = '1' else read_address;

      memory_inst : entity work.block_ram
        generic map (
          num_words => num_words, data_bits => data_bits, bank_words => bank_words, read_stages => 5
        )
        port map (
          clk => clk,
          write_enable => writes, write_address => write_address, write_data => write_data,
          read_enable => reads, read_address => address, read_data => data(index)
        );
    end generate;

    read_data <= data(0) when shown = '1' else data(1);
    show_data <= data(1) when shown = '1' else data(0);
    show_value <= expanded(unsigned(show_data), value_bits, colour_bits);
  end generate;

  read_value <= expanded(unsigned(read_data), value_bits, colour_bits);

end architecture;
