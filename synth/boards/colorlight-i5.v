// SPDX-License-Identifier: Apache-2.0
//
// Colorlight i5, v7.0, on the extension board by Muse Lab: the board between the pins of that one's USB chip
// and its monitor, its clocks made from the 25 MHz crystal.
// Reset after configuration, until the PLL has locked, and while the reset button is pressed.

module top (
  input clk_25mhz,
  input uart_rx,
  output uart_tx,
  input button_reset_n,
  // On the module: link.
  output led_n,
  output [3:0] gpdi_dp
);

  wire clk, clk_shift, locked;

  ecp5_clocks #(.divider(4)) clocks_inst (
    .crystal(clk_25mhz), .clk(clk), .clk_shift(clk_shift), .locked(locked)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || !button_reset_n), .reset(reset));

  wire video_next;
  wire [29:0] video_words;
  wire [7:0] lights;
  board board_inst (
    .clk(clk), .reset(reset), .rx(uart_rx), .tx(uart_tx), .led(lights),
    .video_next(video_next), .video_words(video_words)
  );

  assign led_n = !lights[0];

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(gpdi_dp), .gpdi_dn()
  );

endmodule
