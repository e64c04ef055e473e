// SPDX-License-Identifier: Apache-2.0
//
// span_chain against an ideal FIFO of `depth` words: what the stages hold, in order, is what the FIFO holds,
// so nothing is lost, doubled or reordered, and nothing is taken that has no room. Never more than `depth`
// cycles pass from the input to the output of an empty chain: a span moves on whenever there is room ahead.

module span_chain_properties #(
  parameter data_bits = 4,
  parameter depth = 3
) (
  input clk,
  input reset,
  input input_valid,
  input [data_bits - 1:0] input_data,
  input output_ready
);

  wire busy, input_ready, output_valid;
  wire [data_bits - 1:0] output_data;

  span_chain dut (
    .clk(clk), .reset(reset), .busy(busy),
    .input_valid(input_valid), .input_ready(input_ready), .input_data(input_data),
    .output_valid(output_valid), .output_ready(output_ready), .output_data(output_data)
  );

  // Bit depth - k is stage k's: VHDL's ranges ascend. Stage 0 of the data is the input.
  (* hierconn *) wire [depth - 1:0] \dut.held ;
  (* hierconn *) wire [(depth + 1) * data_bits - 1:0] \dut.data ;
  (* hierconn *) wire \dut.full ;

  wire taken = input_valid && input_ready;
  wire given = output_valid && output_ready;

  // The ideal FIFO: the oldest word lowest.
  reg [depth * data_bits - 1:0] fifo;
  integer fill = 0;
  always @(posedge clk) begin
    if (given) fifo = fifo >> data_bits;
    if (taken) fifo[(fill - given) * data_bits +: data_bits] = input_data;
    fill <= reset ? 0 : fill + taken - given;
  end

  // How many spans stand before each stage's.
  integer before [0:depth];
  integer stage;
  always @* begin
    before[depth] = 0;
    for (stage = depth - 1; stage >= 0; stage = stage - 1)
      before[stage] = before[stage + 1] + \dut.held [depth - 1 - stage];
  end

  always @* begin
    // No overflow, no loss.
    assert (fill >= 0 && fill <= depth);
    assert (before[0] == fill);
    assert (busy == (fill != 0));
    assert (!(given && fill == 0));
    assert (!(taken && fill == depth && !given));
    // Room is used: only a full chain that gives nothing refuses.
    assert (input_ready == (fill < depth || output_ready));
    // The register that stands for "all stages hold a span".
    assert (\dut.full == &\dut.held );
  end

  genvar place, word;
  generate
    for (place = 1; place <= depth; place = place + 1) begin : contents
      for (word = 0; word < depth; word = word + 1) begin : words
        always @*
          if (\dut.held [depth - place] && before[place] == word)
            assert (\dut.data [(depth - place) * data_bits +: data_bits]
              == fifo[word * data_bits +: data_bits]);
      end
    end
  endgenerate
  always @* if (output_valid) assert (output_data == fifo[data_bits - 1:0]);

  // Latency: the cycles for which a span has been there while none came out.
  integer waited = 0;
  always @(posedge clk) waited <= reset || fill == 0 || output_valid ? 0 : waited + 1;
  // While it has waited n cycles, it has come past n stages.
  wire [depth - 1:0] ahead = \dut.held & ((1 << (depth - waited)) - 1);
  always @* begin
    assert (waited >= 0 && waited < depth);
    if (fill != 0 && !output_valid) assert (ahead != 0);
  end

endmodule
