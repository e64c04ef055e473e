-- SPDX-License-Identifier: Apache-2.0
--
-- Reads an area of a plane in an SDRAM in scanline order: runs of sdram_controller's second port, each up to
-- the next multiple of run_words or to the end of the area's scanline, and then their words one by one. It
-- goes on to the last scanline, or until it is stopped; words that are on their way then are forgotten.
--
-- Model: sdram_read_out.py.  Test: test_sdram_read_out.py.
-- Latency: that of a run and 4 cycles.  A word in three cycles, beside the runs.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity sdram_read_out is
  generic (
    -- A multiple of run_words.
    width : positive := 640;
    height : positive := 480;
    coord_bits : positive := 12;
    data_bits : positive := 16;
    run_words : positive := 64
  );
  port (
    clk : in std_ulogic;
    -- With the controller's reset.
    reset : in std_ulogic;
    -- Ends the area.
    stop : in std_ulogic;
    -- No area is read, and no word is on its way.
    idle : out std_ulogic;

    -- Taken while idle. An area within the screen.
    area_valid : in std_ulogic;
    area_x : in u_unsigned(coord_bits - 1 downto 0);
    area_y : in u_unsigned(coord_bits - 1 downto 0);
    area_width : in u_unsigned(coord_bits downto 0);
    area_plane : in u_unsigned(1 downto 0);

    -- Of sdram_controller's second port; an address is plane, y, x.
    run_valid : out std_ulogic;
    run_ready : in std_ulogic;
    run_address : out u_unsigned(1 + address_bits(height) + address_bits(width) downto 0);
    run_more : out u_unsigned(address_bits(run_words) - 1 downto 0);
    read_valid : in std_ulogic;
    read_data : in std_ulogic_vector(data_bits - 1 downto 0);

    word_valid : out std_ulogic;
    word_ready : in std_ulogic;
    word_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of sdram_read_out is

  constant x_bits : positive := address_bits(width);
  constant y_bits : positive := address_bits(height);
  constant index_bits : positive := address_bits(run_words);

  subtype index_t is u_unsigned(index_bits - 1 downto 0);
  subtype column_t is u_unsigned(x_bits - 1 downto 0);

  type place_t is (rests, asks, reads, shows);
  signal place : place_t := rests;
  signal stopped : std_ulogic := '0';
  signal plane : u_unsigned(1 downto 0) := (others => '0');
  signal row : u_unsigned(y_bits - 1 downto 0) := (others => '0');
  -- The run's first column; the area's first one, and its columns but one; those left behind the first.
  signal x, first_x, columns, left : column_t := (others => '0');
  -- Words of the run but one; where the next one is put, or which is shown.
  signal more, index : index_t := (others => '0');
  -- The memory's registers are moved so often before a word is shown.
  signal moves : natural range 0 to 2 := 0;
  signal fetches, shown : std_ulogic;

begin

  assert width mod run_words = 0 and 2**index_bits = run_words and width > run_words
    report "sdram_read_out: width is " & integer'image(width) & ", must be more than one run of "
      & integer'image(run_words) & " words, a power of two"
    severity failure;

  -- Of what is left of the scanline, at most up to the multiple.
  more <= not x(index_bits - 1 downto 0)
    when resize(not x(index_bits - 1 downto 0), x_bits) < left else left(index_bits - 1 downto 0);

  walk : process (clk)
  begin
    if rising_edge(clk) then
      if place = rests then
        stopped <= '0';
        plane <= area_plane;
        row <= resize(area_y, y_bits);
        x <= resize(area_x, x_bits);
        first_x <= resize(area_x, x_bits);
        columns <= resize(area_width - 1, x_bits);
        left <= resize(area_width - 1, x_bits);
        index <= (others => '0');
        if area_valid = '1' and stop = '0' then
          place <= asks;
        end if;
      elsif place = asks then
        if run_ready = '1' then
          place <= reads;
        elsif stop = '1' then
          place <= rests;
        end if;
      elsif place = reads then
        moves <= 0;
        if read_valid = '1' then
          index <= index + 1;
          if index = more then
            index <= (others => '0');
            place <= shows;
            if stopped = '1' or stop = '1' then
              place <= rests;
            end if;
          end if;
        end if;
      else
        if shown = '0' then
          moves <= moves + 1;
        elsif word_ready = '1' then
          moves <= 0;
          index <= index + 1;
          if index = more then
            index <= (others => '0');
            place <= asks;
            x <= x + resize(more, x_bits) + 1;
            left <= left - resize(more, x_bits) - 1;
            if left = resize(more, x_bits) then
              x <= first_x;
              left <= columns;
              row <= row + 1;
              if row = height - 1 then
                place <= rests;
              end if;
            end if;
          end if;
        end if;
        if stop = '1' then
          place <= rests;
        end if;
      end if;
      if stop = '1' then
        stopped <= '1';
      end if;
      if reset = '1' then
        place <= rests;
      end if;
    end if;
  end process;

  idle <= '1' when place = rests else '0';
  run_valid <= '1' when place = asks else '0';
  run_address <= plane & row & x;
  run_more <= more;

  shown <= '1' when moves = 2 else '0';
  fetches <= not shown;

  words_inst : entity work.block_ram
    generic map (num_words => run_words, data_bits => data_bits)
    port map (
      clk => clk,
      write_enable => read_valid, write_address => index, write_data => read_data,
      read_enable => fetches, read_address => index, read_data => word_data
    );

  word_valid <= shown when place = shows else '0';

end architecture;
