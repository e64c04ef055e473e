-- SPDX-License-Identifier: Apache-2.0
--
-- Addresses of a screen's pixels in memory, in scanline order: address = y * width + x. Colours in fewer bits
-- than a byte, by ordered dithering; framebuffer.py says the same.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

package screen_pkg is

  -- y * width without a multiplier: one adder less than the width has ones.
  function row_address(y : u_unsigned; width : positive; bits : positive) return u_unsigned;

  -- Bits that are kept of a channel: colour_bits, but of channel 1 five where they are 6, and six where they
  -- are 5. Of all channels.
  function channel_bits(channel : natural; colour_bits : positive) return positive;
  function kept_bits(value_bits : positive; colour_bits : positive) return positive;

  -- Bayer's threshold of a place, 0 to 15: each once in a square of 4 by 4.
  function threshold(x : u_unsigned; y : u_unsigned) return u_unsigned;

  -- Of a byte v and n bits: (v - v / 2**n + the threshold's top 8 - n bits) / 2**(8 - n), both rounded down.
  -- A byte that n bits can show comes back as it was, at every place.
  function dithered(value : u_unsigned; level : u_unsigned; colour_bits : positive) return u_unsigned;
  -- Bytes of what is kept: its bits, and they again below, as many as there is room for.
  function expanded(kept : u_unsigned; value_bits : positive; colour_bits : positive) return u_unsigned;

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

  function channel_bits(channel : natural; colour_bits : positive) return positive is
  begin
    if channel = 1 and (colour_bits = 6 or colour_bits = 5) then
      return 11 - colour_bits;
    end if;
    return colour_bits;
  end function;

  function kept_bits(value_bits : positive; colour_bits : positive) return positive is
    variable sum : natural := 0;
  begin
    if colour_bits = 8 then
      return value_bits;
    end if;
    for channel in 0 to value_bits / 8 - 1 loop
      sum := sum + channel_bits(channel, colour_bits);
    end loop;
    return sum;
  end function;

  function threshold(x : u_unsigned; y : u_unsigned) return u_unsigned is
    variable column, row : u_unsigned(1 downto 0);
  begin
    column := resize(x, 2);
    row := resize(y, 2);
    return (column(0) xor row(0)) & row(0) & (column(1) xor row(1)) & row(1);
  end function;

  function dithered(value : u_unsigned; level : u_unsigned; colour_bits : positive) return u_unsigned is
    variable kept : u_unsigned(kept_bits(value'length, colour_bits) - 1 downto 0) := (others => '0');
    variable byte : u_unsigned(7 downto 0);
    variable part : u_unsigned(3 downto 0);
  begin
    if colour_bits = 8 then
      return value;
    end if;
    for channel in value'length / 8 - 1 downto 0 loop
      byte := resize(shift_right(value, 8 * channel), 8);
      part := shift_right(level, channel_bits(channel, colour_bits) - 4);
      byte := byte - shift_right(byte, channel_bits(channel, colour_bits)) + resize(part, 8);
      kept := shift_left(kept, channel_bits(channel, colour_bits))
        or resize(shift_right(byte, 8 - channel_bits(channel, colour_bits)), kept'length);
    end loop;
    return kept;
  end function;

  function expanded(kept : u_unsigned; value_bits : positive; colour_bits : positive) return u_unsigned is
    variable value : u_unsigned(value_bits - 1 downto 0) := (others => '0');
    variable rest : u_unsigned(kept'length - 1 downto 0);
    variable byte, mask : u_unsigned(7 downto 0);
  begin
    if colour_bits = 8 then
      return kept;
    end if;
    rest := kept;
    for channel in 0 to value_bits / 8 - 1 loop
      mask := shift_right(to_unsigned(255, 8), 8 - channel_bits(channel, colour_bits));
      byte := resize(rest, 8) and mask;
      byte := shift_left(byte, 8 - channel_bits(channel, colour_bits))
        or shift_right(byte, 2 * channel_bits(channel, colour_bits) - 8);
      value := value or shift_left(resize(byte, value_bits), 8 * channel);
      rest := shift_right(rest, channel_bits(channel, colour_bits));
    end loop;
    return value;
  end function;

end package body;
