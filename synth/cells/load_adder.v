// SPDX-License-Identifier: Apache-2.0
//
// load_adder.vhd in ECP5's carry cells, one level of logic from register to register. A cell's half is a
// LUT4 of A, B, C, D, which the incoming carry inverts; where the LUT is 0, the outgoing carry is the LUT's
// answer for C = D = 0. With A = load, B = value, C = step, D = start and
//   LUT4 = A ? D : B ^ C
// that answer is B & ~A: the value's bit while adding, 0 while loading, so that no carry starts and the sum
// is start. With a carry in, the lowest half makes carry_in & ~load a carry: its D is 1 and
// its LUT then 0. Synthesis puts this in the place of GHDL's module.

module load_adder #(
  parameter width = 32,
  parameter with_carry = 0
) (
  input load,
  input [width - 1:0] start,
  input [width - 1:0] value,
  input [width - 1:0] step,
  input carry_in,
  output [width - 1:0] sum
);

  localparam halves = width + with_carry;
  localparam cells = (halves + 1) / 2;

  wire [2 * cells - 1:0] starts = with_carry ? {start, 1'b1} : start;
  wire [2 * cells - 1:0] values = with_carry ? {value, carry_in} : value;
  wire [2 * cells - 1:0] steps = step << with_carry;
  wire [2 * cells - 1:0] sums;
  wire [cells:0] carries;

  assign carries[0] = 1'b0;
  assign sum = sums >> with_carry;

  genvar index;
  generate
    for (index = 0; index < cells; index = index + 1) begin : pair
      CCU2C #(
        .INIT0(with_carry && index == 0 ? 16'h0004 : 16'hBE14),
        .INIT1(16'hBE14),
        .INJECT1_0("NO"),
        .INJECT1_1("NO")
      ) carry_cell (
        .CIN(carries[index]),
        .A0(load), .B0(values[2 * index]), .C0(steps[2 * index]), .D0(starts[2 * index]),
        .A1(load), .B1(values[2 * index + 1]), .C1(steps[2 * index + 1]), .D1(starts[2 * index + 1]),
        .S0(sums[2 * index]), .S1(sums[2 * index + 1]),
        .COUT(carries[index + 1])
      );
    end
  endgenerate

endmodule
