-- SPDX-License-Identifier: Apache-2.0
--
-- The picture: a pixel's value is kept at its place until the next one there, or until a clear to a colour. A
-- pixel outside the screen is dropped. A port of its own reads by address, y * width + x.
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
    single_port : natural := 0
  );
  port (
    clk : in std_ulogic;
    -- Starts a clear too, to the value that stands there.
    reset : in std_ulogic;

    -- Taken, with its value, in any cycle without busy; a pixel accepted in that cycle is still before it.
    clear : in std_ulogic;
    clear_value : in u_unsigned(value_bits - 1 downto 0);
    busy : out std_ulogic;
    -- No pixel is on its way, no clear in progress.
    idle : out std_ulogic;

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    pixel_x : in u_unsigned(coord_bits - 1 downto 0);
    pixel_y : in u_unsigned(coord_bits - 1 downto 0);
    pixel_value : in u_unsigned(value_bits - 1 downto 0);

    read_enable : in std_ulogic;
    -- Below width * height. What is read in the cycle of its writing is undefined.
    read_address : in u_unsigned(address_bits(width * height) - 1 downto 0);
    read_value : out u_unsigned(value_bits - 1 downto 0)
  );
end entity;

architecture rtl of framebuffer is

  constant num_words : positive := width * height;
  constant address_width : positive := address_bits(num_words);

  -- Numbered by stage: row of the pixel, its address.
  signal valid_1, valid_2 : std_ulogic := '0';
  signal x_1 : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  signal row_1, address_2 : u_unsigned(address_width - 1 downto 0) := (others => '0');
  signal value_1, value_2, fill_value : u_unsigned(value_bits - 1 downto 0) := (others => '0');

  signal closed, filling, emptied, accept, on_screen, write_enable : std_ulogic;
  signal fill_address, write_address : u_unsigned(address_width - 1 downto 0);
  signal write_data, read_data : std_ulogic_vector(value_bits - 1 downto 0);

begin

  assert width <= 2**coord_bits and height <= 2**coord_bits
    report "framebuffer: the screen is " & integer'image(width) & " by " & integer'image(height)
      & ", coord_bits = " & integer'image(coord_bits) & " allow " & integer'image(2**coord_bits)
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
      value_1 <= pixel_value;
      valid_2 <= valid_1;
      -- What is not on the screen never becomes an address.
      if valid_1 = '1' then
        address_2 <= row_1 + resize(x_1, address_width);
      end if;
      value_2 <= value_1;
      if closed = '0' or reset = '1' then
        fill_value <= clear_value;
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

  two_ports_gen : if single_port = 0 generate
    memory_inst : entity work.block_ram
      generic map (num_words => num_words, data_bits => value_bits, read_stages => 5)
      port map (
        clk => clk,
        write_enable => write_enable, write_address => write_address, write_data => write_data,
        read_enable => read_enable, read_address => read_address, read_data => read_data
      );
  end generate;

  one_port_gen : if single_port = 1 generate
    memory_inst : entity work.single_port_ram
      generic map (num_words => num_words, data_bits => value_bits)
      port map (
        clk => clk,
        write_enable => write_enable, write_address => write_address, write_data => write_data,
        read_enable => read_enable, read_address => read_address, read_data => read_data
      );
  end generate;

  read_value <= unsigned(read_data);

end architecture;
