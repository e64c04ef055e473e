// SPDX-License-Identifier: Apache-2.0
//
// Two bits a cycle on a pair of ECP5's pins, bits[0] first. The pad of `p` drives its neighbour as well.

module ddr_pair (
  input clk,
  input [1:0] bits,
  output p,
  output n
);

  assign n = 1'b0;
  ODDRX1F register (.SCLK(clk), .RST(1'b0), .D0(bits[0]), .D1(bits[1]), .Q(p));

endmodule
