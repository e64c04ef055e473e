// SPDX-License-Identifier: Apache-2.0
//
// Folds many outputs into one pin: a register for each output, then exclusive ors of four, a register after
// each, so that the tree is never slower than what it observes.
module fold_out #(
    parameter integer WIDTH = 8
) (
    input clk,
    input [WIDTH-1:0] data,
    output folded
);
    localparam integer NEXT = (WIDTH + 3) / 4;

    reg [WIDTH-1:0] rank;
    always @(posedge clk) rank <= data;

    generate
        if (WIDTH == 1) begin : last
            assign folded = rank[0];
        end else begin : level
            wire [4*NEXT-1:0] padded = rank;
            wire [NEXT-1:0] parity;
            genvar index;
            for (index = 0; index < NEXT; index = index + 1) begin : group
                assign parity[index] = ^padded[4*index+:4];
            end
            fold_out #(.WIDTH(NEXT)) rest (.clk(clk), .data(parity), .folded(folded));
        end
    endgenerate
endmodule
