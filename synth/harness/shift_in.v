// SPDX-License-Identifier: Apache-2.0
//
// Drives many inputs from one pin: a shift register, and a second rank that gives each input a function of
// its own (the exclusive or of two neighbours), so that no two are merged and no logic behind them is lost.
module shift_in #(
    parameter integer WIDTH = 8
) (
    input clk,
    input serial,
    output reg [WIDTH-1:0] data
);
    reg [WIDTH-1:0] chain;

    always @(posedge clk) begin
        chain <= {chain[WIDTH-2:0], serial};
        data <= chain ^ {chain[WIDTH-2:0], serial};
    end
endmodule
