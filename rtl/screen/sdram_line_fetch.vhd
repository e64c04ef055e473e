-- SPDX-License-Identifier: Apache-2.0
--
-- Scanlines of a picture in an SDRAM for scan_out, in runs of sdram_controller's first port: when a scanline
-- is wanted, all of its runs are asked for, one after the other. That port waits for one run and a refresh at
-- most, so a scanline is there after a known number of cycles, and scan_out's two line buffers are the FIFO.
--
-- Model: sdram_line_fetch.py.  Test: test_sdram_line_fetch.py.  Latency: 1 cycle.
-- Throughput: a run as soon as one is over.
-- A FIFO beside the line buffers was calculated first: it is one block RAM more, for scanlines that are as
-- early without it.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity sdram_line_fetch is
  generic (
    -- A multiple of run_words.
    width : positive := 640;
    height : positive := 480;
    run_words : positive := 64
  );
  port (
    clk : in std_ulogic;
    reset : in std_ulogic;

    -- The next scanline is wanted, which is the picture's first one; those before are all there.
    line_start : in std_ulogic;
    line_first : in std_ulogic;
    -- The plane of values that is shown.
    plane : in std_ulogic;

    -- Of sdram_controller's first port; an address is plane, y, x.
    run_valid : out std_ulogic;
    run_ready : in std_ulogic;
    run_address : out u_unsigned(1 + address_bits(height) + address_bits(width) downto 0);
    run_more : out u_unsigned(address_bits(run_words) - 1 downto 0)
  );
end entity;

architecture rtl of sdram_line_fetch is

  constant index_bits : positive := address_bits(run_words);
  constant block_bits : positive := address_bits(width) - index_bits;
  constant line_bits : positive := address_bits(height);

  signal asks : std_ulogic := '0';
  signal row : u_unsigned(line_bits - 1 downto 0) := (others => '0');
  signal run : u_unsigned(block_bits - 1 downto 0) := (others => '0');

begin

  assert width mod run_words = 0 and 2**index_bits = run_words and width > run_words
    report "sdram_line_fetch: width is " & integer'image(width) & ", must be more than one run of "
      & integer'image(run_words) & " words, a power of two"
    severity failure;

  ask : process (clk)
  begin
    if rising_edge(clk) then
      if asks = '1' and run_ready = '1' then
        run <= run + 1;
        if run = width / run_words - 1 then
          asks <= '0';
        end if;
      end if;
      if line_start = '1' then
        asks <= '1';
        run <= (others => '0');
        row <= row + 1;
        if line_first = '1' then
          row <= (others => '0');
        end if;
      end if;
      if reset = '1' then
        asks <= '0';
        row <= (others => '0');
      end if;
    end if;
  end process;

  run_valid <= asks;
  run_address <= '0' & plane & row & run & to_unsigned(0, index_bits);
  run_more <= (others => '1');

end architecture;
