// SPDX-License-Identifier: Apache-2.0
//
// Two bits a cycle on a pair of Gowin's pins for LVDS, bits[0] first.

module ddr_pair (
  input clk,
  input [1:0] bits,
  output p,
  output n
);

  wire level;
  ODDR register (.CLK(clk), .D0(bits[0]), .D1(bits[1]), .TX(1'b0), .Q0(level), .Q1());
  TLVDS_OBUF pins (.I(level), .O(p), .OB(n));

endmodule
