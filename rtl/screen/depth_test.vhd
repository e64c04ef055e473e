-- SPDX-License-Identifier: Apache-2.0
--
-- z-buffer: a pixel is kept if it is nearer than all before it at its place since the last clear; of equally
-- near ones the first stays. A pixel outside the screen is dropped.
--
-- Model: depth_test.py.  Test: test_depth_test.py.
-- Latency: 8 cycles.  One pixel per cycle, whatever places follow each other: a pixel is compared with the
-- six ahead of it, whose depths are not yet in the memory, on its way. No pixel stands still on it, so
-- nothing stops the memory: what takes the kept ones takes one in every cycle.
-- Clear: width * height + 1 cycles once the pixels ahead have left. Generation bits that spare most fills
-- were weighed: two bits a word more, and a fill of 320 x 240 is 0.8 ms at 100 MHz, where a serial line of
-- 1 Mbaud needs half a second for a scene.  Depths are read, instead of new pixels, while it is idle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;
use work.screen_pkg.all;

entity depth_test is
  generic (
    width : positive := 320;
    height : positive := 240;
    coord_bits : positive := 12;
    value_bits : positive := 24;
    depth_bits : positive := 16;
    -- Of block_ram.
    bank_words : positive := 16384
  );
  port (
    clk : in std_ulogic;
    -- Starts a clear too.
    reset : in std_ulogic;

    -- Taken in any cycle without busy; a pixel accepted in that cycle is still before the clear.
    clear : in std_ulogic;
    busy : out std_ulogic;
    -- One cycle of busy: every kept pixel from before the clear has been taken.
    drained : out std_ulogic;

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    pixel_x : in u_unsigned(coord_bits - 1 downto 0);
    pixel_y : in u_unsigned(coord_bits - 1 downto 0);
    pixel_value : in u_unsigned(value_bits - 1 downto 0);
    pixel_depth : in u_unsigned(depth_bits - 1 downto 0);

    -- No pixel is on its way, no clear in progress.
    idle : out std_ulogic;
    -- Takes no pixels; from the cycle after one in which it is idle too, an address gives its depth, the
    -- greatest where nothing was drawn, five cycles with look_enable later.
    look : in std_ulogic;
    -- Moves all registers of the memory: high but while it is looked at.
    look_enable : in std_ulogic;
    look_address : in u_unsigned(address_bits(width * height) - 1 downto 0);
    look_depth : out u_unsigned(depth_bits - 1 downto 0);

    kept_valid : out std_ulogic;
    kept_x : out u_unsigned(coord_bits - 1 downto 0);
    kept_y : out u_unsigned(coord_bits - 1 downto 0);
    kept_value : out u_unsigned(value_bits - 1 downto 0);
    kept_depth : out u_unsigned(depth_bits - 1 downto 0)
  );
end entity;

architecture rtl of depth_test is

  constant num_words : positive := width * height;
  constant address_width : positive := address_bits(num_words);
  -- A bit above the depth marks a place where nothing was drawn: it is farther than every depth.
  constant stored_bits : positive := depth_bits + 1;
  constant pixel_bits : positive := value_bits + 2 * coord_bits;

  subtype address_t is u_unsigned(address_width - 1 downto 0);
  subtype depth_t is u_unsigned(depth_bits - 1 downto 0);
  subtype pixel_t is u_unsigned(pixel_bits - 1 downto 0);

  -- Numbered by stage: row of the pixel, its address, the memory's five registers, kept or not.
  signal valid_1, valid_2, valid_3, valid_4, valid_5, valid_6, valid_7 : std_ulogic := '0';
  signal pixel_1, pixel_2, pixel_3, pixel_4, pixel_5, pixel_6, pixel_7, pixel_8 : pixel_t := (others => '0');
  signal depth_1, depth_2, depth_3, depth_4, depth_5, depth_6, depth_7, depth_8 : depth_t := (others => '0');
  signal row_1, address_2, address_3, address_4, address_5 : address_t := (others => '0');
  signal address_6, address_7, address_8 : address_t := (others => '0');
  -- The pixel in stage 8 is kept: its depth is being written.
  signal kept_8 : std_ulogic := '0';

  -- Since the read began this was written at the pixel's place.
  signal passed_3, passed_4, passed_5, passed_6, passed_7 : std_ulogic := '0';
  signal passed_depth_3, passed_depth_4, passed_depth_5 : depth_t := (others => '0');
  signal passed_depth_6, passed_depth_7 : depth_t := (others => '0');
  -- The pixel in stage 7 has the place of the one in stage 8.
  signal same_7 : std_ulogic := '0';

  signal place : u_unsigned(2 * coord_bits - 1 downto 0);
  signal passed_now_2, passed_now_3, passed_now_4, passed_now_5, passed_now_6, nearer : std_ulogic;
  signal stored : u_unsigned(stored_bits - 1 downto 0);
  signal read_data, write_data : std_ulogic_vector(stored_bits - 1 downto 0);
  signal write_enable : std_ulogic;
  signal write_address : address_t;

  signal closed, filling : std_ulogic;
  signal fill_address : address_t;
  signal accept, on_screen, emptied : std_ulogic;
  -- A register: late in its cycle, look need not reach the memory too.
  signal looking : std_ulogic := '0';
  signal read_address : address_t;

begin

  assert width <= 2**coord_bits and height <= 2**coord_bits
    report "depth_test: the screen is " & integer'image(width) & " by " & integer'image(height)
      & ", coord_bits = " & integer'image(coord_bits) & " allow " & integer'image(2**coord_bits)
    severity failure;

  pixel_ready <= not closed and not look;
  accept <= pixel_valid and not closed and not look;
  on_screen <= '1' when resize(pixel_x, coord_bits + 1) < to_unsigned(width, coord_bits + 1)
    and resize(pixel_y, coord_bits + 1) < to_unsigned(height, coord_bits + 1) else '0';
  place <= pixel_y & pixel_x;

  addressing : process (clk)
  begin
    if rising_edge(clk) then
      row_1 <= row_address(pixel_y, width, address_width);
      -- What is not on the screen never becomes an address.
      if valid_1 = '1' then
        address_2 <= row_1 + resize(pixel_1(coord_bits - 1 downto 0), address_width);
      end if;
      address_3 <= address_2;
      address_4 <= address_3;
      address_5 <= address_4;
      address_6 <= address_5;
      address_7 <= address_6;
      address_8 <= address_7;
    end if;
  end process;

  passed_now_2 <= '1' when kept_8 = '1' and address_2 = address_8 else '0';
  passed_now_3 <= '1' when kept_8 = '1' and address_3 = address_8 else '0';
  passed_now_4 <= '1' when kept_8 = '1' and address_4 = address_8 else '0';
  passed_now_5 <= '1' when kept_8 = '1' and address_5 = address_8 else '0';
  passed_now_6 <= '1' when kept_8 = '1' and address_6 = address_8 else '0';

  hazards : process (clk)
  begin
    if rising_edge(clk) then
      passed_3 <= passed_now_2;
      passed_depth_3 <= depth_8;
      passed_4 <= passed_3 or passed_now_3;
      passed_depth_4 <= passed_depth_3;
      if passed_now_3 = '1' then
        passed_depth_4 <= depth_8;
      end if;
      passed_5 <= passed_4 or passed_now_4;
      passed_depth_5 <= passed_depth_4;
      if passed_now_4 = '1' then
        passed_depth_5 <= depth_8;
      end if;
      passed_6 <= passed_5 or passed_now_5;
      passed_depth_6 <= passed_depth_5;
      if passed_now_5 = '1' then
        passed_depth_6 <= depth_8;
      end if;
      passed_7 <= passed_6 or passed_now_6;
      passed_depth_7 <= passed_depth_6;
      if passed_now_6 = '1' then
        passed_depth_7 <= depth_8;
      end if;
      same_7 <= '0';
      if address_6 = address_7 then
        same_7 <= '1';
      end if;
    end if;
  end process;

  stored <= '0' & depth_8 when same_7 = '1' and kept_8 = '1'
    else '0' & passed_depth_7 when passed_7 = '1'
    else unsigned(read_data);
  nearer <= '1' when '0' & depth_7 < stored else '0';

  pipeline : process (clk)
  begin
    if rising_edge(clk) then
      looking <= look and emptied;
      valid_1 <= accept and on_screen;
      valid_2 <= valid_1;
      valid_3 <= valid_2;
      valid_4 <= valid_3;
      valid_5 <= valid_4;
      valid_6 <= valid_5;
      valid_7 <= valid_6;
      kept_8 <= valid_7 and nearer;
      pixel_1 <= pixel_value & place;
      pixel_2 <= pixel_1;
      pixel_3 <= pixel_2;
      pixel_4 <= pixel_3;
      pixel_5 <= pixel_4;
      pixel_6 <= pixel_5;
      pixel_7 <= pixel_6;
      pixel_8 <= pixel_7;
      depth_1 <= pixel_depth;
      depth_2 <= depth_1;
      depth_3 <= depth_2;
      depth_4 <= depth_3;
      depth_5 <= depth_4;
      depth_6 <= depth_5;
      depth_7 <= depth_6;
      depth_8 <= depth_7;
      if reset = '1' then
        valid_1 <= '0';
        valid_2 <= '0';
        valid_3 <= '0';
        valid_4 <= '0';
        valid_5 <= '0';
        valid_6 <= '0';
        valid_7 <= '0';
        kept_8 <= '0';
      end if;
    end if;
  end process;

  emptied <= not (valid_1 or valid_2 or valid_3 or valid_4 or valid_5 or valid_6 or valid_7 or kept_8);

  clear_inst : entity work.memory_clear
    generic map (num_words => num_words)
    port map (
      clk => clk, reset => reset, clear => clear, emptied => emptied,
      busy => closed, drained => drained, filling => filling, fill_address => fill_address
    );

  busy <= closed;
  idle <= emptied and not closed;
  read_address <= look_address when looking = '1' else address_2;
  look_depth <= (others => '1') when read_data(stored_bits - 1) = '1'
    else unsigned(read_data(depth_bits - 1 downto 0));

  write_enable <= kept_8 or filling;
  write_address <= fill_address when filling = '1' else address_8;
  write_data(stored_bits - 1) <= filling;
  write_data(depth_bits - 1 downto 0) <= std_ulogic_vector(depth_8);

  memory_inst : entity work.block_ram
    generic map (
      num_words => num_words, data_bits => stored_bits, bank_words => bank_words, read_stages => 5
    )
    port map (
      clk => clk,
      write_enable => write_enable, write_address => write_address, write_data => write_data,
      read_enable => look_enable, read_address => read_address, read_data => read_data
    );

  kept_valid <= kept_8;
  kept_x <= pixel_8(coord_bits - 1 downto 0);
  kept_y <= pixel_8(2 * coord_bits - 1 downto coord_bits);
  kept_value <= pixel_8(pixel_bits - 1 downto 2 * coord_bits);
  kept_depth <= depth_8;

end architecture;
