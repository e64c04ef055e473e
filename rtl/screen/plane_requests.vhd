-- SPDX-License-Identifier: Apache-2.0
--
-- Requests to read, one after the other: an area of a plane as bytes, or the CRC-32 of a whole plane. Each
-- becomes an area; its pixels come from whoever has the picture, and nothing is drawn meanwhile. Planes: 0
-- value, 1 depth, 2 and 3 edges.
--
-- Model: plane_requests.py.  Test: test_plane_requests.py.
-- Latency: 2 cycles from a request to its area.  One byte per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;
use work.memory_pkg.all;

entity plane_requests is
  generic (
    width : positive := 320;
    height : positive := 240;
    coord_bits : positive := 12;
    -- Bytes of a pixel of either plane.
    num_channels : positive := 3;
    depth_bytes : natural := 2;
    -- Of crc32.
    crc_cycles : positive := 1
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    -- Ends what is read.
    read_reset : in std_ulogic;

    -- No pixel is on its way, nothing is cleared: a request can begin.
    free : in std_ulogic;
    -- Nothing is read; a request is taken or answered; the area before is over in every unit.
    quiet : out std_ulogic;
    held : out std_ulogic;
    resting : out std_ulogic;

    read_valid : in std_ulogic;
    read_ready : out std_ulogic;
    read_x : in u_unsigned(15 downto 0);
    read_y : in u_unsigned(15 downto 0);
    read_width : in u_unsigned(15 downto 0);
    read_count : in u_unsigned(15 downto 0);
    read_plane : in u_unsigned(1 downto 0);
    read_data_valid : out std_ulogic;
    read_data_ready : in std_ulogic;
    read_data : out std_ulogic_vector(7 downto 0);

    frame_crc_valid : in std_ulogic;
    frame_crc_ready : out std_ulogic;
    frame_crc_plane : in u_unsigned(1 downto 0);
    frame_crc_done : out std_ulogic := '0';
    frame_crc_value : out std_ulogic_vector(31 downto 0);

    -- The area, which stands until the next one, and what ends it.
    area_start : out std_ulogic;
    area_stop : out std_ulogic := '0';
    area_x : out u_unsigned(coord_bits - 1 downto 0) := (others => '0');
    area_y : out u_unsigned(coord_bits - 1 downto 0) := (others => '0');
    area_width : out u_unsigned(coord_bits downto 0) := (others => '0');
    area_plane : out u_unsigned(1 downto 0) := (others => '0');

    -- Its pixels, more than are needed: depth above value, or edges.
    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    pixel_data : in u_unsigned(8 * (num_channels + depth_bytes) - 1 downto 0);
    pixel_edges : in u_unsigned(8 * edge_bytes - 1 downto 0)
  );
end entity;

architecture rtl of plane_requests is

  constant num_pixels : positive := width * height;
  -- Bytes of the largest plane.
  constant count_bits : positive := address_bits(4 * num_pixels + 1);

  type place_t is (rest, begins, runs, ends);

  signal place : place_t := rest;
  signal asked, summing : std_ulogic := '0';
  signal count : u_unsigned(count_bits - 1 downto 0) := (others => '0');
  signal starting, take_read, take_crc, now_quiet : std_ulogic;
  signal byte_valid, byte_ready, byte_last, byte_summed, crc_busy : std_ulogic;
  signal byte_data : std_ulogic_vector(7 downto 0);
  signal plane : u_unsigned(1 downto 0) := (others => '0');
  -- A register, which reaches units that are far apart: with `ends`, and a clock after a reset.
  signal reader_reset : std_ulogic := '0';

begin

  -- No pixel comes from the cycle on in which a request is taken, which is one behind that in which it is
  -- asked for: without that register the core waits for the link's command and for what every unit here says
  -- of itself, over the whole die.
  held <= '1' when place /= rest or asked = '1' else '0';
  now_quiet <= free when place = rest else '0';
  quiet <= now_quiet;
  resting <= '1' when place = rest and reader_reset = '0' else '0';

  take_read <= read_valid and now_quiet and asked;
  take_crc <= frame_crc_valid and now_quiet and asked and not read_valid;
  read_ready <= now_quiet and asked;
  frame_crc_ready <= now_quiet and asked and not read_valid;

  requests : process (clk)
  begin
    if rising_edge(clk) then
      asked <= read_valid or frame_crc_valid;
      frame_crc_done <= '0';
      reader_reset <= '0';
      -- No case statement: GHDL 2.0 gives one of four places no default, and Yosys a latch.
      if place = rest then
        area_x <= resize(read_x, coord_bits);
        area_y <= resize(read_y, coord_bits);
        area_width <= resize(read_width, coord_bits + 1);
        count <= resize(read_count, count_bits);
        plane <= read_plane;
        summing <= '0';
        if take_crc = '1' then
          area_x <= (others => '0');
          area_y <= (others => '0');
          area_width <= to_unsigned(width, coord_bits + 1);
          count <= to_unsigned(num_pixels * num_channels, count_bits);
          if frame_crc_plane(1) = '1' then
            count <= to_unsigned(num_pixels * edge_bytes, count_bits);
          elsif frame_crc_plane(0) = '1' then
            count <= to_unsigned(num_pixels * depth_bytes, count_bits);
          end if;
          plane <= frame_crc_plane;
          summing <= '1';
        end if;
        if take_read = '1' or take_crc = '1' then
          place <= begins;
        end if;
      elsif place = begins then
        place <= runs;
      elsif place = runs then
        if byte_valid = '1' and byte_ready = '1' and byte_last = '1' then
          place <= ends;
          reader_reset <= '1';
        end if;
      else
        -- What was read beyond the area is forgotten.
        reader_reset <= crc_busy;
        if crc_busy = '0' then
          frame_crc_done <= summing;
          place <= rest;
        end if;
      end if;
      if reset = '1' or read_reset = '1' then
        place <= rest;
        frame_crc_done <= '0';
        reader_reset <= '1';
      end if;
    end if;
  end process;

  starting <= '1' when place = begins else '0';
  area_start <= starting;
  area_stop <= reader_reset;
  area_plane <= plane;

  bytes_inst : entity work.plane_reader
    generic map (value_bytes => num_channels, depth_bytes => depth_bytes, count_bits => count_bits)
    port map (
      clk => clk, reset => reader_reset,
      request_valid => starting, request_ready => open, request_plane => plane, request_count => count,
      pixel_valid => pixel_valid, pixel_ready => pixel_ready, pixel_data => pixel_data,
      pixel_edges => pixel_edges,
      byte_valid => byte_valid, byte_ready => byte_ready, byte_last => byte_last, byte_data => byte_data
    );

  byte_ready <= not crc_busy when summing = '1' else read_data_ready;
  read_data_valid <= byte_valid and not summing and not reader_reset;
  read_data <= byte_data;
  byte_summed <= byte_valid and summing and not crc_busy;

  crc_inst : entity work.crc32
    generic map (cycles => crc_cycles)
    port map (
      clk => clk, clear => starting, byte_valid => byte_summed, byte_data => byte_data, busy => crc_busy,
      crc => frame_crc_value
    );

end architecture;
