-- SPDX-License-Identifier: Apache-2.0
--
-- The handshake state that moves a lane: when the stages up to the chain walk, when a span is taken, when
-- pixels advance. Every lane has its own copy, so each enable is one LUT behind registers that stand near it.
--
-- Model: lane_handshake.py.  Test: test_lane_handshake.py.  Latency: 1 cycle.
-- What decides the next cycle is worked out in this one. At first the enables combined it, which put three
-- LUTs in front of a lane's clock enables.

library ieee;
use ieee.std_logic_1164.all;

entity lane_handshake is
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    -- From the edge walker: a span is in the last stage but one.
    walk_span_coming : in std_ulogic;
    -- From this lane's span chain: in the next cycle it is full.
    chain_full_next : in std_ulogic;
    span_valid : in std_ulogic;
    -- From the span walker: the waiting span has one pixel; the pixel after the one shown is its span's last.
    span_single : in std_ulogic;
    span_ending : in std_ulogic;
    -- From the output: what makes the skid buffer's ready.
    clamped_valid : in std_ulogic;
    emitted_valid : in std_ulogic;
    emitted_ready : in std_ulogic;

    -- The edge walker's stages move; a span stands in the last one.
    walk : out std_ulogic;
    walked_valid : out std_ulogic;
    -- The chain's end may move.
    span_taken : out std_ulogic;
    -- With advance, pixels load what stands at the chain's end, else they step. Where no span stands there,
    -- no pixel is valid: a register can say it, which the carry chains behind it need.
    load : out std_ulogic;
    advance : out std_ulogic
  );
end entity;

architecture rtl of lane_handshake is

  signal walked : std_ulogic := '0';
  signal wanted, advancing, taking : std_ulogic := '1';
  signal walking : std_ulogic := '1';
  signal loading : std_ulogic;

begin

  loading <= wanted and span_valid;

  state : process (clk)
    variable walked_next, wanted_next, advancing_next, taking_next : std_ulogic;
  begin
    if rising_edge(clk) then
      walked_next := walked;
      if walking = '1' then
        walked_next := walk_span_coming;
      end if;

      wanted_next := wanted;
      if advancing = '1' then
        if loading = '1' then
          wanted_next := span_single;
        else
          wanted_next := wanted or span_ending;
        end if;
      end if;
      advancing_next := not emitted_valid or emitted_ready or (advancing and not clamped_valid);

      taking_next := wanted_next and advancing_next;

      walked <= walked_next;
      wanted <= wanted_next;
      advancing <= advancing_next;
      taking <= taking_next;
      -- A span that stands in the last stage needs room in the chain.
      walking <= not walked_next or not chain_full_next or taking_next;

      if reset = '1' then
        walked <= '0';
        wanted <= '1';
        advancing <= '1';
        taking <= '1';
        walking <= '1';
      end if;
    end if;
  end process;

  walk <= walking;
  walked_valid <= walked;
  span_taken <= taking;
  load <= wanted;
  advance <= advancing;

end architecture;
