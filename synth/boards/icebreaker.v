// SPDX-License-Identifier: Apache-2.0
//
// iCEBreaker: the board between interface B of its USB chip, at 24 MHz from the 12 MHz crystal.
// Reset after configuration, until the PLL has locked, and while the user button is pressed.

module top (
  input clk_12mhz,
  input uart_rx,
  output uart_tx,
  input button_user_n,
  output led_red_n,
  output led_green_n,
  // On the part that breaks off, active high: link, drawing, fault, sending.
  output [3:0] led
);

  wire clk, locked;

  // 12 MHz * 64 = 768 MHz in the oscillator, divided by 2**5.
  SB_PLL40_PAD #(
    .FEEDBACK_PATH("SIMPLE"),
    .DIVR(4'd0),
    .DIVF(7'd63),
    .DIVQ(3'd5),
    .FILTER_RANGE(3'd1)
  ) pll (
    .PACKAGEPIN(clk_12mhz),
    .PLLOUTGLOBAL(clk),
    .LOCK(locked),
    .RESETB(1'b1),
    .BYPASS(1'b0)
  );

  wire reset;
  power_on_reset power_on_reset_inst (.clk(clk), .hold(!locked || !button_user_n), .reset(reset));

  wire [7:0] lights;
  board board_inst (.clk(clk), .reset(reset), .rx(uart_rx), .tx(uart_tx), .led(lights));

  assign led = lights[3:0];
  assign led_green_n = !lights[0];
  assign led_red_n = !lights[2];

endmodule
