// SPDX-License-Identifier: Apache-2.0
//
// Reset for 255 clocks after configuration and after `hold`, which is any level from outside.

module power_on_reset (
  input clk,
  input hold,
  output reg reset = 1'b1
);

  reg [1:0] held = 2'b11;
  reg [7:0] count = 8'd0;

  always @(posedge clk) begin
    held <= {held[0], hold};
    reset <= count != 8'hff;
    if (held[1]) count <= 8'd0;
    else if (count != 8'hff) count <= count + 8'd1;
  end

endmodule
