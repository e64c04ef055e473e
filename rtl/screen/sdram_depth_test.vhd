-- SPDX-License-Identifier: Apache-2.0
--
-- A z-buffer and a picture in an SDRAM: pixels become runs of sdram_controller's second port. Neighbours on
-- a scanline are gathered, up to run_words between multiples of it; then their depths are read, and depths
-- and values of those that are nearer are written, while the next ones are gathered. A word of a depth has
-- one bit more, which is set where nothing was drawn. A fill writes both planes.
--
-- Model: sdram_depth_test.py.  Test: test_sdram_depth_test.py.  Latency: that of three runs.
-- Throughput: a pixel per cycle into a span, three runs a span.
-- Depth in block RAM by bands was calculated first: triangles that the host cuts cost 1.5 to 3 times the
-- bytes (docs/reports/sdram.md).

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity sdram_depth_test is
  generic (
    -- A multiple of run_words.
    width : positive := 640;
    height : positive := 480;
    coord_bits : positive := 12;
    value_bits : positive := 16;
    depth_bits : positive := 15;
    data_bits : positive := 16;
    run_words : positive := 64
  );
  port (
    clk : in std_ulogic;
    -- Starts a fill; with the controller's reset.
    reset : in std_ulogic;
    -- The plane of values that is drawn and filled, 0 or 1; it changes only while idle.
    plane : in std_ulogic;
    -- Everything is in the memory, nothing is filled.
    idle : out std_ulogic;

    -- A pixel that comes with it is drawn after it.
    clear_valid : in std_ulogic;
    clear_ready : out std_ulogic;
    clear_value : in u_unsigned(value_bits - 1 downto 0);

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    pixel_x : in u_unsigned(coord_bits - 1 downto 0);
    pixel_y : in u_unsigned(coord_bits - 1 downto 0);
    pixel_value : in u_unsigned(value_bits - 1 downto 0);
    pixel_depth : in u_unsigned(depth_bits - 1 downto 0);

    -- Of sdram_controller's second port; an address is plane (2: depth), y, x.
    run_valid : out std_ulogic;
    run_ready : in std_ulogic;
    run_write : out std_ulogic;
    run_address : out u_unsigned(1 + address_bits(height) + address_bits(width) downto 0);
    run_more : out u_unsigned(address_bits(run_words) - 1 downto 0);
    read_valid : in std_ulogic;
    read_data : in std_ulogic_vector(data_bits - 1 downto 0);
    write_next : in std_ulogic;
    write_keep : out std_ulogic;
    write_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of sdram_depth_test is

  constant x_bits : positive := address_bits(width);
  constant y_bits : positive := address_bits(height);
  constant index_bits : positive := address_bits(run_words);
  constant word_bits : positive := value_bits + depth_bits;
  constant last_block : natural := width / run_words - 1;

  subtype index_t is u_unsigned(index_bits - 1 downto 0);
  subtype block_t is u_unsigned(x_bits - index_bits - 1 downto 0);
  subtype line_t is u_unsigned(y_bits - 1 downto 0);

  -- A pixel, and whether it is on the screen.
  signal valid_1, inside_1 : std_ulogic := '0';
  signal index_1 : index_t := (others => '0');
  signal block_1 : block_t := (others => '0');
  signal line_1 : line_t := (others => '0');
  signal word_1 : std_ulogic_vector(word_bits - 1 downto 0) := (others => '0');
  signal joins, taken, stored, gives : std_ulogic;

  -- Pixels that are gathered, in one side of the buffer.
  signal gathering, side : std_ulogic := '0';
  signal low, high : index_t := (others => '0');
  signal block_2 : block_t := (others => '0');
  signal line_2 : line_t := (others => '0');

  -- What is moved of the other side: what nears are, depths, values; of a fill the last two.
  type place_t is (rests, loads, asks, moves);
  signal place : place_t := asks;
  signal filling : std_ulogic := '1';
  signal compares : std_ulogic := '0';
  signal values : std_ulogic := '0';
  signal second_load : std_ulogic := '0';
  signal moved_side : std_ulogic := '0';
  signal moved_block : block_t := (others => '0');
  signal moved_line : line_t := (others => '0');
  signal moved_low : index_t := (others => '0');
  signal moved_more : index_t := (others => '1');
  signal left : index_t := (others => '1');
  signal fill_value : u_unsigned(value_bits - 1 downto 0) := (others => '0');
  -- Whether each pixel of the run is nearer, the newest first: a ring of as many as there are in the run.
  signal nears : std_ulogic_vector(0 to run_words - 1) := (others => '0');
  signal some : std_ulogic := '0';
  signal near, oldest, steps, last, fetches, free : std_ulogic;

  -- A clock before it is read at the earliest.
  signal stores : std_ulogic := '0';
  signal put_address : u_unsigned(index_bits downto 0) := (others => '0');
  signal put_word : std_ulogic_vector(word_bits - 1 downto 0) := (others => '0');
  signal get_address : u_unsigned(index_bits downto 0);
  signal got : index_t := (others => '0');
  signal word : std_ulogic_vector(word_bits - 1 downto 0);
  signal depth_word : u_unsigned(depth_bits downto 0);

begin

  assert width mod run_words = 0 and 2**index_bits = run_words and width > run_words
    report "sdram_depth_test: width is " & integer'image(width) & ", must be more than one run of "
      & integer'image(run_words) & " words, a power of two"
    severity failure;
  assert data_bits >= value_bits and data_bits > depth_bits
    report "sdram_depth_test: data_bits is " & integer'image(data_bits) & ", a value has "
      & integer'image(value_bits) & ", a depth " & integer'image(depth_bits + 1)
    severity failure;
  assert coord_bits >= x_bits and coord_bits >= y_bits
    report "sdram_depth_test: coord_bits is " & integer'image(coord_bits) & ", too few for the screen"
    severity failure;

  -- The next pixel stands beside those that are gathered, on either side.
  joins <= '1' when line_1 = line_2 and block_1 = block_2
    and (('0' & index_1) = ('0' & high) + 1 or ('0' & low) = ('0' & index_1) + 1) else '0';
  free <= '1' when place = rests else '0';
  -- What is gathered is moved once nothing more comes to it.
  gives <= gathering and free and not (valid_1 and inside_1 and joins);
  taken <= valid_1 and (not inside_1 or ((not gathering or joins or free) and not filling));
  stored <= taken and inside_1;
  pixel_ready <= not valid_1 or taken;

  gather : process (clk)
  begin
    if rising_edge(clk) then
      stores <= stored;
      put_address <= (side xor gives) & index_1;
      put_word <= word_1;
      if gives = '1' then
        gathering <= '0';
        side <= not side;
      end if;
      if stored = '1' then
        gathering <= '1';
        if gathering = '1' and joins = '1' then
          if index_1 > high then
            high <= index_1;
          else
            low <= index_1;
          end if;
        else
          low <= index_1;
          high <= index_1;
          block_2 <= block_1;
          line_2 <= line_1;
        end if;
      end if;
      if valid_1 = '0' or taken = '1' then
        valid_1 <= pixel_valid;
        inside_1 <= '0';
        if resize(pixel_x, coord_bits + 1) < to_unsigned(width, coord_bits + 1)
          and resize(pixel_y, coord_bits + 1) < to_unsigned(height, coord_bits + 1) then
          inside_1 <= '1';
        end if;
        index_1 <= pixel_x(index_bits - 1 downto 0);
        block_1 <= pixel_x(x_bits - 1 downto index_bits);
        line_1 <= pixel_y(y_bits - 1 downto 0);
        word_1 <= std_ulogic_vector(pixel_value & pixel_depth);
      end if;
      if reset = '1' then
        valid_1 <= '0';
        gathering <= '0';
        side <= '0';
      end if;
    end if;
  end process;

  get_address <= moved_side & got;

  buffer_inst : entity work.block_ram
    generic map (num_words => 2 * run_words, data_bits => word_bits)
    port map (
      clk => clk,
      write_enable => stores, write_address => put_address, write_data => put_word,
      read_enable => fetches, read_address => get_address, read_data => word
    );

  depth_word <= '0' & unsigned(word(depth_bits - 1 downto 0));
  near <= '1' when depth_word < unsigned(read_data(depth_bits downto 0)) else '0';
  oldest <= nears(to_integer(moved_more));
  steps <= read_valid when compares = '1' else write_next;
  last <= '1' when left = 0 else '0';
  fetches <= '1' when place = loads or (place = moves and steps = '1') else '0';

  move : process (clk)
  begin
    if rising_edge(clk) then
      if fetches = '1' then
        got <= got + 1;
      end if;
      if place = rests then
        moved_side <= side;
        moved_block <= block_2;
        moved_line <= line_2;
        moved_low <= low;
        moved_more <= high - low;
        left <= high - low;
        got <= low;
        compares <= '1';
        values <= '0';
        second_load <= '0';
        some <= '0';
        fill_value <= clear_value;
        if gives = '1' then
          place <= loads;
        elsif clear_valid = '1' and clear_ready = '1' then
          filling <= '1';
          compares <= '0';
          moved_block <= (others => '0');
          moved_line <= (others => '0');
          moved_low <= (others => '0');
          moved_more <= (others => '1');
          left <= (others => '1');
          place <= asks;
        end if;
      elsif place = loads then
        second_load <= '1';
        if second_load = '1' then
          place <= asks;
        end if;
      elsif place = asks then
        if run_ready = '1' then
          place <= moves;
        end if;
      elsif steps = '1' then
        left <= left - 1;
        if compares = '1' then
          nears <= near & nears(0 to run_words - 2);
          some <= some or near;
        else
          nears <= oldest & nears(0 to run_words - 2);
        end if;
        if last = '1' then
          left <= moved_more;
          got <= moved_low;
          second_load <= '0';
          compares <= '0';
          place <= loads;
          if compares = '1' then
            -- Of none that is nearer nothing is written.
            if some = '0' and near = '0' then
              place <= rests;
            end if;
          elsif values = '0' then
            values <= '1';
          elsif filling = '0' then
            place <= rests;
          else
            values <= '0';
            moved_block <= moved_block + 1;
            if moved_block = last_block then
              moved_block <= (others => '0');
              moved_line <= moved_line + 1;
              if moved_line = height - 1 then
                filling <= '0';
                place <= rests;
              end if;
            end if;
          end if;
        end if;
      end if;
      if reset = '1' then
        place <= asks;
        filling <= '1';
        compares <= '0';
        values <= '0';
        fill_value <= clear_value;
        moved_block <= (others => '0');
        moved_line <= (others => '0');
        moved_low <= (others => '0');
        moved_more <= (others => '1');
        left <= (others => '1');
      end if;
    end if;
  end process;

  run_valid <= '1' when place = asks else '0';
  run_write <= not compares;
  run_address <= (not values) & (values and plane) & moved_line & moved_block & moved_low;
  run_more <= moved_more;
  write_keep <= not (oldest or filling);

  words : process (all)
  begin
    if values = '0' then
      write_data <= std_ulogic_vector(resize(depth_word, data_bits));
      if filling = '1' then
        write_data <= (others => '1');
      end if;
    else
      write_data <= std_ulogic_vector(resize(unsigned(word(word_bits - 1 downto depth_bits)), data_bits));
      if filling = '1' then
        write_data <= std_ulogic_vector(resize(fill_value, data_bits));
      end if;
    end if;
  end process;

  idle <= free and not (gathering or valid_1);
  clear_ready <= idle;

end architecture;
