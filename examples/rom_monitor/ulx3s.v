// SPDX-License-Identifier: Apache-2.0
//
// rom_monitor on ULX3S: a clock for the pixels and one for the bits of TMDS from the 25 MHz crystal, and the
// monitor's pins (GPDI). Pins: synth/boards/ulx3s.lpf.
// Button PWR draws the picture anew; the first LED says that it is drawn.

module top (
  input clk_25mhz,
  input button_power_n,
  output [7:0] led,
  output [3:0] gpdi_dp,
  output wifi_gpio0
);

  // Tied high, so that the ESP32 stays out of its loader and keeps the FPGA's configuration.
  assign wifi_gpio0 = 1'b1;

  wire clk, clk_shift, locked;

  // The oscillator runs at 500 MHz (400 to 800 are allowed), the clocks at a 20th and a fourth of that.
  (* FREQUENCY_PIN_CLKI = "25" *)
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
    .CLKFB_DIV(1),
    .FEEDBK_PATH("CLKOP"),
    .CLKOP_ENABLE("ENABLED"),
    .CLKOP_DIV(20),
    .CLKOP_CPHASE(9),
    .CLKOP_FPHASE(0),
    .CLKOS_ENABLE("ENABLED"),
    .CLKOS_DIV(4),
    .CLKOS_CPHASE(9),
    .CLKOS_FPHASE(0)
  ) pll (
    .RST(1'b0),
    .STDBY(1'b0),
    .CLKI(clk_25mhz),
    .CLKFB(clk),
    .CLKOP(clk),
    .CLKOS(clk_shift),
    .PHASESEL0(1'b0),
    .PHASESEL1(1'b0),
    .PHASEDIR(1'b1),
    .PHASESTEP(1'b1),
    .PHASELOADREG(1'b1),
    .PLLWAKESYNC(1'b0),
    .ENCLKOP(1'b0),
    .LOCK(locked)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || !button_power_n), .reset(reset));

  wire done, video_next;
  wire [29:0] video_words;
  rom_monitor rom_monitor_inst (
    .clk(clk), .reset(reset), .done(done), .video_next(video_next), .video_words(video_words)
  );
  assign led = {7'd0, done};

  gpdi gpdi_inst (
    .clk(clk), .reset(reset), .word_next(video_next), .words(video_words), .clk_shift(clk_shift),
    .gpdi_dp(gpdi_dp)
  );

endmodule
