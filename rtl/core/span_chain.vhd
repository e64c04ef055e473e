-- SPDX-License-Identifier: Apache-2.0
--
-- Elastic chain of spans between edge walker and span walker: each stage moves on when there is room ahead,
-- so empty scanlines hide behind full spans. Registers only, no multiplexer: data never skips a stage.
--
-- Model: span_chain.py.  Test: test_span_chain.py.  Latency: `depth` cycles.  One span per cycle.
-- A FIFO in distributed RAM was weighed: 1.5 LUT a bit on ECP5 where this takes none.

library ieee;
use ieee.std_logic_1164.all;

entity span_chain is
  generic (
    data_bits : positive := 8;
    depth : positive := 3
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;
    -- A span is in some stage.
    busy : out std_ulogic;
    input_valid : in std_ulogic;
    input_ready : out std_ulogic;
    -- In the next cycle every stage will hold a span.
    full_next : out std_ulogic;
    input_data : in std_ulogic_vector(data_bits - 1 downto 0);
    output_valid : out std_ulogic;
    output_ready : in std_ulogic;
    output_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of span_chain is

  type stages_t is array (0 to depth) of std_ulogic_vector(data_bits - 1 downto 0);
  signal data : stages_t := (others => (others => '0'));
  -- Element 0 is the input itself.
  signal valid : std_ulogic_vector(0 to depth) := (others => '0');
  signal held : std_ulogic_vector(1 to depth) := (others => '0');
  signal moves : std_ulogic_vector(1 to depth + 1);
  -- All stages hold a span: a register, because what is made from it enables a whole lane.
  signal full : std_ulogic := '0';
  signal filling : std_ulogic;

  function others_held(v : std_ulogic_vector; but : positive) return std_ulogic is
    variable all_held : std_ulogic := '1';
  begin
    for stage in 1 to depth loop
      if stage /= but then
        all_held := all_held and v(stage);
      end if;
    end loop;
    return all_held;
  end function;

begin

  valid <= input_valid & held;
  data(0) <= input_data;
  moves(depth + 1) <= output_ready;

  stage_gen : for stage in 1 to depth generate
    signal word : std_ulogic_vector(data_bits - 1 downto 0) := (others => '0');
  begin
    moves(stage) <= moves(stage + 1) or not held(stage);
    data(stage) <= word;

    advance : process (clk)
    begin
      if rising_edge(clk) then
        if moves(stage) = '1' then
          word <= data(stage - 1);
          held(stage) <= valid(stage - 1);
        end if;
        if reset = '1' then
          held(stage) <= '0';
        end if;
      end if;
    end process;
  end generate;

  occupancy : process (all)
    variable one_free : std_ulogic;
  begin
    one_free := '0';
    for free in 1 to depth loop
      one_free := one_free or (not held(free) and others_held(held, free));
    end loop;
    if full = '1' then
      filling <= input_valid or not output_ready;
    else
      filling <= one_free and input_valid and not (output_ready and held(depth));
    end if;
  end process;

  full_stage : process (clk)
  begin
    if rising_edge(clk) then
      full <= filling;
      if reset = '1' then
        full <= '0';
      end if;
    end if;
  end process;

  full_next <= filling;
  busy <= or held;
  input_ready <= output_ready or not full;
  output_valid <= held(depth);
  output_data <= data(depth);

end architecture;
