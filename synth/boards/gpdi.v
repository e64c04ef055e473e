// SPDX-License-Identifier: Apache-2.0
//
// Three data channels and a clock of TMDS on pairs of pins: ten bits of a pixel in 40 ns, two in each cycle
// of 125 MHz. A pair is the device's: ddr_pair_ecp5.v or ddr_pair_gowin.v.
//
// Both clocks come from one PLL, so five cycles of the one always take as long as a pixel's clocks of the
// other, and what is in step once stays in step. The words stand still for 40 ns; they are taken 16 to 32 ns
// after they changed, whatever the phase between the clocks.

module gpdi (
  input clk,
  // From either clock; afterwards both are brought in step anew.
  input reset,
  // High in the cycle before the words change.
  input word_next,
  // Of TMDS data channels 0 (blue), 1 and 2; bit 0 goes first.
  input [29:0] words,
  input clk_shift,
  output [3:0] gpdi_dp,
  output [3:0] gpdi_dn
);

  reg changed = 1'b0;
  always @(posedge clk) if (word_next) changed <= !changed;

  reg [2:0] seen = 3'b000;
  reg [1:0] waits = 2'b11;
  reg in_step = 1'b0;
  reg [4:0] turn = 5'b00001;
  reg [9:0] lane_0 = 10'd0, lane_1 = 10'd0, lane_2 = 10'd0, lane_3 = 10'd0;

  always @(posedge clk_shift) begin
    seen <= {seen[1:0], changed};
    waits <= {waits[0], reset};
    turn <= {turn[3:0], turn[4]};
    // The first change begins the turns.
    if (!in_step && seen[2] != seen[1]) begin
      in_step <= 1'b1;
      turn <= 5'b00001;
    end
    if (waits[1]) in_step <= 1'b0;
    lane_0 <= {2'b00, lane_0[9:2]};
    lane_1 <= {2'b00, lane_1[9:2]};
    lane_2 <= {2'b00, lane_2[9:2]};
    lane_3 <= {2'b00, lane_3[9:2]};
    if (turn[0] && in_step) begin
      lane_0 <= words[9:0];
      lane_1 <= words[19:10];
      lane_2 <= words[29:20];
      lane_3 <= 10'b0000011111;
    end
  end

  ddr_pair lane_0_inst (.clk(clk_shift), .bits(lane_0[1:0]), .p(gpdi_dp[0]), .n(gpdi_dn[0]));
  ddr_pair lane_1_inst (.clk(clk_shift), .bits(lane_1[1:0]), .p(gpdi_dp[1]), .n(gpdi_dn[1]));
  ddr_pair lane_2_inst (.clk(clk_shift), .bits(lane_2[1:0]), .p(gpdi_dp[2]), .n(gpdi_dn[2]));
  ddr_pair lane_3_inst (.clk(clk_shift), .bits(lane_3[1:0]), .p(gpdi_dp[3]), .n(gpdi_dn[3]));

endmodule
