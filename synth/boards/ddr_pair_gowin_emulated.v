// SPDX-License-Identifier: Apache-2.0
//
// Two bits a cycle on a pair of Gowin's pins that are no true LVDS: two levels, one the inverse of the other.
// bits[0] goes first.

module ddr_pair (
  input clk,
  input [1:0] bits,
  output p,
  output n
);

  wire level;
  ODDR register (.CLK(clk), .D0(bits[0]), .D1(bits[1]), .TX(1'b0), .Q0(level), .Q1());
  ELVDS_OBUF pins (.I(level), .O(p), .OB(n));

endmodule
