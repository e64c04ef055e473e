// SPDX-License-Identifier: Apache-2.0
//
// What Gowin's ODDR and TLVDS_OBUF do, for simulation: both bits are taken with the rising edge; the first
// goes out while the clock is high after the next one, the second while it is low.

module ODDR (
  input D0,
  input D1,
  input TX,
  input CLK,
  output Q0,
  output Q1
);

  reg first = 1'b0, second = 1'b0, high = 1'b0, low = 1'b0;

  always @(posedge CLK) begin
    first <= D0;
    second <= D1;
    high <= first;
    low <= second;
  end

  assign Q0 = CLK ? high : low;
  assign Q1 = TX;

endmodule

module TLVDS_OBUF (
  input I,
  output O,
  output OB
);

  assign O = I;
  assign OB = !I;

endmodule
