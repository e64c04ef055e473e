// SPDX-License-Identifier: Apache-2.0
//
// Tang Nano 20K, with its pictures in the SDRAM of its package: as tang-nano-20k.v, and that chip's pins.
// Half of its 32 data pins are used: 640 x 480 needs no more.

module top (
  input clk_27mhz,
  input uart_rx,
  output uart_tx,
  input button_s1,
  // Link, drawing, fault, sending, and two that stay off.
  output [5:0] led_n,
  output [3:0] tmds_p,
  output [3:0] tmds_n,
  output O_sdram_clk,
  output O_sdram_cke,
  output O_sdram_cs_n,
  output O_sdram_ras_n,
  output O_sdram_cas_n,
  output O_sdram_wen_n,
  output [1:0] O_sdram_ba,
  output [3:0] O_sdram_dqm,
  output [10:0] O_sdram_addr,
  inout [15:0] IO_sdram_dq
);

  wire clk, clk_shift, locked;

  gowin_clocks clocks_inst (.crystal(clk_27mhz), .clk(clk), .clk_shift(clk_shift), .locked(locked));

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || button_s1), .reset(reset));

  wire video_next, sdram_mask, sdram_drive;
  wire [15:0] sdram_data, sdram_pin;
  reg [15:0] sdram_word;
  wire [29:0] video_words;
  wire [7:0] lights;
  board board_inst (
    .clk(clk), .reset(reset), .rx(uart_rx), .tx(uart_tx), .led(lights),
    .video_next(video_next), .video_words(video_words),
    .sdram_command({O_sdram_ras_n, O_sdram_cas_n, O_sdram_wen_n}), .sdram_mask(sdram_mask),
    .sdram_bank(O_sdram_ba), .sdram_address(O_sdram_addr), .sdram_drive(sdram_drive),
    .sdram_data_out(sdram_data), .sdram_data_in(sdram_word)
  );

  // The chip's edges are in the middle of the board's cycles. What it says at one stands until 2.5 ns after
  // the next, where it is taken, half a cycle before the board does.
  assign O_sdram_clk = !clk;
  always @(negedge clk) sdram_word <= sdram_pin;
  IOBUF data_pins [15:0] (.IO(IO_sdram_dq), .I(sdram_data), .OEN(!sdram_drive), .O(sdram_pin));
  assign O_sdram_dqm = {2'b11, {2{sdram_mask}}};
  assign O_sdram_cke = 1'b1;
  assign O_sdram_cs_n = 1'b0;

  assign led_n = ~lights[5:0];

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(tmds_p), .gpdi_dn(tmds_n)
  );

endmodule
