// SPDX-License-Identifier: Apache-2.0
//
// Icepi Zero, v1.3: the board between its USB serial chip's pins and the monitor's (mini HDMI), its clocks
// made from the 50 MHz crystal.
// Reset after configuration, until the PLL has locked, and while the first button is pressed.

module top (
  input clk_50mhz,
  input uart_rx,
  output uart_tx,
  input button_n,
  // Link, drawing, fault, sending.
  output [3:0] led,
  output [3:0] gpdi_dp
);

  wire clk, clk_shift, locked;

  ecp5_clocks #(.divider(2)) clocks_inst (
    .crystal(clk_50mhz), .clk(clk), .clk_shift(clk_shift), .locked(locked)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || !button_n), .reset(reset));

  wire video_next;
  wire [29:0] video_words;
  wire [7:0] lights;
  board board_inst (
    .clk(clk), .reset(reset), .rx(uart_rx), .tx(uart_tx), .led(lights),
    .video_next(video_next), .video_words(video_words)
  );

  assign led = lights[3:0];

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(gpdi_dp), .gpdi_dn()
  );

endmodule
