-- SPDX-License-Identifier: Apache-2.0
--
-- Addresses of a screen's pixels in memory, in scanline order: address = y * width + x.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

package screen_pkg is

  -- y * width without a multiplier: one adder less than the width has ones.
  function row_address(y : u_unsigned; width : positive; bits : positive) return u_unsigned;

end package;

package body screen_pkg is

  function row_address(y : u_unsigned; width : positive; bits : positive) return u_unsigned is
    variable sum : u_unsigned(bits - 1 downto 0) := (others => '0');
    variable rest : natural := width;
  begin
    for place in 0 to bits - 1 loop
      if rest mod 2 = 1 then
        sum := sum + shift_left(resize(y, bits), place);
      end if;
      rest := rest / 2;
    end loop;
    return sum;
  end function;

end package body;
