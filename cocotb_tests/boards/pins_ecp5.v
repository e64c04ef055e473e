// SPDX-License-Identifier: Apache-2.0
//
// What ECP5's ODDRX1F does, for simulation: both bits are taken with the rising edge; the first goes out
// while the clock is high after the next one, the second while it is low.

module ODDRX1F (
  input SCLK,
  input RST,
  input D0,
  input D1,
  output Q
);

  reg first = 1'b0, second = 1'b0, high = 1'b0, low = 1'b0;

  always @(posedge SCLK) begin
    first <= RST ? 1'b0 : D0;
    second <= RST ? 1'b0 : D1;
    high <= first;
    low <= second;
  end

  assign Q = SCLK ? high : low;

endmodule
