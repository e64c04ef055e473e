// SPDX-License-Identifier: Apache-2.0
//
// frame_receiver: two cycles after its end a frame may be accepted, acknowledged or become a request, only
// if the deframer found it whole, the CRC over its bytes (the textbook's division, as in crc32.sv) is right,
// and it has as many bytes as its header says; it is accepted only if it has the number that was expected,
// which changes by one, and then only. Everything else leaves no trace.

module frame_receiver_properties (
  input clk,
  input reset,
  input byte_valid,
  input [7:0] byte_data,
  input frame_end,
  input frame_good,
  input overflow
);

  wire write_valid, commit, discard, ack, nak, request;
  wire [31:0] write_data, argument;
  wire [7:0] expected, reason, opcode, number;
  wire [7:0] counts;

  frame_receiver dut (
    .clk(clk), .reset(reset), .byte_valid(byte_valid), .byte_data(byte_data), .frame_end(frame_end),
    .frame_good(frame_good), .write_valid(write_valid), .write_data(write_data), .commit(commit),
    .discard(discard), .overflow(overflow), .expected(expected), .ack(ack), .nak(nak), .request(request),
    .reason(reason), .opcode(opcode), .number(number), .argument(argument),
    .count_frame(counts[0]), .count_bad_cobs(counts[1]), .count_bad_crc(counts[2]),
    .count_bad_length(counts[3]), .count_refused(counts[4]), .count_overrun(counts[5]),
    .count_duplicate(counts[6]), .count_gap(counts[7])
  );

  // As the deframer gives them: no byte comes with a frame's end, and in the two cycles after it at most one.
  reg end_1 = 0;
  always @(posedge clk) end_1 <= frame_end && !reset;
  always @* if (frame_end) assume (!byte_valid);
  always @* if (end_1) assume (!frame_end && !byte_valid);

  reg started = 0, was_reset = 1;
  always @(posedge clk) begin
    started <= 1;
    was_reset <= reset;
  end

  // The frame so far. The division begins anew in the cycle after a frame's end.
  reg [10:0] bytes = 0;
  reg [31:0] header = 0;
  reg [31:0] divided = 32'hffffffff, next;
  integer index;
  always @* begin
    next = end_1 || was_reset ? 32'hffffffff : divided;
    if (byte_valid)
      for (index = 0; index < 8; index = index + 1)
        next = {next[30:0], 1'b0} ^ (next[31] ^ byte_data[index] ? 32'h04c11db7 : 32'h0);
  end
  always @(posedge clk) begin
    divided <= next;
    if (byte_valid && bytes < 4) header[8 * bytes[1:0] +: 8] <= byte_data;
    if (byte_valid && bytes != 1025) bytes <= bytes + 1;
    if (frame_end || reset) bytes <= 0;
  end

  // What is left of the division by a right CRC.
  wire right = frame_good && divided == 32'hc704dd7b && bytes >= 8 && bytes <= 1024
    && bytes == header[31:16] + 8;
  reg right_1 = 0, right_2 = 0, end_2 = 0;
  reg [7:0] before;
  reg [7:0] number_2;
  always @(posedge clk) begin
    right_1 <= frame_end && right && !reset;
    right_2 <= right_1 && !reset;
    end_2 <= end_1 && !reset;
    number_2 <= header[15:8];
    before <= expected;
  end
  always @* begin
    if (commit || ack || request) assert (right_2);
    if (nak) assert (right_2 || counts[3]);
    if (commit) assert (ack && !discard && !request && !nak);
    if (started && !was_reset) begin
      assert (expected == before + commit);
      if (commit) assert (number_2 == before);
      if (end_2) assert (commit != discard);
    end
    if (was_reset && started) assert (expected == 0 && !commit && !ack && !request && !nak);
  end

  (* hierconn *) wire [10:0] \dut.count ;
  (* hierconn *) wire [31:0] \dut.header ;
  (* hierconn *) wire [31:0] \dut.crc ;
  (* hierconn *) wire \dut.crc_clear ;
  (* hierconn *) wire [23:0] \dut.shift ;
  (* hierconn *) wire \dut.ended ;
  (* hierconn *) wire \dut.good_cobs ;
  (* hierconn *) wire \dut.good_size ;
  (* hierconn *) wire \dut.good_crc ;
  (* hierconn *) wire \dut.good_length ;
  integer place;
  always @* begin
    assert (\dut.count == bytes);
    assert (bytes <= 1025);
    if (started) assert (\dut.crc_clear == (end_1 || was_reset));
    for (place = 0; place < 32; place = place + 1) assert (\dut.crc [place] == !divided[31 - place]);
    if (bytes > 3) assert (\dut.header == header);
    if (bytes == 1) assert (\dut.shift [23:16] == header[7:0]);
    if (bytes == 2) assert (\dut.shift [23:8] == header[15:0]);
    if (bytes == 3) assert (\dut.shift == header[23:0]);
    if (\dut.ended && !was_reset) assert (right_1
      == (\dut.good_cobs && \dut.good_size && \dut.good_crc && \dut.good_length ));
    assert (\dut.ended == end_1);
    if (end_1) assert (bytes == 0);
    if (\dut.ended && \dut.good_size ) assert (\dut.header == header);
  end

endmodule
