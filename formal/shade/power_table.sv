// SPDX-License-Identifier: Apache-2.0
//
// power_table against its definition: index and fraction of every distance from 1, and the interpolation
// between the halves of any word. The memory is cut out: its word is free.

module power_table_properties #(
  parameter lane_value_bits = 8
) (
  input clk,
  input advance,
  input [lane_value_bits - 1:0] value,
  input write_enable,
  input [8:0] write_address,
  input [31:0] write_data
);

  localparam fraction_bits = lane_value_bits - 6;

  wire [15:0] power;
  power_table dut (
    .clk(clk), .advance(advance), .value(value), .power(power),
    .write_enable(write_enable), .write_address(write_address), .write_data(write_data)
  );

  (* hierconn *) wire [lane_value_bits - 1:0] \dut.far_1 ;
  (* hierconn *) wire [lane_value_bits - 1:0] \dut.far_2 ;
  (* hierconn *) wire [lane_value_bits - 1:0] \dut.far_3 ;
  (* hierconn *) wire [3:0] \dut.row_1 ;
  (* hierconn *) wire [3:0] \dut.row_2 ;
  (* hierconn *) wire [3:0] \dut.row_3 ;
  (* hierconn *) wire [3:0] \dut.shift_1 ;
  (* hierconn *) wire [1:0] \dut.shift_2 ;
  (* hierconn *) wire [8:0] \dut.fetch_address ;
  (* hierconn *) wire [31:0] \dut.word_5 ;
  (* hierconn *) wire [fraction_bits - 1:0] \dut.fraction_4 ;
  (* hierconn *) wire [fraction_bits - 1:0] \dut.fraction_5 ;
  (* hierconn *) wire [fraction_bits - 1:0] \dut.fraction_6 ;
  (* hierconn *) wire [15:0] \dut.here_6 ;
  (* hierconn *) wire [15:0] \dut.here_7 ;
  (* hierconn *) wire [16:0] \dut.difference_6 ;
  (* hierconn *) wire [fraction_bits + 17:0] \dut.product_7 ;

  // By how many places the leading one lies above a mantissa of 6 bits, 0 where it does not.
  function [3:0] octave(input [lane_value_bits - 1:0] far);
    integer place;
    begin
      octave = 0;
      for (place = 6; place < lane_value_bits; place = place + 1) if (far[place]) octave = place - 5;
    end
  endfunction

  function [lane_value_bits - 1:0] shifted(input [lane_value_bits - 1:0] far);
    shifted = far << (fraction_bits - octave(far));
  endfunction

  function [8:0] index(input [lane_value_bits - 1:0] far);
    index = {octave(far), 5'd0} + (shifted(far) >> fraction_bits);
  endfunction

  // Distances and words on their way, from the first one on.
  reg [8:1] known = 0;
  reg [lane_value_bits - 1:0] far_1, far_2, far_3, far_4, far_5, far_6, far_7, far_8;
  reg [31:0] word_6, word_7, word_8;
  always @(posedge clk) if (advance) begin
    known <= {known[7:1], 1'b1};
    far_1 <= ~value;
    {far_2, far_3, far_4, far_5, far_6, far_7, far_8} <= {far_1, far_2, far_3, far_4, far_5, far_6, far_7};
    {word_6, word_7, word_8} <= {\dut.word_5 , word_6, word_7};
  end

  wire [fraction_bits - 1:0] fraction_7 = shifted(far_7);
  wire [fraction_bits - 1:0] fraction_8 = shifted(far_8);
  wire signed [17:0] step_7 = {2'b00, word_7[31:16]} - {2'b00, word_7[15:0]};
  wire signed [17:0] step_8 = {2'b00, word_8[31:16]} - {2'b00, word_8[15:0]};
  wire signed [fraction_bits + 18:0] part_7 = step_7 * $signed({1'b0, fraction_7});
  wire signed [fraction_bits + 18:0] part_8 = step_8 * $signed({1'b0, fraction_8});
  wire signed [fraction_bits + 18:0] rounded_8 = part_8 + (1 << (fraction_bits - 1));
  wire signed [fraction_bits + 18:0] power_8 = $signed({1'b0, word_8[15:0]}) + (rounded_8 >>> fraction_bits);

  wire [3:0] moved_1 = fraction_bits - octave(far_1);
  wire [3:0] moved_2 = fraction_bits - octave(far_2);
  always @* begin
    // What is claimed.
    if (known[3]) assert (\dut.fetch_address == index(far_3));
    if (known[8]) assert (power == power_8[15:0] && power_8 >> 16 == 0);

    // Why it holds, stage by stage.
    if (known[1]) begin
      assert (\dut.far_1 == far_1 && \dut.shift_1 == moved_1);
      assert (\dut.row_1 == index(far_1) >> 5);
    end
    if (known[2]) begin
      assert (\dut.far_2 == far_2 << (moved_2 & 12) && \dut.shift_2 == moved_2[1:0]);
      assert (\dut.row_2 == index(far_2) >> 5);
    end
    if (known[3]) assert (\dut.far_3 == shifted(far_3) && \dut.row_3 == index(far_3) >> 5);
    if (known[4]) assert (\dut.fraction_4 == shifted(far_4) % (1 << fraction_bits));
    if (known[5]) assert (\dut.fraction_5 == shifted(far_5) % (1 << fraction_bits));
    if (known[6]) begin
      assert (\dut.fraction_6 == shifted(far_6) % (1 << fraction_bits));
      assert (\dut.here_6 == word_6[15:0]);
      assert (\dut.difference_6 == {1'b0, word_6[31:16]} - {1'b0, word_6[15:0]});
    end
    if (known[7]) begin
      assert (\dut.here_7 == word_7[15:0]);
      assert (\dut.product_7 == part_7[fraction_bits + 17:0]);
    end
  end

endmodule
