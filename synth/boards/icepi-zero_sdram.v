// SPDX-License-Identifier: Apache-2.0
//
// Icepi Zero, v1.3, with its pictures in its SDRAM: as icepi-zero.v, and the chip's pins.

module top (
  input clk_50mhz,
  input uart_rx,
  output uart_tx,
  input button_n,
  // Link, drawing, fault, sending.
  output [3:0] led,
  output [3:0] gpdi_dp,
  output sdram_clk,
  output sdram_cke,
  output sdram_cs_n,
  output sdram_ras_n,
  output sdram_cas_n,
  output sdram_we_n,
  output [1:0] sdram_ba,
  output [1:0] sdram_dqm,
  output [12:0] sdram_a,
  inout [15:0] sdram_d
);

  wire clk, clk_shift, clk_sdram, locked;

  ecp5_clocks #(.divider(2), .sdram("ENABLED")) clocks_inst (
    .crystal(clk_50mhz), .clk(clk), .clk_shift(clk_shift), .clk_sdram(clk_sdram), .locked(locked)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || !button_n), .reset(reset));

  wire video_next, sdram_mask, sdram_drive;
  wire [29:0] video_words;
  wire [15:0] sdram_data, sdram_word;
  wire [7:0] lights;
  board board_inst (
    .clk(clk), .reset(reset), .rx(uart_rx), .tx(uart_tx), .led(lights),
    .video_next(video_next), .video_words(video_words),
    .sdram_command({sdram_ras_n, sdram_cas_n, sdram_we_n}), .sdram_mask(sdram_mask), .sdram_bank(sdram_ba),
    .sdram_address(sdram_a), .sdram_drive(sdram_drive), .sdram_data_out(sdram_data),
    .sdram_data_in(sdram_word)
  );

  sdram_pins sdram_pins_inst (
    .clk_sdram(clk_sdram), .mask(sdram_mask), .drive(sdram_drive), .data(sdram_data), .word(sdram_word),
    .sdram_clk(sdram_clk), .sdram_cke(sdram_cke), .sdram_cs_n(sdram_cs_n), .sdram_dqm(sdram_dqm),
    .sdram_d(sdram_d)
  );

  assign led = lights[3:0];

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(gpdi_dp), .gpdi_dn()
  );

endmodule
