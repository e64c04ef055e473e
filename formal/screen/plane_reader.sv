// SPDX-License-Identifier: Apache-2.0
//
// plane_reader: whatever comes and waits, exactly as many bytes leave as were asked for, the last one
// marked, each the right one of its pixel; a shown byte stays until it is taken; no pixel is taken that gives
// no byte.

module plane_reader_properties #(
  parameter value_bytes = 3,
  parameter depth_bytes = 2,
  parameter count_bits = 5
) (
  input clk,
  input reset,
  input request_valid,
  input [1:0] request_plane,
  input [count_bits - 1:0] request_count,
  input pixel_valid,
  input [8 * (value_bytes + depth_bytes) - 1:0] pixel_data,
  input [15:0] pixel_edges,
  input byte_ready
);

  localparam larger = value_bytes > depth_bytes ? value_bytes : depth_bytes;
  localparam held_bytes = larger > 2 ? larger : 2;

  wire request_ready, pixel_ready, byte_valid, byte_last;
  wire [7:0] byte_data;

  plane_reader dut (
    .clk(clk), .reset(reset),
    .request_valid(request_valid), .request_ready(request_ready),
    .request_plane(request_plane), .request_count(request_count),
    .pixel_valid(pixel_valid), .pixel_ready(pixel_ready),
    .pixel_data(pixel_data), .pixel_edges(pixel_edges),
    .byte_valid(byte_valid), .byte_ready(byte_ready), .byte_last(byte_last), .byte_data(byte_data)
  );

  (* hierconn *) wire \dut.running ;
  (* hierconn *) wire \dut.at_last ;
  (* hierconn *) wire [1:0] \dut.plane ;
  (* hierconn *) wire [2:0] \dut.held_left ;
  (* hierconn *) wire [8 * held_bytes - 1:0] \dut.held ;
  (* hierconn *) wire [count_bits - 1:0] \dut.count_left ;

  // What is asked for is there, and more than nothing.
  always @* if (request_valid) assume (request_count != 0 && (depth_bytes != 0 || request_plane != 1));

  wire [7:0] size = \dut.plane [1] ? 2 : \dut.plane [0] ? depth_bytes : value_bytes;
  wire asked = request_valid && request_ready;
  wire taken = pixel_valid && pixel_ready;
  wire given = byte_valid && byte_ready;

  // Bytes still to come; the bytes of the pixel that is sent, the next one lowest, and how many are left.
  reg [count_bits - 1:0] left = 0;
  reg [63:0] pixel;
  reg [7:0] rest = 0;
  always @(posedge clk) begin
    if (given) begin
      left <= left - 1;
      rest <= left == 1 ? 0 : rest - 1;
      pixel <= pixel >> 8;
    end
    if (taken) begin
      rest <= size;
      pixel <= \dut.plane [1] ? pixel_edges : \dut.plane [0] ? pixel_data >> 8 * value_bytes :
        pixel_data & ((65'd1 << 8 * value_bytes) - 1);
    end
    if (asked) left <= request_count;
    if (reset) begin
      left <= 0;
      rest <= 0;
    end
  end

  always @* begin
    assert (request_ready == (left == 0));
    assert (byte_valid == (rest != 0));
    if (byte_valid) assert (left != 0 && byte_last == (left == 1) && byte_data == pixel[7:0]);
    // A pixel is taken only where its first byte is among those asked for.
    if (taken) assert (left > given && rest == given);

    assert (\dut.running == (left != 0) && \dut.held_left == rest && rest <= 4);
    if (left != 0) assert (\dut.count_left == left && (depth_bytes != 0 || \dut.plane != 1));
    if (left == 0) assert (rest == 0);
    if (left != 0) assert (\dut.at_last == (left == 1));
    if (rest != 0) assert (rest <= size && \dut.held == pixel);
  end

  reg held = 0;
  reg [7:0] held_byte;
  always @(posedge clk) begin
    held <= byte_valid && !byte_ready && !reset;
    held_byte <= byte_data;
  end
  always @* if (held) assert (byte_valid && byte_data == held_byte);

endmodule
