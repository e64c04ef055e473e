// SPDX-License-Identifier: Apache-2.0
//
// Simulation model of ECP5's block RAM, of which Yosys has none: what Yosys' mapping and
// quadshade.synthesis.block_registers make of the cell, and nothing else; other settings end the simulation.
//
// A port reads and writes 1, 2, 4, 9 or 18 bits, or port A writes and port B reads 36. What one port reads
// while the other writes it is unknown: whoever needs it fails. The output register is there with OUTREG,
// enabled by OCE. Both clocks must be one net.

module DP16KD #(
  parameter INITVAL_00 = 320'b0,
  parameter INITVAL_01 = 320'b0,
  parameter INITVAL_02 = 320'b0,
  parameter INITVAL_03 = 320'b0,
  parameter INITVAL_04 = 320'b0,
  parameter INITVAL_05 = 320'b0,
  parameter INITVAL_06 = 320'b0,
  parameter INITVAL_07 = 320'b0,
  parameter INITVAL_08 = 320'b0,
  parameter INITVAL_09 = 320'b0,
  parameter INITVAL_0A = 320'b0,
  parameter INITVAL_0B = 320'b0,
  parameter INITVAL_0C = 320'b0,
  parameter INITVAL_0D = 320'b0,
  parameter INITVAL_0E = 320'b0,
  parameter INITVAL_0F = 320'b0,
  parameter INITVAL_10 = 320'b0,
  parameter INITVAL_11 = 320'b0,
  parameter INITVAL_12 = 320'b0,
  parameter INITVAL_13 = 320'b0,
  parameter INITVAL_14 = 320'b0,
  parameter INITVAL_15 = 320'b0,
  parameter INITVAL_16 = 320'b0,
  parameter INITVAL_17 = 320'b0,
  parameter INITVAL_18 = 320'b0,
  parameter INITVAL_19 = 320'b0,
  parameter INITVAL_1A = 320'b0,
  parameter INITVAL_1B = 320'b0,
  parameter INITVAL_1C = 320'b0,
  parameter INITVAL_1D = 320'b0,
  parameter INITVAL_1E = 320'b0,
  parameter INITVAL_1F = 320'b0,
  parameter INITVAL_20 = 320'b0,
  parameter INITVAL_21 = 320'b0,
  parameter INITVAL_22 = 320'b0,
  parameter INITVAL_23 = 320'b0,
  parameter INITVAL_24 = 320'b0,
  parameter INITVAL_25 = 320'b0,
  parameter INITVAL_26 = 320'b0,
  parameter INITVAL_27 = 320'b0,
  parameter INITVAL_28 = 320'b0,
  parameter INITVAL_29 = 320'b0,
  parameter INITVAL_2A = 320'b0,
  parameter INITVAL_2B = 320'b0,
  parameter INITVAL_2C = 320'b0,
  parameter INITVAL_2D = 320'b0,
  parameter INITVAL_2E = 320'b0,
  parameter INITVAL_2F = 320'b0,
  parameter INITVAL_30 = 320'b0,
  parameter INITVAL_31 = 320'b0,
  parameter INITVAL_32 = 320'b0,
  parameter INITVAL_33 = 320'b0,
  parameter INITVAL_34 = 320'b0,
  parameter INITVAL_35 = 320'b0,
  parameter INITVAL_36 = 320'b0,
  parameter INITVAL_37 = 320'b0,
  parameter INITVAL_38 = 320'b0,
  parameter INITVAL_39 = 320'b0,
  parameter INITVAL_3A = 320'b0,
  parameter INITVAL_3B = 320'b0,
  parameter INITVAL_3C = 320'b0,
  parameter INITVAL_3D = 320'b0,
  parameter INITVAL_3E = 320'b0,
  parameter INITVAL_3F = 320'b0,
  parameter DATA_WIDTH_A = 18,
  parameter DATA_WIDTH_B = 18,
  parameter REGMODE_A = "NOREG",
  parameter REGMODE_B = "NOREG",
  parameter WRITEMODE_A = "NORMAL",
  parameter WRITEMODE_B = "NORMAL",
  parameter RESETMODE = "SYNC",
  parameter ASYNC_RESET_RELEASE = "SYNC",
  parameter CSDECODE_A = "0b000",
  parameter CSDECODE_B = "0b000",
  parameter CLKAMUX = "CLKA",
  parameter CLKBMUX = "CLKB",
  parameter GSR = "ENABLED"
) (
  input
    CLKA, WEA, CEA, OCEA, RSTA, CSA0, CSA1, CSA2, ADA0, ADA1, ADA2, ADA3, ADA4, ADA5, ADA6, ADA7, ADA8,
    ADA9, ADA10, ADA11, ADA12, ADA13, DIA0, DIA1, DIA2, DIA3, DIA4, DIA5, DIA6, DIA7, DIA8, DIA9, DIA10,
    DIA11, DIA12, DIA13, DIA14, DIA15, DIA16, DIA17,
  output
    DOA0, DOA1, DOA2, DOA3, DOA4, DOA5, DOA6, DOA7, DOA8, DOA9, DOA10, DOA11, DOA12, DOA13, DOA14,
    DOA15, DOA16, DOA17,
  input
    CLKB, WEB, CEB, OCEB, RSTB, CSB0, CSB1, CSB2, ADB0, ADB1, ADB2, ADB3, ADB4, ADB5, ADB6, ADB7, ADB8,
    ADB9, ADB10, ADB11, ADB12, ADB13, DIB0, DIB1, DIB2, DIB3, DIB4, DIB5, DIB6, DIB7, DIB8, DIB9, DIB10,
    DIB11, DIB12, DIB13, DIB14, DIB15, DIB16, DIB17,
  output
    DOB0, DOB1, DOB2, DOB3, DOB4, DOB5, DOB6, DOB7, DOB8, DOB9, DOB10, DOB11, DOB12, DOB13, DOB14,
    DOB15, DOB16, DOB17
);

  localparam [64 * 320 - 1:0] initial_words = {
    INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C, INITVAL_3B, INITVAL_3A, INITVAL_39, INITVAL_38,
    INITVAL_37, INITVAL_36, INITVAL_35, INITVAL_34, INITVAL_33, INITVAL_32, INITVAL_31, INITVAL_30,
    INITVAL_2F, INITVAL_2E, INITVAL_2D, INITVAL_2C, INITVAL_2B, INITVAL_2A, INITVAL_29, INITVAL_28,
    INITVAL_27, INITVAL_26, INITVAL_25, INITVAL_24, INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20,
    INITVAL_1F, INITVAL_1E, INITVAL_1D, INITVAL_1C, INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18,
    INITVAL_17, INITVAL_16, INITVAL_15, INITVAL_14, INITVAL_13, INITVAL_12, INITVAL_11, INITVAL_10,
    INITVAL_0F, INITVAL_0E, INITVAL_0D, INITVAL_0C, INITVAL_0B, INITVAL_0A, INITVAL_09, INITVAL_08,
    INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04, INITVAL_03, INITVAL_02, INITVAL_01, INITVAL_00
  };

  reg [35:0] pairs [0:511];

  wire [13:0] address_a = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2,
    ADA1, ADA0};
  wire [13:0] address_b = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2,
    ADB1, ADB0};
  wire [17:0] low = {DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6,
    DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};
  wire [17:0] high = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6,
    DIB5, DIB4, DIB3, DIB2, DIB1, DIB0};

  // Where a port's word stands in its pair of words of 18 bits.
  function [5:0] offset;
    input integer width;
    input [13:0] address;
    case (width)
      1: offset = 18 * address[4] + 9 * address[3] + address[2:0];
      2: offset = 18 * address[4] + 9 * address[3] + 2 * address[2:1];
      4: offset = 18 * address[4] + 9 * address[3] + 4 * address[2];
      9: offset = 18 * address[4] + 9 * address[3];
      18: offset = 18 * address[4];
      default: offset = 0;
    endcase
  endfunction

  // The bits that a port writes; of 18 or 36, each nine are enabled by an address bit.
  function [35:0] written;
    input integer width;
    input [13:0] address;
    case (width)
      36: written = {{9{address[3]}}, {9{address[2]}}, {9{address[1]}}, {9{address[0]}}};
      18: written = {{9{address[1]}}, {9{address[0]}}} << offset(width, address);
      default: written = ((36'd1 << width) - 1) << offset(width, address);
    endcase
  endfunction

  function [35:0] fetched;
    input integer width;
    input [13:0] address;
    // The pair that the other port writes, and which bits of it.
    input other_writes;
    input [8:0] other_pair;
    input [35:0] other_mask;
    reg [35:0] pair;
    integer index;
    begin
      pair = pairs[address[13:5]];
      if (other_writes !== 1'b0 && other_pair === address[13:5])
        for (index = 0; index < 36; index = index + 1)
          if (other_mask[index] !== 1'b0) pair[index] = 1'bx;
      fetched = (pair >> offset(width, address)) & ((37'd1 << width) - 1);
    end
  endfunction

  wire write_a = CEA & WEA;
  wire write_b = CEB & WEB;
  wire [35:0] mask_a = written(DATA_WIDTH_A, address_a);
  wire [35:0] mask_b = written(DATA_WIDTH_B, address_b);
  wire [35:0] data_a = (DATA_WIDTH_A == 36 ? {high, low} : {18'b0, low}) << offset(DATA_WIDTH_A, address_a);
  wire [35:0] data_b = {18'b0, high} << offset(DATA_WIDTH_B, address_b);

  reg [35:0] latch_a = 0, latch_b = 0, register_a = 0, register_b = 0;
  wire [35:0] out_a = REGMODE_A == "OUTREG" ? register_a : latch_a;
  wire [35:0] out_b = REGMODE_B == "OUTREG" ? register_b : latch_b;

  integer word;

  initial begin
    for (word = 0; word < 1024; word = word + 1)
      pairs[word / 2][18 * (word % 2) +: 18] = initial_words[20 * word +: 18];
    if (CLKAMUX != "CLKA" || CLKBMUX != "CLKB" || CSDECODE_A != "0b000" || CSDECODE_B != "0b000")
      $fatal(1, "DP16KD: this clock or chip select has no model");
    if (WRITEMODE_A == "WRITETHROUGH" || WRITEMODE_B == "WRITETHROUGH")
      $fatal(1, "DP16KD: this way of writing has no model");
  end

  always @(posedge CLKA) begin
    if (RSTA !== 1'b0 || {CSA2, CSA1, CSA0} !== 3'b0) $fatal(1, "DP16KD: port A's reset has no model");
    if (write_a) pairs[address_a[13:5]] <= (pairs[address_a[13:5]] & ~mask_a) | (data_a & mask_a);
    if (CEA && (!WEA || WRITEMODE_A == "READBEFOREWRITE"))
      latch_a <= fetched(DATA_WIDTH_A, address_a, write_b, address_b[13:5], mask_b);
    if (OCEA) register_a <= latch_a;
  end

  always @(posedge CLKB) begin
    if (RSTB !== 1'b0 || {CSB2, CSB1, CSB0} !== 3'b0) $fatal(1, "DP16KD: port B's reset has no model");
    if (write_b !== 1'b0 && DATA_WIDTH_B == 36) $fatal(1, "DP16KD: this way of writing has no model");
    if (write_b) pairs[address_b[13:5]] <= (pairs[address_b[13:5]] & ~mask_b) | (data_b & mask_b);
    if (CEB && (!WEB || WRITEMODE_B == "READBEFOREWRITE"))
      latch_b <= fetched(DATA_WIDTH_B, address_b, write_a, address_a[13:5], mask_a);
    if (OCEB) register_b <= latch_b;
  end

  assign
    {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3,
    DOA2, DOA1, DOA0}
      = DATA_WIDTH_B == 36 ? out_b[17:0] : out_a[17:0];
  assign
    {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3,
    DOB2, DOB1, DOB0}
      = DATA_WIDTH_B == 36 ? out_b[35:18] : out_b[17:0];

endmodule
