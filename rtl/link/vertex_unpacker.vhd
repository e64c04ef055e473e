-- SPDX-License-Identifier: Apache-2.0
--
-- Vertices of the line to set-up words of the core, by a program: sort, edges by a serial divider, and for
-- every channel sums of ratios times what the vertices' colours say. Two bits of a factor, one of a quotient
-- a clock; no multiplier. Runs of packed words within pass to word_unpacker and come back.
--
-- Model: vertex_unpacker.py.  Test: test_vertex_unpacker.py.
-- Latency: the clocks that its model counts; test_vertex_unpacker.py compares them.
-- Nothing in the program jumps back but counted loops: a packet ends whatever its bits say.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
use work.vertex_pkg.all;

entity vertex_unpacker is
  generic (
    num_channels : positive := default_formats.num_channels;
    max_order : natural := default_formats.max_order;
    with_depth : natural := default_formats.with_depth;
    word_width : positive := default_formats.word_width;
    frac_bits : natural := default_formats.frac_bits;
    depth_bits : positive := default_formats.depth_bits;
    subpixel_bits : natural := default_formats.subpixel_bits;
    coord_bits : positive := default_formats.coord_bits
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    line_valid : in std_ulogic;
    line_ready : out std_ulogic;
    line_data : in std_ulogic_vector(setup_word_bits - 1 downto 0);

    -- To word_unpacker and from it.
    packed_valid : out std_ulogic;
    packed_ready : in std_ulogic;
    packed_data : out std_ulogic_vector(setup_word_bits - 1 downto 0);
    unpacking : in std_ulogic;
    unpacked_valid : in std_ulogic;
    unpacked_ready : out std_ulogic;
    unpacked_data : in std_ulogic_vector(setup_word_bits - 1 downto 0);

    setup_valid : out std_ulogic;
    setup_ready : in std_ulogic;
    setup_data : out std_ulogic_vector(setup_word_bits - 1 downto 0);

    -- A packet is begun, or a set-up word waits, here or in word_unpacker.
    busy : out std_ulogic
  );
end entity;

architecture rtl of vertex_unpacker is

  constant formats : formats_t := (
    num_channels, max_order, with_depth, word_width, frac_bits, 4, depth_bits, subpixel_bits, coord_bits, 32,
    1, 0, 1, 4 -- what is not a generic here does not matter
  );
  constant width : positive := vertex_width;
  constant word_low : natural := ratio_frac + sample_frac - frac_bits;
  subtype number_t is u_signed(width - 1 downto 0);
  subtype address_t is u_unsigned(program_bits - 1 downto 0);
  constant program : vertex_program_t := vertex_program(formats);

  type memory_t is array (0 to memory_words - 1) of std_ulogic_vector(width - 1 downto 0);
  signal memory : memory_t := (others => (others => '0'));
  signal memory_write : std_ulogic;
  signal memory_data : number_t;
  signal read_address : address_t;
  signal read_data : std_ulogic_vector(width - 1 downto 0);

  -- The instruction that is executed, the one behind it and the one behind that.
  signal code, code_next, code_read : vertex_code_t := (others => '0');
  signal operation, operation_next : u_unsigned(operation_bits - 1 downto 0);

  type step_t is (jumping, jumped, fetching, loading, executing);
  signal step : step_t := jumping;
  signal pc : address_t := (others => '0');
  type returns_t is array (0 to 3) of address_t;
  signal returns : returns_t := (others => (others => '0'));
  signal depth : u_unsigned(1 downto 0) := (others => '0');
  signal place, pointer : address_t := (others => '0');
  signal index : u_unsigned(2 downto 0) := (others => '0');
  signal left : u_unsigned(count_bits - 1 downto 0) := (others => '0');
  -- None of these, one step at most, four bits at least.
  signal no_step, last_step, by_four, known : std_ulogic := '0';
  signal run : u_unsigned(run_bits - 1 downto 0) := (others => '0');

  signal fetched, shifter, word : number_t;
  signal acc : u_signed(width + 1 downto 0);
  -- The operation needs neither line nor core, shifts the accumulator, reads bits, up to a zero; its operand
  -- says how many steps, and is in the memory.
  signal computes, shifts, reads, tells, counted, comes_late, waits_first : std_ulogic := '0';
  signal load, is_zero, spent : std_ulogic;

  -- The operation moves on; it is at its end; the next instruction is fetched; a jump is taken.
  signal moves, done, ends, fetch, take_jump : std_ulogic;

  -- A word of the line is shifted out of a register, the bit of line_index lowest.
  signal line_word : std_ulogic_vector(setup_word_bits - 1 downto 0) := (others => '0');
  signal line_index : u_unsigned(4 downto 0) := (others => '0');
  signal line_held : std_ulogic := '0';
  signal take, drop, passes, fills : std_ulogic;
  signal filling, runs : std_ulogic := '0';

  -- Bits that go out, how many there are, and zeros behind them up to the end of the word.
  signal leaving, lane : std_ulogic_vector(setup_word_bits - 1 downto 0) := (others => '0');
  signal leaving_bits : u_unsigned(count_bits - 1 downto 0) := (others => '0');
  signal lane_bit : u_unsigned(4 downto 0) := (others => '0');
  signal pads, full : std_ulogic := '0';
  signal leaves, gone, by_two : std_ulogic;

  function is_in(number : u_unsigned; low, high : natural) return std_ulogic is
  begin
    if number >= low and number <= high then
      return '1';
    end if;
    return '0';
  end function;

begin

  assert num_channels <= 4 and max_order >= 1 and subpixel_bits >= 5 and coord_bits + subpixel_bits <= 20
    and word_width <= 32 and word_low + word_width <= width and depth_bits <= 16
    report "vertex_unpacker: generics out of range"
    severity failure;

  setup_valid <= full or unpacked_valid;
  setup_data <= lane when full = '1' else unpacked_data;
  unpacked_ready <= setup_ready and not full;

  operation <= unsigned(code(waits_at - 1 downto operation_low));
  operation_next <= unsigned(code_next(waits_at - 1 downto operation_low));
  busy <= '0' when step = executing and operation = do_start and full = '0' and line_held = '0' else '1';

  numbers : entity work.vertex_alu
    port map (
      clk => clk, operation => operation, load => load, operand => fetched, step => moves, by_four => by_four,
      line_bit => line_word(0), acc => acc, shifter => shifter, word => word, is_zero => is_zero,
      spent => spent
    );

  -- The operand of the next instruction is read while this one ends.
  operands : process (all)
    variable base : address_t;
  begin
    base := (others => '0');
    if code_next(indexed_at) = '1' then
      base := pointer + index;
    end if;
    read_address <= base + unsigned(code_next(count_bits + program_bits - 1 downto count_bits));
    fetched <= signed(read_data);
    if code(immediate_at) = '1' then
      fetched <= resize(signed(code(mode_low - 1 downto count_bits)), width);
    end if;
  end process;

  load <= '1' when step = loading else '0';

  -- What the operation needs of line and core, and whether this is its last cycle.
  control : process (all)
  begin
    moves <= '0';
    if step = executing and known = '1' and no_step = '0' then
      -- Of raw until it is known whether any word is left.
      moves <= computes or waits_first or (reads and line_held and (line_word(0) or not tells));
    elsif step = executing and known = '1' then
      moves <= computes and not shifts;
    end if;
    done <= '0';
    take <= '0';
    drop <= '0';
    passes <= '0';
    fills <= '0';
    if step /= executing or known = '0' then
      null;
    elsif operation = do_start then
      take <= line_held;
      done <= line_held and line_word(0);
    elsif operation = do_raw then
      if no_step = '0' then
        null;
      elsif filling = '1' then
        fills <= '1';
      elsif line_index /= 0 then
        drop <= '1';
      elsif runs = '1' then
        passes <= line_held and not full;
      else
        -- What the run began must be over first.
        fills <= unpacking;
        done <= not unpacking;
      end if;
    elsif reads = '1' then
      take <= line_held and not no_step;
      done <= no_step or (line_held and (last_step or (tells and not line_word(0))));
    elsif operation = do_put then
      done <= gone;
    elsif operation = do_align then
      done <= '1';
    elsif operation = do_word then
      done <= gone and not full;
    else
      done <= last_step or spent;
    end if;
  end process;

  take_jump <= '1' when operation = do_jmp or operation = do_call or operation = do_ret
      or (operation = do_jz and is_zero = '1') or (operation = do_jnz and is_zero = '0')
      or (operation = do_jn and acc(width - 1) = '1') or (operation = do_jnn and acc(width - 1) = '0')
      or (operation = do_loop and index + 1 < unsigned(code(count_bits - 1 downto 0)))
    else '0';

  ends <= '1' when done = '1' or (step = loading and code(quick_at) = '1') else '0';
  -- Behind a jump that is taken, what was fetched is not executed.
  fetch <= '1' when step = fetching or (ends = '1' and code(waits_at) = '0') else '0';

  packed_valid <= fills or passes;
  packed_data <= (others => '0') when fills = '1' else line_word;
  line_ready <= not line_held;

  advance : process (clk)
    variable rest : u_unsigned(count_bits - 1 downto 0);
  begin
    if rising_edge(clk) then
      rest := left - 4 when by_four = '1' else left - (moves and not no_step);
      if load = '1' then
        step <= executing;
        -- None of an operand in the memory: it comes late, and is looked at a clock later.
        rest := unsigned(code(count_bits - 1 downto 0));
      end if;
      left <= rest;
      if load = '1' and counted = '1' then
        left <= unsigned(fetched(count_bits - 1 downto 0));
      end if;
      known <= not (load and comes_late);
      no_step <= '0';
      last_step <= '0';
      by_four <= '0';
      if rest <= 1 or (shifts = '1' and rest = 4) then
        last_step <= '1';
      end if;
      if rest = 0 then
        no_step <= '1';
      end if;
      if shifts = '1' and rest >= 4 then
        by_four <= '1';
      end if;

      if fetch = '1' then
        code <= code_next;
        computes <= not is_in(operation_next, do_put, do_ret);
        shifts <= is_in(operation_next, do_shl, do_shr);
        reads <= is_in(operation_next, do_get, do_ones);
        tells <= is_in(operation_next, do_ones, do_ones);
        counted <= is_in(operation_next, do_shl, do_take);
        comes_late <= is_in(operation_next, do_shl, do_take) and not code_next(immediate_at);
        waits_first <= is_in(operation_next, do_raw, do_raw);
        code_next <= code_read;
        place <= read_address;
        step <= loading;
      elsif ends = '1' then
        step <= fetching;
      elsif step = jumping then
        step <= jumped;
      elsif step = jumped then
        code_next <= code_read;
        step <= fetching;
      end if;
      if step = loading and take_jump = '1' then
        step <= jumping;
      end if;

      if fetch = '1' or step = jumping or step = jumped then
        code_read <= program(to_integer(pc));
        pc <= pc + 1;
      end if;
      if step = loading then
        if take_jump = '1' then
          pc <= unsigned(code(count_bits + program_bits - 1 downto count_bits));
        end if;
        if operation = do_call then
          returns(to_integer(depth)) <= pc - 2;
          depth <= depth + 1;
        elsif operation = do_ret then
          pc <= returns(to_integer(depth - 1));
          depth <= depth - 1;
        elsif operation = do_loop then
          index <= index + 1;
        elsif operation = do_ldx then
          index <= unsigned(code(count_bits + index'high downto count_bits));
        elsif operation = do_ldp then
          pointer <= unsigned(fetched(program_bits - 1 downto 0));
        end if;
      end if;
      if reset = '1' then
        step <= jumping;
        pc <= (others => '0');
        depth <= (others => '0');
      end if;
    end if;
  end process;

  line_words : process (clk)
  begin
    if rising_edge(clk) then
      if line_held = '0' then
        line_word <= line_data;
        line_held <= line_valid;
      elsif take = '1' then
        line_word <= '0' & line_word(setup_word_bits - 1 downto 1);
        line_index <= line_index + 1;
        if line_index = setup_word_bits - 1 then
          line_held <= '0';
        end if;
      elsif drop = '1' or (passes = '1' and packed_ready = '1') then
        line_index <= (others => '0');
        line_held <= '0';
      end if;
      -- A word of zeros that was begun is given whole.
      filling <= fills and not packed_ready;
      -- Known before the next word, which comes two clocks later at the earliest.
      runs <= or std_ulogic_vector(run);
      if step = loading then
        run <= unsigned(acc(run_bits - 1 downto 0));
      elsif passes = '1' and packed_ready = '1' then
        run <= run - 1;
      end if;
      if reset = '1' then
        line_index <= (others => '0');
        line_held <= '0';
        filling <= '0';
      end if;
    end if;
  end process;

  leaves <= '1' when leaving_bits /= 0 else '0';
  gone <= not leaves and not pads;
  by_two <= '1' when lane_bit /= setup_word_bits - 1 and leaving_bits /= 1 else '0';

  core_words : process (clk)
  begin
    if rising_edge(clk) then
      if setup_ready = '1' then
        full <= '0';
      end if;
      if full = '0' and (leaves = '1' or (pads = '1' and lane_bit /= 0)) then
        lane <= (leaving(0) and leaves) & lane(setup_word_bits - 1 downto 1);
        leaving <= '0' & leaving(setup_word_bits - 1 downto 1);
        if by_two = '1' then
          lane <= (leaving(1 downto 0) and leaves) & lane(setup_word_bits - 1 downto 2);
          leaving <= "00" & leaving(setup_word_bits - 1 downto 2);
        end if;
        lane_bit <= lane_bit + 1 + by_two;
        if leaves = '1' then
          leaving_bits <= leaving_bits - 1 - by_two;
        end if;
        if lane_bit = setup_word_bits - 1 or (lane_bit = setup_word_bits - 2 and by_two = '1') then
          full <= '1';
        end if;
      elsif leaves = '0' and lane_bit = 0 then
        pads <= '0';
      end if;
      if done = '1' and operation = do_put then
        leaving <= std_ulogic_vector(acc(setup_word_bits - 1 downto 0));
        leaving_bits <= left;
      elsif done = '1' and operation = do_align then
        pads <= '1';
      elsif done = '1' and operation = do_word then
        lane <= (others => '0');
        lane(word_width - 1 downto 0) <= std_ulogic_vector(acc(word_low + word_width - 1 downto word_low));
        full <= '1';
      end if;
      if reset = '1' then
        full <= '0';
        pads <= '0';
        leaving_bits <= (others => '0');
        lane_bit <= (others => '0');
      end if;
    end if;
  end process;

  memory_write <= '1' when step = loading and (operation = do_st or operation = do_stq) else '0';
  memory_data <= shifter when operation = do_stq else word;

  store : process (clk)
  begin
    if rising_edge(clk) then
      if memory_write = '1' then
        memory(to_integer(place)) <= std_ulogic_vector(memory_data);
      end if;
      read_data <= memory(to_integer(read_address));
    end if;
  end process;

end architecture;
