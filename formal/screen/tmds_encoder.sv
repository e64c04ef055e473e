// SPDX-License-Identifier: Apache-2.0
//
// tmds_encoder: every word, decoded as a monitor does, is the byte that went in; ones and zeros of a line's
// words never differ by more than eight.

module tmds_encoder_properties (
  input clk,
  input enable,
  input active,
  input [7:0] value,
  input [1:0] control
);

  wire [9:0] word;

  tmds_encoder dut (
    .clk(clk), .enable(enable), .active(active), .value(value), .control(control), .word(word)
  );

  (* hierconn *) wire \dut.active_1 ;
  (* hierconn *) wire \dut.active_2 ;
  (* hierconn *) wire \dut.active_3 ;
  (* hierconn *) wire [7:0] \dut.byte_1 ;
  (* hierconn *) wire [7:0] \dut.byte_2 ;
  (* hierconn *) wire [7:0] \dut.byte_3 ;
  (* hierconn *) wire \dut.equal_2 ;
  (* hierconn *) wire \dut.equal_3 ;
  (* hierconn *) wire signed [3:0] \dut.excess_3 ;
  (* hierconn *) wire signed [3:0] \dut.disparity ;

  // What went in, a stage behind the other.
  reg active_1 = 0, active_2 = 0, active_3 = 0, active_4 = 0;
  reg [7:0] value_1, value_2, value_3, value_4;
  always @(posedge clk) begin
    if (enable) begin
      {active_1, active_2, active_3, active_4} <= {active, active_1, active_2, active_3};
      {value_1, value_2, value_3, value_4} <= {value, value_1, value_2, value_3};
    end
  end

  // Differences, or equalities, of neighbours.
  function [7:0] decode(input [7:0] bits, input equal);
    decode = bits ^ {bits[6:0] ^ {7{equal}}, 1'b0};
  endfunction

  function signed [5:0] surplus(input [9:0] bits);
    integer index;
    begin
      surplus = -5;
      for (index = 0; index < 10; index = index + 1) surplus = surplus + bits[index];
    end
  endfunction

  // Half of ones minus zeros of the line's words before this one, and with it.
  reg signed [5:0] before = 0;
  wire signed [5:0] total = active_4 ? before + surplus(word) : 0;
  always @(posedge clk) if (enable) before <= total;

  always @* begin
    if (active_4) assert (decode(word[9] ? ~word[7:0] : word[7:0], !word[8]) == value_4);
    assert (total == \dut.disparity && total <= 4 && total >= -4);

    assert (\dut.active_1 == active_1 && \dut.active_2 == active_2 && \dut.active_3 == active_3);
    if (active_1) assert (\dut.byte_1 == value_1);
    if (active_2) assert (decode(\dut.byte_2 , \dut.equal_2 ) == value_2);
    if (active_3) begin
      assert (decode(\dut.byte_3 , \dut.equal_3 ) == value_3);
      assert (\dut.excess_3 == surplus({2'b01, \dut.byte_3 }));
    end
  end

endmodule
