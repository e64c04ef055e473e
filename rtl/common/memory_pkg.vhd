-- SPDX-License-Identifier: Apache-2.0
--
-- Widths of memory addresses and counters.

package memory_pkg is

  -- Bits that count to `words` - 1, at least one.
  function address_bits(words : positive) return positive;

end package;

package body memory_pkg is

  function address_bits(words : positive) return positive is
    variable bits : positive := 1;
    variable rest : natural := (words - 1) / 2;
  begin
    while rest > 0 loop
      bits := bits + 1;
      rest := rest / 2;
    end loop;
    return bits;
  end function;

end package body;
