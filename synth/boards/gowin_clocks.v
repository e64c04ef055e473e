// SPDX-License-Identifier: Apache-2.0
//
// Clocks of GW2AR-18 or GW1NR-9 from a crystal of 27 MHz: 50.4 MHz for the board and 126 MHz for the pins of
// the monitor, two bits a cycle.

module gowin_clocks #(
  parameter DEVICE = "GW2AR-18C"
) (
  input crystal,
  output clk,
  output clk_shift,
  output locked
);

  // 27 MHz * 28 / 3 = 252 MHz, the oscillator at twice that (500 to 1250 are allowed, and 400 to 1200 on
  // GW1NR-9); a half of it moves bits to the monitor, two a cycle, and a fifth is the board's.
  wire clk_pll;

  rPLL #(
    .FCLKIN("27"),
    .DEVICE(DEVICE),
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
    .CLKIN(crystal),
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

endmodule
