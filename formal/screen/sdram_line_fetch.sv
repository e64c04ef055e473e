// SPDX-License-Identifier: Apache-2.0
//
// sdram_line_fetch: every run of a scanline is asked for, once and in order, and the last one is accepted in
// time. The controller is taken to accept as it is proved to: after one run and one refresh at most.

module sdram_line_fetch_properties #(
  parameter width = 640,
  parameter height = 480,
  parameter run_words = 64
) (
  input clk,
  input reset,
  input line_start,
  input line_first,
  input plane,
  input run_ready
);

  localparam runs = width / run_words;
  localparam x_bits = $clog2(width), y_bits = $clog2(height), index_bits = $clog2(run_words);
  // Of sdram_controller's proof, with its default times.
  localparam most_wait = run_words + 14;
  localparam most_clocks = runs * (most_wait + 1);

  wire run_valid;
  wire [1 + y_bits + x_bits:0] run_address;
  wire [index_bits - 1:0] run_more;

  sdram_line_fetch dut (
    .clk(clk), .reset(reset), .line_start(line_start), .line_first(line_first), .plane(plane),
    .run_valid(run_valid), .run_ready(run_ready), .run_address(run_address), .run_more(run_more)
  );

  // Clocks since a scanline was wanted, runs of it that were accepted, clocks that the next one has waited.
  reg [15:0] age = most_clocks, index = runs, waited = 0;
  reg [y_bits - 1:0] row = 0;
  wire accepted = run_valid && run_ready;

  always @(posedge clk) begin
    age <= age == most_clocks ? age : age + 1;
    waited <= run_valid && !run_ready ? waited + 1 : 0;
    if (accepted) index <= index + 1;
    if (line_start) begin
      age <= 0;
      index <= 0;
      row <= line_first ? 0 : row + 1;
    end
    if (reset) begin
      age <= most_clocks;
      index <= runs;
      row <= 0;
      waited <= 0;
    end
  end

  always @* begin
    if (run_valid && waited == most_wait) assume (run_ready);
    // What scan_out does: a line of the monitor is longer.
    if (line_start) assume (age == most_clocks);
  end

  always @* begin
    assert (age <= most_clocks && index <= runs && waited <= most_wait);
    assert (run_valid == (index < runs));
    assert (run_address >> x_bits == {1'b0, plane, row});
    if (run_valid) begin
      assert (age <= index * (most_wait + 1) + waited);
      assert (run_address[x_bits - 1:0] == index * run_words);
      assert (&run_more);
    end else
      assert (waited == 0);
    if (age == most_clocks) assert (index == runs);
  end

endmodule
