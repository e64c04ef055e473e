-- SPDX-License-Identifier: Apache-2.0
--
-- The packed stream: kinds of fields and of channels, and where their widths are.
--
-- Written by scripts/generate_vhdl from model/quadshade/contract/packed_format.py: change it, `make rtl`.

use work.quadshade_pkg.all;

package packed_pkg is

  -- Fields of one bit at a packet's start.
  constant num_raw_fields : positive := 3;

  -- What stands above the bits of a field that are sent: 0, 1, or the highest of them.
  constant fill_zero : natural := 0;
  constant fill_one : natural := 1;
  constant fill_sign : natural := 2;

  -- Kinds of fields, in order, and their fills.
  constant num_packed_kinds : positive := 7;
  constant packed_y : natural := 0;
  constant packed_rows : natural := 1;
  constant packed_column : natural := 2;
  constant packed_error : natural := 3;
  constant packed_step : natural := 4;
  constant packed_increment : natural := 5;
  constant packed_decrement : natural := 6;
  constant packed_fills : natural_vector_t(0 to 6) := (0, 2, 2, 2, 2, 0, 1);
  -- Bits of a field of each kind.
  function packed_kind_bits(f : formats_t) return natural_vector_t;

  -- Kinds of channels; addresses of widths for each, and of the first kind of fields' width.
  constant kind_colour : natural := 0;
  constant kind_depth : natural := 1;
  constant kind_specular : natural := 2;
  constant kind_widths : positive := 16;
  constant field_widths : positive := 24;

  -- of a width: the number of a bit, from 0
  function width_bits(f : formats_t) return positive;
  -- of the address of a width: specular channels' lie behind
  function width_address_bits(f : formats_t) return positive;

end package packed_pkg;

package body packed_pkg is

  function packed_kind_bits(f : formats_t) return natural_vector_t is
    variable bits : natural_vector_t(0 to 6);
  begin
    bits(packed_y) := f.coord_bits;
    bits(packed_rows) := column_bits(f);
    bits(packed_column) := column_bits(f);
    bits(packed_error) := error_bits(f);
    bits(packed_step) := column_bits(f);
    bits(packed_increment) := edge_bits(f);
    bits(packed_decrement) := error_bits(f);
    return bits;
  end function packed_kind_bits;

  function width_bits(f : formats_t) return positive is
  begin
    return 4 + difference_words(f);
  end function width_bits;

  function width_address_bits(f : formats_t) return positive is
  begin
    return 5 + f.with_shade;
  end function width_address_bits;

end package body packed_pkg;
