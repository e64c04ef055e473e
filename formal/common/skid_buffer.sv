// SPDX-License-Identifier: Apache-2.0
//
// skid_buffer against an ideal FIFO of two words, and the rules of AXI4-Stream at both of its ports:
// nothing is lost, doubled or reordered, a valid word stays until it is taken, ready is a register.

module skid_buffer_properties #(
  parameter data_bits = 4
) (
  input clk,
  input reset,
  input input_valid,
  input [data_bits - 1:0] input_data,
  input output_ready
);

  wire input_ready, output_valid;
  wire [data_bits - 1:0] output_data;

  skid_buffer dut (
    .clk(clk), .reset(reset),
    .input_valid(input_valid), .input_ready(input_ready), .input_data(input_data),
    .output_valid(output_valid), .output_ready(output_ready), .output_data(output_data)
  );

  (* hierconn *) wire [data_bits - 1:0] \dut.front ;
  (* hierconn *) wire [data_bits - 1:0] \dut.spare ;

  wire taken = input_valid && input_ready;
  wire given = output_valid && output_ready;

  reg [data_bits - 1:0] first, second;
  reg [1:0] fill = 0;
  always @(posedge clk) begin
    if (given) first <= second;
    if (taken && fill == given) first <= input_data;
    if (taken && fill != given) second <= input_data;
    fill <= reset ? 0 : fill + taken - given;
  end

  always @* begin
    assert (fill <= 2);
    assert (output_valid == (fill != 0));
    assert (input_ready == (fill != 2));
    if (fill != 0) assert (output_data == first);
    if (fill == 2) assert (\dut.spare == second);
    assert (output_data == \dut.front );
  end

  reg held = 0;
  reg [data_bits - 1:0] held_data;
  always @(posedge clk) begin
    held <= output_valid && !output_ready && !reset;
    held_data <= output_data;
  end
  always @* if (held) assert (output_valid && output_data == held_data);

endmodule
