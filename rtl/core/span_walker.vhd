-- SPDX-License-Identifier: Apache-2.0
--
-- Walks spans pixel by pixel: u += 1 until the count's sign says last. x is u, or its bitwise NOT where the
-- primitive is mirrored.
--
-- Model: span_walker.py.  Test: test_span_walker.py.
-- Latency: 1 cycle.  One pixel per cycle, spans back to back.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity span_walker is
  generic (
    coord_bits : positive := 12;
    column_bits : positive := 13
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    span_valid : in std_ulogic;
    -- High when a span is taken in this cycle, if one is there and pixels may advance.
    span_wanted : out std_ulogic;
    span_last : in std_ulogic;
    span_mirror : in std_ulogic;
    span_column : in u_unsigned(column_bits - 1 downto 0);
    span_y : in u_unsigned(coord_bits - 1 downto 0);
    -- Pixels minus 2.
    span_count : in u_signed(column_bits - 1 downto 0);
    -- The waiting span has one pixel; the pixel after the one shown is its span's last. From these the lanes
    -- keep their own copies of span_wanted.
    span_single : out std_ulogic;
    span_ending : out std_ulogic;
    advance : in std_ulogic;
    pixel_valid : out std_ulogic;
    pixel_last : out std_ulogic;
    pixel_x : out u_unsigned(coord_bits - 1 downto 0);
    pixel_y : out u_unsigned(coord_bits - 1 downto 0)
  );
end entity;

architecture rtl of span_walker is

  -- Negative on a span's last pixel and while there is none.
  signal count : u_signed(column_bits - 1 downto 0) := (others => '1');
  signal valid, last, mirror : std_ulogic := '0';
  signal column, y : u_unsigned(coord_bits - 1 downto 0) := (others => '0');
  signal load, wanted : std_ulogic;
  -- The count is 0.
  signal ending : std_ulogic := '0';

begin

  wanted <= count(column_bits - 1);
  load <= wanted and span_valid;
  span_wanted <= wanted;
  span_single <= span_count(column_bits - 1);
  span_ending <= ending;

  walk : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        valid <= load or not wanted;
        ending <= '0';
        if load = '1' then
          count <= span_count;
          if span_count = 0 then
            ending <= '1';
          end if;
          column <= span_column(coord_bits - 1 downto 0);
          y <= span_y;
          last <= span_last;
          mirror <= span_mirror;
        elsif wanted = '0' then
          count <= count - 1;
          if count = 1 then
            ending <= '1';
          end if;
          column <= column + 1;
        end if;
      end if;
      if reset = '1' then
        valid <= '0';
        ending <= '0';
        count <= (others => '1');
      end if;
    end if;
  end process;

  pixel_valid <= valid;
  pixel_last <= last and wanted;
  pixel_x <= not column when mirror = '1' else column;
  pixel_y <= y;

end architecture;
