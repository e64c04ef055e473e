// SPDX-License-Identifier: Apache-2.0
//
// ECP5's PLL from a crystal of 100 MHz / divider: 100 MHz for the board and 125 MHz for the monitor's pins;
// with an SDRAM its clock too, 8.25 ns behind that of the board.

module ecp5_clocks #(
  parameter divider = 4,
  parameter sdram = "DISABLED"
) (
  input crystal,
  output clk,
  output clk_shift,
  output clk_sdram,
  output locked
);

  // The oscillator runs at 500 MHz (400 to 800 are allowed), the clocks at a fifth and a fourth of that.
  (* ICP_CURRENT = "12" *)
  (* LPF_RESISTOR = "8" *)
  (* MFG_ENABLE_FILTEROPAMP = "1" *)
  (* MFG_GMCREF_SEL = "2" *)
  EHXPLLL #(
    .PLLRST_ENA("DISABLED"),
    .INTFB_WAKE("DISABLED"),
    .STDBY_ENABLE("DISABLED"),
    .DPHASE_SOURCE("DISABLED"),
    .OUTDIVIDER_MUXA("DIVA"),
    .CLKI_DIV(1),
    .CLKFB_DIV(divider),
    .FEEDBK_PATH("CLKOP"),
    .CLKOP_ENABLE("ENABLED"),
    .CLKOP_DIV(5),
    .CLKOP_CPHASE(2),
    .CLKOP_FPHASE(0),
    .CLKOS_ENABLE("ENABLED"),
    .CLKOS_DIV(4),
    .CLKOS_CPHASE(2),
    .CLKOS_FPHASE(0),
    // A turn of the oscillator less, of 2 ns, and an eighth of one more: 1.75 ns ahead of the next edge.
    .CLKOS2_ENABLE(sdram),
    .CLKOS2_DIV(5),
    .CLKOS2_CPHASE(1),
    .CLKOS2_FPHASE(1)
  ) pll (
    .RST(1'b0),
    .STDBY(1'b0),
    .CLKI(crystal),
    .CLKFB(clk),
    .CLKOP(clk),
    .CLKOS(clk_shift),
    .CLKOS2(clk_sdram),
    .PHASESEL0(1'b0),
    .PHASESEL1(1'b0),
    .PHASEDIR(1'b1),
    .PHASESTEP(1'b1),
    .PHASELOADREG(1'b1),
    .PLLWAKESYNC(1'b0),
    .ENCLKOP(1'b0),
    .LOCK(locked)
  );

endmodule
