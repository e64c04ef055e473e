// SPDX-License-Identifier: Apache-2.0
//
// ULX3S, v2 and v3, with its pictures in its SDRAM: as ulx3s.v, and the chip's pins.

module top (
  input clk_25mhz,
  input ftdi_txd,
  output ftdi_rxd,
  input button_power_n,
  output [7:0] led,
  output [3:0] gpdi_dp,
  output wifi_gpio0,
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

  // Tied high, so that the ESP32 stays out of its loader and keeps the FPGA's configuration.
  assign wifi_gpio0 = 1'b1;

  wire clk, clk_shift, clk_sdram, locked;

  ecp5_clocks #(.divider(4), .sdram("ENABLED")) clocks_inst (
    .crystal(clk_25mhz), .clk(clk), .clk_shift(clk_shift), .clk_sdram(clk_sdram), .locked(locked)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || !button_power_n), .reset(reset));

  wire video_next, sdram_mask, sdram_drive;
  wire [29:0] video_words;
  wire [15:0] sdram_data, sdram_word;
  board board_inst (
    .clk(clk), .reset(reset), .rx(ftdi_txd), .tx(ftdi_rxd), .led(led),
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

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(gpdi_dp), .gpdi_dn()
  );

endmodule
