-- SPDX-License-Identifier: Apache-2.0
--
-- The AXI ports of quadshade_axis: where a pixel's fields lie in tdata, and the registers' byte offsets.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/axis.py: change that, then `make rtl`.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;

package axis_pkg is

  constant axi_data_bits : positive := 32;
  constant axi_address_bits : positive := 16;

  -- Byte offsets from the first register, whose address has the highest bit set.
  constant register_identity : natural := 0;
  constant register_status : natural := 4;
  constant register_primitives : natural := 8;
  constant register_pixels : natural := 12;
  constant register_cut_packets : natural := 16;
  constant register_generics : natural := 64;
  constant identity : u_unsigned(axi_data_bits - 1 downto 0) := x"44485351";

  -- What the registers of the generics hold, a word each, in their order.
  function generic_values(f : formats_t) return natural_vector_t;

  -- Bytes of a pixel's fields, which tkeep marks, and of tdata: the next power of two.
  function pixel_bytes(f : formats_t) return positive;
  function pixel_data_bytes(f : formats_t) return positive;

  -- First bit of: column, 0 on the left.
  function x_low(f : formats_t) return natural;
  -- First bit of: scanline, 0 at the top.
  function y_low(f : formats_t) return natural;
  -- First bit of: 0 is near; 0 where the core has no depth.
  function depth_low(f : formats_t) return natural;
  -- First bit of: the channels, 0 or red lowest, each in whole bytes.
  function value_low(f : formats_t) return natural;

end package axis_pkg;

package body axis_pkg is

  function generic_values(f : formats_t) return natural_vector_t is
    constant values : natural_vector_t(0 to 13) := (
      f.num_channels,
      f.max_order,
      f.with_depth,
      f.word_width,
      f.frac_bits,
      f.value_bits,
      f.depth_bits,
      f.subpixel_bits,
      f.coord_bits,
      f.stream_width,
      f.span_depth,
      f.with_shade,
      f.num_specular,
      f.shade_guard_bits
    );
  begin
    return values;
  end function generic_values;

  function x_low(f : formats_t) return natural is
  begin
    return 0;
  end function x_low;

  function y_low(f : formats_t) return natural is
  begin
    return x_low(f) + 16;
  end function y_low;

  function depth_low(f : formats_t) return natural is
  begin
    return y_low(f) + 16;
  end function depth_low;

  function value_low(f : formats_t) return natural is
  begin
    return depth_low(f) + (f.depth_bits + 7) / 8 * 8;
  end function value_low;

  function pixel_bytes(f : formats_t) return positive is
  begin
    return (value_low(f) + emitted_channels(f) * ((f.value_bits + 7) / 8 * 8)) / 8;
  end function pixel_bytes;

  function pixel_data_bytes(f : formats_t) return positive is
    variable bytes : positive := 1;
  begin
    while bytes < pixel_bytes(f) loop
      bytes := 2 * bytes;
    end loop;
    return bytes;
  end function pixel_data_bytes;

end package body axis_pkg;
