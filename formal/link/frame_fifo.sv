// SPDX-License-Identifier: Apache-2.0
//
// frame_fifo: a word can be read only once its frame is committed; a frame that is discarded, or did not fit,
// leaves no trace. Counted on the ports: `pending` words of the frame that comes in, `ready` of those before.
// The memory is cut out; no word is written where one is read.

module frame_fifo_properties #(
  parameter num_words = 8,
  parameter data_bits = 4
) (
  input clk,
  input reset,
  input write_valid,
  input [data_bits - 1:0] write_data,
  input commit,
  input discard,
  input read_ready
);

  localparam address_bits = $clog2(num_words);

  wire overflow, read_valid;
  wire [address_bits:0] free;
  wire [data_bits - 1:0] read_data;

  frame_fifo dut (
    .clk(clk), .reset(reset), .write_valid(write_valid), .write_data(write_data), .commit(commit),
    .discard(discard), .overflow(overflow), .free(free),
    .read_valid(read_valid), .read_ready(read_ready), .read_data(read_data)
  );

  // As the frame receiver gives them.
  always @* assume (!(commit && discard) && !(write_valid && (commit || discard)));

  reg [address_bits:0] pending = 0, ready = 0;
  reg too_long = 0;
  wire room = pending + ready != num_words;
  wire taken = read_valid && read_ready;
  always @(posedge clk) begin
    if (write_valid && room) pending <= pending + 1;
    if (write_valid && !room) too_long <= 1;
    if (commit || discard) {pending, too_long} <= 0;
    ready <= ready - taken + (commit && !too_long ? pending : 0);
    if (reset) {pending, ready, too_long} <= 0;
  end

  (* hierconn *) wire [address_bits:0] \dut.written ;
  (* hierconn *) wire [address_bits:0] \dut.committed ;
  (* hierconn *) wire [address_bits:0] \dut.taken ;
  (* hierconn *) wire [2:0] \dut.place ;
  (* hierconn *) wire \dut.store ;
  wire same_word = \dut.written [address_bits - 1:0] == \dut.taken [address_bits - 1:0];

  reg was_shown = 0;
  always @(posedge clk) was_shown <= read_valid && !read_ready && !reset;

  always @* begin
    assert (free == num_words - ready);
    assert (overflow == too_long);
    if (read_valid) assert (ready != 0);
    if (was_shown) assert (read_valid);
    // From the first read of it on until it is taken.
    if (ready != 0) assert (!(\dut.store && same_word));
  end

  // What makes it inductive.
  wire [address_bits:0] begun = \dut.written - \dut.committed ;
  wire [address_bits:0] whole = \dut.committed - \dut.taken ;
  always @* begin
    assert (begun == pending && whole == ready);
    assert (pending <= num_words && ready <= num_words && pending + ready <= num_words);
    if (\dut.place != 0) assert (ready != 0);
    assert (\dut.place <= 4);
  end

endmodule
