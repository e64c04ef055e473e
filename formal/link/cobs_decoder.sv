// SPDX-License-Identifier: Apache-2.0
//
// cobs_decoder: after any 00, whatever came before, it is what it is after a reset. One decoder runs freely;
// the other is kept in reset up to the first 00. From then on both give the same, for ever.

module cobs_decoder_properties (
  input clk,
  input reset,
  input line_valid,
  input [7:0] line_data,
  input line_error
);

  reg synced = 0, compared = 0;
  wire zero = line_valid && line_data == 0;
  always @(posedge clk) begin
    synced <= !reset && (synced || zero);
    compared <= !reset && synced;
  end

  wire [7:0] one_data, other_data;
  wire one_valid, one_end, one_good, other_valid, other_end, other_good;

  cobs_decoder one (
    .clk(clk), .reset(reset), .line_valid(line_valid), .line_data(line_data), .line_error(line_error),
    .byte_valid(one_valid), .byte_data(one_data), .frame_end(one_end), .frame_good(one_good)
  );

  cobs_decoder other (
    .clk(clk), .reset(reset || !synced), .line_valid(line_valid), .line_data(line_data),
    .line_error(line_error), .byte_valid(other_valid), .byte_data(other_data), .frame_end(other_end),
    .frame_good(other_good)
  );

  (* hierconn *) wire \one.begun ;
  (* hierconn *) wire \one.damaged ;
  (* hierconn *) wire \one.zero_due ;
  (* hierconn *) wire [7:0] \one.remaining ;
  (* hierconn *) wire \other.begun ;
  (* hierconn *) wire \other.damaged ;
  (* hierconn *) wire \other.zero_due ;
  (* hierconn *) wire [7:0] \other.remaining ;

  // One byte at most, and no end, between the first byte of a frame and its 00.
  reg had_zero = 0;
  always @(posedge clk) had_zero <= zero && !reset;

  always @* begin
    if (synced) begin
      assert (\one.begun == \other.begun && \one.damaged == \other.damaged );
      assert (\one.zero_due == \other.zero_due && \one.remaining == \other.remaining );
    end
    if (compared) begin
      assert (one_valid == other_valid && one_end == other_end && one_good == other_good);
      if (one_valid) assert (one_data == other_data);
    end
    // A frame ends at a 00 and there only, and is good only if it ends.
    if (one_end) assert (had_zero);
    if (one_good) assert (one_end);
    if (one_valid) assert (!one_end);
    if (had_zero) assert (!\one.begun && \one.remaining == 0);
  end

endmodule
