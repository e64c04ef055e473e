-- SPDX-License-Identifier: Apache-2.0
--
-- What vertex_unpacker counts with: an accumulator, an operand and a shift register, and one adder. A step
-- is a sum, two bits of a factor (Booth), one of a quotient (non-restoring), one of a shift.
--   muli: acc += operand * shifter, operand goes up;  mulf: (acc + operand * shifter) / 4**steps, acc down
--
-- Model: vertex_alu.py.  Test: test_vertex_alu.py.  Latency: 1 cycle from a step.  A step per cycle.
-- A multiplier of one bit a step lost: half the cells of the recoding saved, a third more cycles of a packet.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.vertex_pkg.all;

entity vertex_alu is
  port (
    clk : in std_ulogic;
    -- A number of the program's operations.
    operation : in u_unsigned(operation_bits - 1 downto 0);
    -- The operand is there; what ld, ldq, add and sub make of it is there a cycle later, without a step.
    load : in std_ulogic;
    operand : in u_signed(vertex_width - 1 downto 0);
    -- In the cycles after load: the operation takes a step; a shift one of four bits.
    step : in std_ulogic;
    by_four : in std_ulogic;
    -- What get shifts in.
    line_bit : in std_ulogic;
    -- Two bits more than a word of the memory hold twice the operand beside a sum.
    acc : out u_signed(vertex_width + 1 downto 0);
    shifter : out u_signed(vertex_width - 1 downto 0);
    -- What the accumulator is or, behind ld, becomes: the word that st writes.
    word : out u_signed(vertex_width - 1 downto 0);
    is_zero : out std_ulogic;
    -- What is left of the factor adds nothing after this step.
    spent : out std_ulogic
  );
end entity;

architecture rtl of vertex_alu is

  constant width : positive := vertex_width;
  constant sum_bits : positive := width + 2;
  subtype number_t is u_signed(width - 1 downto 0);
  subtype sum_t is u_signed(sum_bits - 1 downto 0);

  signal sum, ahead, first, second, halved, other : sum_t;
  signal use_sum, use_quarter : std_ulogic;
  signal value : sum_t := (others => '0');
  signal number, factor, factor_now : number_t := (others => '0');
  -- What the adder makes of the operand: nothing, twice it, its complement.
  signal none, double, negate : std_ulogic := '0';
  -- The operation, one hot.
  signal is_muli, is_mulf, is_div, is_shift, is_get, is_halving, is_fold, is_ones : std_ulogic := '0';
  -- The operand has just come: of a sum, of ld, of ldq; the factor's bits but the lowest are the same.
  signal sums, copies, sets_factor, same : std_ulogic := '0';

begin

  acc <= value;
  shifter <= factor;
  word <= number when copies = '1' else value(width - 1 downto 0);
  factor_now <= number when sets_factor = '1' else factor;
  is_zero <= '1' when unsigned(value(zero_bits - 1 downto 0)) = 0 else '0';
  spent <= is_muli and same;

  ahead <= value(sum_bits - 2 downto 0)
    & ((is_div and factor(width - 1)) or (not is_div and is_get and line_bit));
  first <= ahead when is_div = '1' else value;
  halved <= value(sum_bits - 1) & value(sum_bits - 1 downto 1);

  recoded : process (all)
  begin
    second <= resize(number, sum_bits);
    if none = '1' then
      second <= (others => '0');
    elsif double = '1' then
      second <= number(width - 1) & number & '0';
    end if;
  end process;

  add : process (all)
    variable term : sum_t;
    variable wide : u_signed(sum_bits downto 0);
  begin
    term := second;
    if negate = '1' then
      term := not second;
    end if;
    wide := (first & '1') + (term & negate);
    sum <= wide(sum_bits downto 1);
  end process;

  -- What the accumulator becomes without the sum, which comes late.
  others_choice : process (all)
  begin
    other <= value;
    if step = '1' then
      if is_shift = '1' and by_four = '1' then
        other <= shift_left(value, 4);
      elsif is_shift = '1' then
        other <= ahead;
      elsif is_halving = '1' and by_four = '1' then
        other <= resize(value(sum_bits - 1 downto 4), sum_bits);
      elsif is_halving = '1' then
        other <= halved;
      elsif is_fold = '1' then
        other <= halved;
        if value(0) = '1' then
          other <= not halved;
        end if;
      elsif is_ones = '1' then
        other(3 downto 0) <= value(3 downto 0) + 1;
      end if;
    end if;
  end process;

  use_sum <= sums or (step and (is_muli or is_div));
  use_quarter <= step and is_mulf;

  registers : process (clk)
    -- Two bits of the factor and the one below.
    variable high, middle, low : std_ulogic;
  begin
    if rising_edge(clk) then
      if load = '1' then
        number <= operand;
        is_muli <= '0';
        is_mulf <= '0';
        is_div <= '0';
        is_shift <= '0';
        is_get <= '0';
        is_halving <= '0';
        is_fold <= '0';
        is_ones <= '0';
        none <= '0';
        double <= '0';
        negate <= '0';
        if operation = do_ones then
          is_ones <= '1';
        elsif operation = do_sub then
          negate <= '1';
        elsif operation = do_muli then
          is_muli <= '1';
        elsif operation = do_mulf then
          is_mulf <= '1';
        elsif operation = do_div then
          is_div <= '1';
          negate <= '1';
        elsif operation = do_shl then
          is_shift <= '1';
        elsif operation = do_get or operation = do_take then
          is_shift <= '1';
          is_get <= '1';
        elsif operation = do_shr then
          is_halving <= '1';
        elsif operation = do_fold then
          is_fold <= '1';
        end if;
      elsif step = '1' then
        if is_muli = '1' then
          number <= number(width - 3 downto 0) & "00";
        end if;
        if is_div = '1' then
          -- Below zero the operand comes back with the next bit.
          negate <= not sum(sum_bits - 1);
        end if;
      end if;

      if sets_factor = '1' then
        factor <= number;
      elsif step = '1' and (is_muli = '1' or is_mulf = '1') then
        factor <= "00" & factor(width - 1 downto 2);
      elsif step = '1' and is_div = '1' then
        factor <= factor(width - 2 downto 0) & not sum(sum_bits - 1);
      end if;

      if step = '1' then
        same <= (and std_ulogic_vector(factor(spent_bits + 1 downto 3)))
          or not (or std_ulogic_vector(factor(spent_bits + 1 downto 3)));
      else
        same <= (and std_ulogic_vector(factor_now(spent_bits - 1 downto 1)))
          or not (or std_ulogic_vector(factor_now(spent_bits - 1 downto 1)));
      end if;

      sums <= '0';
      copies <= '0';
      sets_factor <= '0';
      if load = '1' then
        if operation = do_add or operation = do_sub then
          sums <= '1';
        elsif operation = do_ld then
          copies <= '1';
        elsif operation = do_ldq then
          sets_factor <= '1';
        end if;
      end if;
      value <= other;
      if copies = '1' then
        value <= resize(number, sum_bits);
      elsif use_sum = '1' then
        value <= sum;
        if is_div = '0' then
          value(sum_bits - 1 downto width) <= (others => sum(width - 1));
        end if;
      elsif use_quarter = '1' then
        value <= sum(sum_bits - 1) & sum(sum_bits - 1) & sum(sum_bits - 1 downto 2);
      end if;
      if load = '1' and (operation = do_ones or operation = do_take) then
        value <= (others => '0');
      elsif load = '1' and operation = do_ldr then
        value <= resize(factor, sum_bits);
      end if;

      -- Booth: minus twice the high bit, plus the middle and the low one.
      if load = '1' then
        high := factor_now(1);
        middle := factor_now(0);
        low := '0';
      else
        high := factor(3);
        middle := factor(2);
        low := factor(1);
      end if;
      if (load = '1' and (operation = do_muli or operation = do_mulf))
        or (load = '0' and step = '1' and (is_muli = '1' or is_mulf = '1')) then
        none <= not ((high xor middle) or (middle xor low));
        double <= not (middle xor low);
        negate <= high;
      end if;
    end if;
  end process;

end architecture;
