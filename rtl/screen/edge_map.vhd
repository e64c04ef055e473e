-- SPDX-License-Identifier: Apache-2.0
--
-- Edge map of a G-buffer (Nienhaus and Döllner, 4.1.2), neighbours A B C / D X E / F G H, borders repeated:
--   normal = 1/2 ((A . H) + (C . F)), of normals n = 2 v - 255; negative is 0
--   depth  = (1 - 1/2 |A - H|)^2 (1 - 1/2 |C - F|)^2, or by the variant of the frame
--            1/8 (|A-X| + 2|B-X| + |C-X| + 2|D-X| + 2|E-X| + |F-X| + 2|G-X| + |H-X|), at most 1
-- Model: edge_map.py.  Test: test_edge_map.py.  Two line buffers in block RAM.
-- Latency: width + 11 cycles.  One pixel per cycle; a frame takes width * (height + 1) + 2 cycles.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity edge_map is
  generic (
    max_width : positive := 320;
    coord_bits : positive := 12;
    depth_bits : positive := 8
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    frame_valid : in std_ulogic;
    frame_ready : out std_ulogic;
    -- 3 to max_width, and at least 1.
    frame_width : in u_unsigned(coord_bits downto 0);
    frame_height : in u_unsigned(coord_bits downto 0);
    -- 0: diagonal neighbours, 1: all eight.
    frame_variant : in std_ulogic;
    -- The cycle after a frame of another size was taken: it has no pixels.
    refused : out std_ulogic;

    pixel_valid : in std_ulogic;
    pixel_ready : out std_ulogic;
    -- x, y, z of the normal, x lowest, 8 bits each.
    pixel_normal : in u_unsigned(23 downto 0);
    pixel_depth : in u_unsigned(depth_bits - 1 downto 0);

    edge_valid : out std_ulogic;
    edge_ready : in std_ulogic;
    edge_last : out std_ulogic;
    edge_normal : out u_unsigned(7 downto 0);
    edge_depth : out u_unsigned(7 downto 0)
  );
end entity;

architecture rtl of edge_map is

  constant address_width : positive := address_bits(max_width);
  constant pixel_bits : positive := 24 + depth_bits;
  subtype pixel_t is u_unsigned(pixel_bits - 1 downto 0);
  subtype depth_t is u_unsigned(depth_bits - 1 downto 0);
  -- A difference of depths as a fraction of 16 bits, its top bits repeated below: the greatest is all ones.
  subtype fraction_t is u_unsigned(15 downto 0);
  -- 1.0 is 2**17.
  subtype factor_t is u_unsigned(17 downto 0);
  subtype product_t is u_signed(17 downto 0);
  type depths_t is array (0 to 7) of depth_t;
  type products_t is array (0 to 5) of product_t;

  -- What is known of a column that enters the window: its pixel is the first or last of a scanline, or the
  -- frame's last; the scanline above it is shown, is the frame's first, and has none below.
  type step_t is record
    valid, first, last, final, shows, top, below, variant : std_ulogic;
  end record;
  constant no_step : step_t := (others => '0');

  -- The frame: its pixels come, its last scanline is repeated, its last column is.
  signal streaming, repeating, ending, refused_reg : std_ulogic := '0';
  signal variant, begun, second : std_ulogic := '0';
  signal columns, columns_left, rows_left : u_unsigned(coord_bits downto 0) := (others => '0');
  signal column : u_unsigned(address_width - 1 downto 0) := (others => '0');
  signal idle, step, advance, fits, line_begin, line_end : std_ulogic;

  -- Numbered by stage: 1 to 3 the line buffers, 4 the window, 5 its nine pixels, 6 to 10 arithmetic.
  signal step_1, step_2, step_3, step_4 : step_t := no_step;
  signal address_1, address_2, address_3 : u_unsigned(address_width - 1 downto 0) := (others => '0');
  signal pixel_1, pixel_2, pixel_3 : pixel_t := (others => '0');
  -- Of the column in stage 3: the pixels of the last two scanlines, and what the window takes for its three.
  signal older, newer, above, beneath : pixel_t;
  signal write_data, read_data : std_ulogic_vector(2 * pixel_bits - 1 downto 0);
  signal left_above, left_here, left_beneath : pixel_t := (others => '0');
  signal mid_above, mid_here, mid_beneath : pixel_t := (others => '0');

  signal a_5, c_5, f_5, h_5 : pixel_t := (others => '0');
  signal b_5, d_5, e_5, g_5, x_5 : depth_t := (others => '0');
  signal products_6 : products_t := (others => (others => '0'));
  signal differences_6 : depths_t := (others => (others => '0'));
  signal fall_6, rise_6 : depth_t := (others => '0');
  signal fall_dot_7, rise_dot_7 : u_signed(19 downto 0) := (others => '0');
  signal fall_7, rise_7, diagonal_8, diagonal_9 : factor_t := (others => '0');
  signal corners_7, sides_7 : u_unsigned(depth_bits + 1 downto 0) := (others => '0');
  signal dots_8 : u_signed(20 downto 0) := (others => '0');
  signal eight_8 : u_unsigned(depth_bits + 3 downto 0) := (others => '0');
  signal normal_9 : u_unsigned(10 downto 0) := (others => '0');
  signal eight_9 : u_unsigned(20 downto 0) := (others => '0');
  signal normal_10, depth_10 : u_unsigned(7 downto 0) := (others => '0');

  -- Stage 5 and on: a pixel is there, it is the frame's last, the frame's variant.
  signal valids, finals, variants : std_ulogic_vector(5 to 10) := (others => '0');

  signal emitted, shown : std_ulogic_vector(16 downto 0);

  function apart(one : u_unsigned; other : u_unsigned) return u_unsigned is
  begin
    if one > other then
      return one - other;
    end if;
    return other - one;
  end function;

  -- 2 v - 255 in nine bits: 2 v + 1 with its top bit inverted.
  function centred(pixel : pixel_t; index : natural) return u_signed is
    variable v : u_unsigned(7 downto 0);
  begin
    v := pixel(depth_bits + 8 * index + 7 downto depth_bits + 8 * index);
    return u_signed(std_ulogic_vector'(not v(7) & std_ulogic_vector(v(6 downto 0)) & '1'));
  end function;

  function dot_part(one : pixel_t; other : pixel_t; index : natural) return product_t is
  begin
    return centred(one, index) * centred(other, index);
  end function;

  function depth_of(pixel : pixel_t) return depth_t is
  begin
    return pixel(depth_bits - 1 downto 0);
  end function;

  -- 1 - 1/2 d, where a d of 1 is 2**depth_bits - 1.
  function factor(depth : depth_t) return factor_t is
    variable d : fraction_t := (others => '0');
  begin
    d(15 downto 16 - depth_bits) := depth;
    if depth_bits < 16 then
      d(15 - depth_bits downto 0) := depth(depth_bits - 1 downto 2 * depth_bits - 16);
    end if;
    return to_unsigned(2**17, 18) - resize(d, 18);
  end function;

  -- Product of two factors, cut off to their format.
  function times(one : factor_t; other : factor_t) return factor_t is
    variable product : u_unsigned(35 downto 0);
  begin
    product := one * other;
    return product(34 downto 17);
  end function;

  -- Eight times the sum of weights 12/8 in units of 1/65535.
  function spread(sum : u_unsigned(depth_bits + 3 downto 0)) return u_unsigned is
    variable wide : u_unsigned(20 downto 0) := (others => '0');
  begin
    wide(19 downto 16 - depth_bits) := sum;
    if depth_bits < 16 then
      wide := wide + sum(depth_bits + 3 downto 2 * depth_bits - 16);
    end if;
    return wide;
  end function;

begin

  assert depth_bits >= 8 and depth_bits <= 16
    report "edge_map: depth_bits is " & integer'image(depth_bits) & ", must be 8 to 16"
    severity failure;
  assert max_width >= 3 and max_width <= 2**coord_bits
    report "edge_map: max_width is " & integer'image(max_width) & ", must be 3 to 2**coord_bits = "
      & integer'image(2**coord_bits)
    severity failure;

  idle <= not (streaming or repeating or ending);
  frame_ready <= idle;
  pixel_ready <= streaming and advance;
  step <= advance and ((streaming and pixel_valid) or repeating or ending);
  fits <= '1' when frame_width >= 3 and frame_width <= to_unsigned(max_width, coord_bits + 1)
    and frame_height /= 0 else '0';
  line_begin <= '1' when columns_left = columns else '0';
  line_end <= '1' when columns_left = 0 else '0';

  walk : process (clk)
  begin
    if rising_edge(clk) then
      refused_reg <= '0';
      if idle = '1' and frame_valid = '1' then
        streaming <= fits;
        refused_reg <= not fits;
        columns <= frame_width - 1;
        columns_left <= frame_width - 1;
        rows_left <= frame_height - 1;
        variant <= frame_variant;
        column <= (others => '0');
        begun <= '0';
        second <= '0';
      end if;
      if step = '1' then
        column <= column + 1;
        columns_left <= columns_left - 1;
        ending <= '0';
        if line_end = '1' then
          column <= (others => '0');
          columns_left <= columns;
          rows_left <= rows_left - 1;
          begun <= '1';
          second <= not begun;
          ending <= repeating;
          repeating <= '0';
          if streaming = '1' and rows_left = 0 then
            streaming <= '0';
            repeating <= '1';
          end if;
        end if;
      end if;
      if reset = '1' then
        streaming <= '0';
        repeating <= '0';
        ending <= '0';
        refused_reg <= '0';
      end if;
    end if;
  end process;

  refused <= refused_reg;

  buffering : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        step_1.valid <= step;
        step_1.first <= line_begin;
        step_1.last <= line_end;
        step_1.final <= line_end and repeating;
        step_1.shows <= begun and not ending;
        step_1.top <= second;
        step_1.below <= repeating;
        step_1.variant <= variant;
        step_2 <= step_1;
        step_3 <= step_2;
        address_1 <= column;
        address_2 <= address_1;
        address_3 <= address_2;
        pixel_1 <= pixel_normal & pixel_depth;
        pixel_2 <= pixel_1;
        pixel_3 <= pixel_2;
      end if;
      if reset = '1' then
        step_1.valid <= '0';
        step_2.valid <= '0';
        step_3.valid <= '0';
      end if;
    end if;
  end process;

  newer <= unsigned(read_data(pixel_bits - 1 downto 0));
  older <= unsigned(read_data(2 * pixel_bits - 1 downto pixel_bits));
  write_data <= std_ulogic_vector(newer) & std_ulogic_vector(pixel_3);

  lines_inst : entity work.block_ram
    generic map (num_words => max_width, data_bits => 2 * pixel_bits, slice_bits => 16)
    port map (
      clk => clk,
      write_enable => step_3.valid, write_address => address_3, write_data => write_data,
      read_enable => advance, read_address => address_1, read_data => read_data
    );

  above <= newer when step_3.top = '1' else older;
  beneath <= newer when step_3.below = '1' else pixel_3;

  -- The window stands on the column before the one that enters.
  window : process (clk)
  begin
    if rising_edge(clk) then
      if advance = '1' then
        if step_3.valid = '1' then
          left_above <= mid_above;
          left_here <= mid_here;
          left_beneath <= mid_beneath;
          mid_above <= above;
          mid_here <= newer;
          mid_beneath <= beneath;
          step_4 <= step_3;
        end if;
        valids <= (step_3.valid and step_4.shows) & valids(5 to 9);
        finals <= step_4.final & finals(5 to 9);
        variants <= step_4.variant & variants(5 to 9);

        a_5 <= left_above;
        d_5 <= depth_of(left_here);
        f_5 <= left_beneath;
        if step_4.first = '1' then
          a_5 <= mid_above;
          d_5 <= depth_of(mid_here);
          f_5 <= mid_beneath;
        end if;
        b_5 <= depth_of(mid_above);
        x_5 <= depth_of(mid_here);
        g_5 <= depth_of(mid_beneath);
        c_5 <= above;
        e_5 <= depth_of(newer);
        h_5 <= beneath;
        if step_4.last = '1' then
          c_5 <= mid_above;
          e_5 <= depth_of(mid_here);
          h_5 <= mid_beneath;
        end if;
      end if;
      if reset = '1' then
        step_4.shows <= '0';
        valids <= (others => '0');
      end if;
    end if;
  end process;

  arithmetic : process (clk)
    variable scaled : u_unsigned(27 downto 0);
    variable wide : u_unsigned(25 downto 0);
    variable eight : u_unsigned(20 downto 0);
  begin
    if rising_edge(clk) then
      if advance = '1' then
        for index in 0 to 2 loop
          products_6(index) <= dot_part(a_5, h_5, index);
          products_6(index + 3) <= dot_part(c_5, f_5, index);
        end loop;
        fall_6 <= apart(depth_of(a_5), depth_of(h_5));
        rise_6 <= apart(depth_of(c_5), depth_of(f_5));
        differences_6(0) <= apart(depth_of(a_5), x_5);
        differences_6(1) <= apart(depth_of(c_5), x_5);
        differences_6(2) <= apart(depth_of(f_5), x_5);
        differences_6(3) <= apart(depth_of(h_5), x_5);
        differences_6(4) <= apart(b_5, x_5);
        differences_6(5) <= apart(d_5, x_5);
        differences_6(6) <= apart(e_5, x_5);
        differences_6(7) <= apart(g_5, x_5);

        fall_dot_7 <= resize(products_6(0), 20) + resize(products_6(1), 20) + resize(products_6(2), 20);
        rise_dot_7 <= resize(products_6(3), 20) + resize(products_6(4), 20) + resize(products_6(5), 20);
        fall_7 <= factor(fall_6);
        rise_7 <= factor(rise_6);
        corners_7 <= resize(differences_6(0), depth_bits + 2) + resize(differences_6(1), depth_bits + 2)
          + resize(differences_6(2), depth_bits + 2) + resize(differences_6(3), depth_bits + 2);
        sides_7 <= resize(differences_6(4), depth_bits + 2) + resize(differences_6(5), depth_bits + 2)
          + resize(differences_6(6), depth_bits + 2) + resize(differences_6(7), depth_bits + 2);

        dots_8 <= resize(fall_dot_7, 21) + resize(rise_dot_7, 21);
        diagonal_8 <= times(fall_7, rise_7);
        eight_8 <= resize(corners_7, depth_bits + 4) + (resize(sides_7, depth_bits + 3) & '0');

        -- 1/510 is 257 / 2**17 to 16 bits; below zero it is zero.
        scaled := resize(u_unsigned(dots_8(19 downto 0)), 28) + (u_unsigned(dots_8(19 downto 0)) & x"00")
          + to_unsigned(2**16, 28);
        normal_9 <= scaled(27 downto 17);
        if dots_8(20) = '1' then
          normal_9 <= (others => '0');
        end if;
        diagonal_9 <= times(diagonal_8, diagonal_8);
        eight_9 <= spread(eight_8);

        normal_10 <= normal_9(7 downto 0);
        if normal_9(10 downto 8) /= 0 then
          normal_10 <= (others => '1');
        end if;
        -- 255 is (256 - 1), and 1/257 is 1/256 (1 - 1/256) to 16 bits.
        wide := (diagonal_9 & x"00") - resize(diagonal_9, 26) + to_unsigned(2**16, 26);
        depth_10 <= wide(24 downto 17);
        if variants(9) = '1' then
          eight := eight_9 - resize(eight_9(20 downto 8), 21) + to_unsigned(2**10, 21);
          depth_10 <= eight(18 downto 11);
          if eight(20 downto 19) /= 0 then
            depth_10 <= (others => '1');
          end if;
        end if;
      end if;
    end if;
  end process;

  emitted <= finals(10) & std_ulogic_vector(depth_10) & std_ulogic_vector(normal_10);

  output_inst : entity work.skid_buffer
    generic map (data_bits => 17)
    port map (
      clk => clk, reset => reset,
      input_valid => valids(10), input_ready => advance, input_data => emitted,
      output_valid => edge_valid, output_ready => edge_ready, output_data => shown
    );

  edge_normal <= unsigned(shown(7 downto 0));
  edge_depth <= unsigned(shown(15 downto 8));
  edge_last <= shown(16);

end architecture;
