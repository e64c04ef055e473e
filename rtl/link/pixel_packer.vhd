-- SPDX-License-Identifier: Apache-2.0
--
-- READ's bytes in fewer, without loss. A byte is predicted from those of the two pixels before, 2 a - b;
-- what it is more, 0, 1, -1, 2 or -2, becomes 0 to 4 ones and a 0, anything else five ones and the byte. A
-- pixel as predicted begins a run: a 1 for 1, 2, 4 ... further bytes, at its end a 0 and the rest in binary.
-- An answer begins with its length, so the screen is read twice: counted, then sent. Where packing saves
-- nothing the bytes are sent as they are. A memory of 1 KiB instead was dropped: the boards' are used up.
--
-- Model: pixel_packer.py.  Test: test_pixel_packer.py.
-- Latency: that of the first reading, at most 18 cycles a byte.  One bit per cycle.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.link_pkg.all;

entity pixel_packer is
  generic (
    -- Of a pixel; 0: there is no depth.
    value_bytes : positive := 3;
    depth_bytes : natural := 2
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    -- From the link: an area of a plane, whose place goes to the screen past this unit and stands until it is
    -- taken.
    read_valid : in std_ulogic;
    read_ready : out std_ulogic;
    read_packed : in std_ulogic;
    read_count : in u_unsigned(15 downto 0);
    read_plane : in u_unsigned(1 downto 0);
    -- Bytes of the answer, known from read_ready on.
    answer_bytes : out u_unsigned(9 downto 0);
    data_valid : out std_ulogic;
    data_ready : in std_ulogic;
    data : out std_ulogic_vector(7 downto 0);

    -- To the screen, which gives the same read_count bytes each time that it is asked.
    area_valid : out std_ulogic;
    area_ready : in std_ulogic;
    byte_valid : in std_ulogic;
    byte_ready : out std_ulogic;
    byte_data : in std_ulogic_vector(7 downto 0)
  );
end entity;

architecture rtl of pixel_packer is

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

  -- 0, 1, -1, 2, -2 ...: what so many ones stand for.
  function residual_of(ones : natural) return natural is
  begin
    if ones mod 2 = 1 then
      return (ones + 1) / 2;
    end if;
    return (256 - ones / 2) mod 256;
  end function;

  function first_ones(ones : natural) return std_ulogic_vector is
    variable found : std_ulogic_vector(escape_ones - 1 downto 0) := (others => '0');
  begin
    for index in 0 to ones - 1 loop
      found(escape_ones - 1 - index) := '1';
    end loop;
    return found;
  end function;

  constant most_bytes : positive := largest(value_bytes, depth_bytes, edge_bytes);
  constant code_bits : positive := escape_ones + 8;
  constant count_bits : positive := 10;
  -- A byte may take code_bits.
  constant packed_bits : positive := count_bits + 1;

  subtype byte_t is u_unsigned(7 downto 0);
  type byte_vector_t is array (natural range <>) of byte_t;
  type place_t is (rest, fetch, subtract, judge, code, run_end, flush, ended, again);

  signal place : place_t := rest;
  -- The second reading.
  signal sends : std_ulogic := '0';
  signal packed_bytes : u_unsigned(packed_bits - 1 downto 0) := (others => '0');

  -- Bytes still to be fetched; what the next one should be; the one in work, and what it is more than that of
  -- the pixel before, and than it should be.
  signal left : u_unsigned(count_bits - 1 downto 0) := (others => '0');
  -- From a byte's second clock on: there are some left. asks: the place is fetch, and so it is.
  signal any_left, asks : std_ulogic := '0';
  signal expected, current, difference, residual : byte_t := (others => '0');
  signal is_zero : std_ulogic := '0';
  -- The bytes before, the newest in 0, and by how much each was more than the one a pixel before it.
  signal values, slopes : byte_vector_t(0 to most_bytes - 1) := (others => (others => '0'));
  signal last_byte : natural range 0 to most_bytes - 1 := 0;
  signal value : byte_t;
  -- Bytes of the first pixel, which have no slope; zeros in a row.
  signal fresh : natural range 0 to most_bytes := 0;
  signal zeros : natural range 0 to most_bytes - 1 := 0;

  -- Zeros of a run since its last 1, and with how many comes the next, a single bit.
  -- One zero more is as many as that: it is known in time, a cycle late.
  signal running, step_done : std_ulogic := '0';
  signal run : u_unsigned(count_bits - 1 downto 0) := (others => '0');
  signal step : u_unsigned(count_bits - 1 downto 0) := (others => '0');

  signal word : std_ulogic_vector(code_bits - 1 downto 0) := (others => '0');
  signal word_left : natural range 0 to code_bits := 0;
  -- The byte that is made, from its highest bit on.
  signal shift : std_ulogic_vector(7 downto 0) := (others => '0');
  signal bits : u_unsigned(2 downto 0) := (others => '0');
  signal full : std_ulogic := '0';
  signal emits, bit_out, run_bit, done : std_ulogic;

begin

  assert most_bytes <= 4
    report "pixel_packer: a pixel has " & integer'image(most_bytes) & " bytes, must be at most 4"
    severity failure;

  read_ready <= (area_ready and not read_packed) when place = rest else
    area_ready when place = again else '0';
  area_valid <= read_valid when place = rest else
    '1' when place = again else '0';
  answer_bytes <= read_count(9 downto 0) when place = rest else packed_bytes(9 downto 0);
  data_valid <= byte_valid when place = rest else (full and sends);
  data <= byte_data when place = rest else shift;
  byte_ready <= data_ready when place = rest else asks;

  value <= values(last_byte);
  run_bit <= or (run and ('0' & step(count_bits - 1 downto 1)));

  -- A bit, in a cycle in which there is room for it.
  emit : process (all)
  begin
    emits <= '0';
    bit_out <= '0';
    if full = '0' then
      if place = fetch and asks = '0' and running = '1' and run /= 0 then
        -- The bytes end with the run: how many they are is known.
        emits <= '1';
        bit_out <= '1';
      elsif place = judge and running = '1' then
        emits <= step_done or not is_zero;
        bit_out <= is_zero;
      elsif place = run_end then
        emits <= not step(0);
        bit_out <= run_bit;
      elsif place = code then
        emits <= '1';
        bit_out <= word(code_bits - 1);
      elsif place = flush and bits /= 0 then
        emits <= '1';
      end if;
    end if;
  end process;

  -- The byte in work is coded, or counted in a run.
  done <= '1' when place = judge and (running = '0' or (is_zero = '1' and (emits = '1' or step_done = '0')))
    else '0';

  pack : process (clk)
  begin
    if rising_edge(clk) then
      expected <= value + slopes(last_byte);
      any_left <= or left;
      asks <= '0';
      step_done <= '0';
      if run + 1 = step then
        step_done <= '1';
      end if;
      if emits = '1' then
        shift <= shift(6 downto 0) & bit_out;
        bits <= bits + 1;
        if bits = 7 then
          full <= '1';
        end if;
      end if;
      if full = '1' and (sends = '0' or data_ready = '1') then
        full <= '0';
        if sends = '0' then
          packed_bytes <= packed_bytes + 1;
        end if;
      end if;
      if done = '1' then
        values(0) <= current;
        slopes(0) <= difference;
        if fresh /= 0 then
          slopes(0) <= (others => '0');
          fresh <= fresh - 1;
        end if;
        for index in 1 to most_bytes - 1 loop
          values(index) <= values(index - 1);
          slopes(index) <= slopes(index - 1);
        end loop;
      end if;

      -- No case statement: GHDL 2.0 gives that of all places no default, and Yosys a latch.
      if place = rest or place = again then
        left <= read_count(count_bits - 1 downto 0);
        values <= (others => (others => '0'));
        slopes <= (others => (others => '0'));
        last_byte <= value_bytes - 1;
        fresh <= value_bytes;
        if read_plane(1) = '1' then
          last_byte <= edge_bytes - 1;
          fresh <= edge_bytes;
        elsif read_plane(0) = '1' and depth_bytes /= 0 then
          last_byte <= largest(depth_bytes, 1, 1) - 1;
          fresh <= depth_bytes;
        end if;
        zeros <= 0;
        running <= '0';
        sends <= '0';
        if place = rest then
          packed_bytes <= (others => '0');
          if read_valid = '1' and read_packed = '1' and area_ready = '1' then
            place <= fetch;
            asks <= or read_count(count_bits - 1 downto 0);
          end if;
        elsif area_ready = '1' then
          sends <= '1';
          place <= fetch;
          asks <= or read_count(count_bits - 1 downto 0);
          if packed_bytes >= read_count(count_bits - 1 downto 0) then
            sends <= '0';
            place <= rest;
            asks <= '0';
          end if;
        end if;
      elsif place = fetch then
        current <= unsigned(byte_data);
        if asks = '0' then
          if emits = '1' then
            run <= (others => '0');
          elsif full = '0' then
            place <= flush;
          end if;
        elsif byte_valid = '1' then
          left <= left - 1;
          place <= subtract;
        else
          asks <= '1';
        end if;
      elsif place = subtract then
        difference <= current - value;
        residual <= current - expected;
        is_zero <= '0';
        if current = expected then
          is_zero <= '1';
        end if;
        place <= judge;
      elsif place = judge then
        if running = '0' then
          word <= (code_bits - 1 downto 8 => '1') & std_ulogic_vector(current);
          word_left <= code_bits;
          for ones in 0 to escape_ones - 1 loop
            if residual = residual_of(ones) then
              word <= (others => '0');
              word(code_bits - 1 downto code_bits - escape_ones) <= first_ones(ones);
              word_left <= ones + 1;
            end if;
          end loop;
          zeros <= 0;
          if is_zero = '1' then
            if zeros = last_byte then
              running <= '1';
            else
              zeros <= zeros + 1;
            end if;
          end if;
          run <= (others => '0');
          step <= to_unsigned(1, count_bits);
          place <= code;
        elsif done = '1' then
          run <= run + 1;
          if step_done = '1' then
            run <= (others => '0');
            step <= step(count_bits - 2 downto 0) & '0';
          end if;
          place <= fetch;
          asks <= any_left;
        elsif emits = '1' then
          running <= '0';
          place <= run_end;
        end if;
      elsif place = run_end then
        if step(0) = '1' then
          place <= judge;
        elsif emits = '1' then
          step <= '0' & step(count_bits - 1 downto 1);
        end if;
      elsif place = code then
        if emits = '1' then
          word <= word(code_bits - 2 downto 0) & '0';
          word_left <= word_left - 1;
          if word_left = 1 then
            place <= fetch;
            asks <= any_left;
          end if;
        end if;
      elsif place = flush then
        if bits = 0 and full = '0' then
          place <= ended;
        end if;
      else
        place <= again;
        if sends = '1' then
          place <= rest;
        end if;
      end if;
      if reset = '1' then
        place <= rest;
        asks <= '0';
        sends <= '0';
        full <= '0';
        bits <= (others => '0');
      end if;
    end if;
  end process;

end architecture;
