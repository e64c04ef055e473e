-- SPDX-License-Identifier: Apache-2.0
--
-- A plane's pixels as bytes, the lowest byte of a pixel first: exactly `count` of them, then it waits for the
-- next request. Planes: 0 value, 1 depth, 2 and 3 edges (the two bytes of edge_map).
--
-- Model: plane_reader.py.  Test: test_plane_reader.py.
-- Latency: 1 cycle from a pixel to its first byte.  One byte per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;

entity plane_reader is
  generic (
    value_bytes : positive := 3;
    -- 0: there is no depth.
    depth_bytes : natural := 2;
    count_bits : positive := 20
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    request_valid : in std_ulogic;
    request_ready : out std_ulogic;
    request_plane : in u_unsigned(1 downto 0);
    -- Bytes, at least one.
    request_count : in u_unsigned(count_bits - 1 downto 0);

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    -- Depth above value.
    pixel_data : in u_unsigned(8 * (value_bytes + depth_bytes) - 1 downto 0);
    pixel_edges : in u_unsigned(8 * edge_bytes - 1 downto 0);

    byte_valid : out std_ulogic;
    byte_ready : in std_ulogic;
    byte_last : out std_ulogic;
    byte_data : out std_ulogic_vector(7 downto 0)
  );
end entity;

architecture rtl of plane_reader is

  function largest(one : natural; other : natural; third : natural) return natural is
    variable found : natural := one;
  begin
    if other > found then
      found := other;
    end if;
    if third > found then
      found := third;
    end if;
    return found;
  end function;

  constant held_bytes : positive := largest(value_bytes, depth_bytes, edge_bytes);

  signal running : std_ulogic := '0';
  signal plane : u_unsigned(1 downto 0) := (others => '0');
  -- Bytes still to be sent, the one that is shown included.
  signal count_left : u_unsigned(count_bits - 1 downto 0) := (others => '0');
  -- The pixel that is sent, its next byte lowest, and how many bytes of it are left.
  signal held : u_unsigned(8 * held_bytes - 1 downto 0) := (others => '0');
  signal held_left : u_unsigned(2 downto 0) := (others => '0');
  -- It is the last one.
  signal at_last : std_ulogic := '0';
  signal shown, sent, wants : std_ulogic;

begin

  assert value_bytes <= 4 and depth_bytes <= 4
    report "plane_reader: pixels of " & integer'image(value_bytes) & " and " & integer'image(depth_bytes)
      & " bytes, must be at most 4"
    severity failure;

  shown <= '1' when held_left /= 0 else '0';
  sent <= shown and byte_ready;
  wants <= '1' when running = '1'
    and (held_left = 0 or (held_left = 1 and byte_ready = '1' and at_last = '0')) else '0';

  request_ready <= not running;
  pixel_ready <= wants;
  byte_valid <= shown;
  byte_last <= at_last;
  byte_data <= std_ulogic_vector(held(7 downto 0));

  serialise : process (clk)
  begin
    if rising_edge(clk) then
      if sent = '1' then
        held <= shift_right(held, 8);
        held_left <= held_left - 1;
        count_left <= count_left - 1;
        at_last <= '0';
        if count_left = 2 then
          at_last <= '1';
        end if;
        if at_last = '1' then
          held_left <= (others => '0');
          running <= '0';
        end if;
      end if;
      if wants = '1' and pixel_valid = '1' then
        if plane(1) = '1' then
          held <= resize(pixel_edges, 8 * held_bytes);
          held_left <= to_unsigned(edge_bytes, 3);
        elsif plane(0) = '1' then
          held <= resize(shift_right(pixel_data, 8 * value_bytes), 8 * held_bytes);
          held_left <= to_unsigned(depth_bytes, 3);
        else
          held <= resize(pixel_data(8 * value_bytes - 1 downto 0), 8 * held_bytes);
          held_left <= to_unsigned(value_bytes, 3);
        end if;
      end if;
      if request_valid = '1' and running = '0' then
        running <= '1';
        plane <= request_plane;
        count_left <= request_count;
        at_last <= '0';
        if request_count = 1 then
          at_last <= '1';
        end if;
      end if;
      if reset = '1' then
        running <= '0';
        held_left <= (others => '0');
      end if;
    end if;
  end process;

end architecture;
