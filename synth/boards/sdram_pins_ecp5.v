// SPDX-License-Identifier: Apache-2.0
//
// The pins of a 16-bit SDRAM that is always selected, out of ECP5's cells of the pins.

module sdram_pins (
  input clk_sdram,
  input mask,
  input drive,
  input [15:0] data,
  output [15:0] word,
  output sdram_clk,
  output sdram_cke,
  output sdram_cs_n,
  output [1:0] sdram_dqm,
  inout [15:0] sdram_d
);

  BB data_pins [15:0] (.B(sdram_d), .I(data), .T(!drive), .O(word));
  assign sdram_dqm = {2{mask}};
  assign sdram_cke = 1'b1;
  assign sdram_cs_n = 1'b0;

  // Out of a cell of the pins, so that no way through the fabric is in it.
  ODDRX1F sdram_clk_inst (.SCLK(clk_sdram), .RST(1'b0), .D0(1'b1), .D1(1'b0), .Q(sdram_clk));

endmodule
