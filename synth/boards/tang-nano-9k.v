// SPDX-License-Identifier: Apache-2.0
//
// Tang Nano 9K: the board between the pins of its USB chip and the monitor's (HDMI), at 50.4 MHz from the
// 27 MHz crystal: two clocks for a pixel of the monitor.
// Reset after configuration, until the PLL has locked, and while the button at pin 4 is pressed.

module top (
  input clk_27mhz,
  input uart_rx,
  output uart_tx,
  input button_n,
  // Link, drawing, fault, sending, and two that stay off.
  output [5:0] led_n,
  output [3:0] tmds_p,
  output [3:0] tmds_n
);

  wire clk, clk_shift, locked;

  gowin_clocks #(.DEVICE("GW1NR-9C")) clocks_inst (
    .crystal(clk_27mhz), .clk(clk), .clk_shift(clk_shift), .locked(locked)
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

  assign led_n = ~lights[5:0];

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(tmds_p), .gpdi_dn(tmds_n)
  );

endmodule
