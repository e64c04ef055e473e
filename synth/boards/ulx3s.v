// SPDX-License-Identifier: Apache-2.0
//
// ULX3S, v2 and v3: the board between its USB serial chip's pins and the monitor's (GPDI), its clocks made
// from the 25 MHz crystal.
// Reset after configuration, until the PLL has locked, and while button PWR is pressed.

module top (
  input clk_25mhz,
  input ftdi_txd,
  output ftdi_rxd,
  input button_power_n,
  output [7:0] led,
  output [3:0] gpdi_dp,
  output wifi_gpio0
);

  // Tied high, so that the ESP32 stays out of its loader and keeps the FPGA's configuration.
  assign wifi_gpio0 = 1'b1;

  wire clk, clk_shift, locked;

  ecp5_clocks #(.divider(4)) clocks_inst (
    .crystal(clk_25mhz), .clk(clk), .clk_shift(clk_shift), .locked(locked)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || !button_power_n), .reset(reset));

  wire video_next;
  wire [29:0] video_words;
  board board_inst (
    .clk(clk), .reset(reset), .rx(ftdi_txd), .tx(ftdi_rxd), .led(led),
    .video_next(video_next), .video_words(video_words)
  );

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(gpdi_dp), .gpdi_dn()
  );

endmodule
