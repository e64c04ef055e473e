// SPDX-License-Identifier: Apache-2.0
//
// Tang Nano 20K: the board between the pins of its USB chip and the monitor's (HDMI), at 50.4 MHz from the
// 27 MHz crystal: two clocks for a pixel of the monitor.
// Reset after configuration, until the PLL has locked, and while button S1 is pressed.

module top (
  input clk_27mhz,
  input uart_rx,
  output uart_tx,
  input button_s1,
  // Link, drawing, fault, sending, and two that stay off.
  output [5:0] led_n,
  output [3:0] tmds_p,
  output [3:0] tmds_n
);

  wire clk, clk_shift, locked;

  // 27 MHz * 28 / 3 = 252 MHz, the oscillator at twice that (500 to 1250 are allowed); a half of it moves
  // bits to the monitor, two a cycle, and a fifth is the board's.
  wire clk_pll;

  rPLL #(
    .FCLKIN("27"),
    .DEVICE("GW2AR-18C"),
    .IDIV_SEL(2),
    .FBDIV_SEL(27),
    .ODIV_SEL(2),
    .DYN_SDIV_SEL(2),
    .DYN_IDIV_SEL("false"),
    .DYN_FBDIV_SEL("false"),
    .DYN_ODIV_SEL("false"),
    .DYN_DA_EN("false"),
    .PSDA_SEL("0000"),
    .DUTYDA_SEL("1000"),
    .CLKFB_SEL("internal"),
    .CLKOUT_BYPASS("false"),
    .CLKOUTP_BYPASS("false"),
    .CLKOUTD_BYPASS("false"),
    .CLKOUT_FT_DIR(1'b1),
    .CLKOUTP_FT_DIR(1'b1),
    .CLKOUT_DLY_STEP(0),
    .CLKOUTP_DLY_STEP(0),
    .CLKOUTD_SRC("CLKOUT"),
    .CLKOUTD3_SRC("CLKOUT")
  ) pll (
    .CLKIN(clk_27mhz),
    .CLKFB(1'b0),
    .RESET(1'b0),
    .RESET_P(1'b0),
    .FBDSEL(6'b0),
    .IDSEL(6'b0),
    .ODSEL(6'b0),
    .PSDA(4'b0),
    .DUTYDA(4'b0),
    .FDLY(4'b0),
    .CLKOUT(clk_pll),
    .CLKOUTD(clk_shift),
    .CLKOUTP(),
    .CLKOUTD3(),
    .LOCK(locked)
  );

  CLKDIV #(.DIV_MODE("5"), .GSREN("false")) fifth (
    .HCLKIN(clk_pll), .RESETN(locked), .CALIB(1'b0), .CLKOUT(clk)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || button_s1), .reset(reset));

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
