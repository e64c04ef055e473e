// SPDX-License-Identifier: Apache-2.0
//
// span_walker: a span of `count` (pixels minus 2) gives count + 2 pixels, one of a negative count a single
// one, with columns that rise by one from the span's own (all bits inverted where mirrored), the span's y,
// and `last` on the last pixel of a last span alone. Spans follow each other without a bubble.

module span_walker_properties #(
  parameter coord_bits = 3,
  parameter column_bits = 4
) (
  input clk,
  input reset,
  input span_valid,
  input span_last,
  input span_mirror,
  input [column_bits - 1:0] span_column,
  input [coord_bits - 1:0] span_y,
  input signed [column_bits - 1:0] span_count,
  input advance
);

  wire span_wanted, span_single, span_ending, pixel_valid, pixel_last;
  wire [coord_bits - 1:0] pixel_x, pixel_y;

  span_walker dut (
    .clk(clk), .reset(reset),
    .span_valid(span_valid), .span_wanted(span_wanted), .span_last(span_last), .span_mirror(span_mirror),
    .span_column(span_column), .span_y(span_y), .span_count(span_count),
    .span_single(span_single), .span_ending(span_ending), .advance(advance),
    .pixel_valid(pixel_valid), .pixel_last(pixel_last), .pixel_x(pixel_x), .pixel_y(pixel_y)
  );

  (* hierconn *) wire signed [column_bits - 1:0] \dut.count ;
  (* hierconn *) wire \dut.last ;
  (* hierconn *) wire \dut.mirror ;

  // The span that is drawn, pixels it is to have, and the pixel that stands at the output, from 0.
  reg last, mirror;
  reg [coord_bits - 1:0] column, y;
  reg [column_bits:0] pixels = 0, at = 0;
  wire taken = span_valid && span_wanted && advance;
  wire drawn = pixel_valid && advance;
  always @(posedge clk) begin
    if (taken) begin
      last <= span_last;
      mirror <= span_mirror;
      column <= span_column;
      y <= span_y;
      pixels <= span_count < 0 ? 1 : span_count + 2;
      at <= 0;
    end else if (drawn) at <= at + 1;
    if (reset) begin
      pixels <= 0;
      at <= 0;
    end
  end

  wire [coord_bits - 1:0] u = column + at;
  always @* begin
    // Exactly `pixels` pixels, and then the next span or none.
    assert (at <= pixels);
    assert (pixel_valid == (at < pixels));
    assert (span_wanted == (at + 1 >= pixels));
    if (pixel_valid) begin
      assert (pixel_x == (mirror ? ~u : u));
      assert (pixel_y == y);
      assert (pixel_last == (last && at + 1 == pixels));
    end
    // What the lanes make their copies of span_wanted from.
    assert (span_single == (span_count < 0));
    assert (span_ending == (at + 2 == pixels));
    // The count is that of the pixels after this one, minus 1.
    if (at + 1 < pixels) assert (\dut.count >= 0 && {1'b0, \dut.count } + 2 == pixels - at);
    else assert (\dut.count < 0);
    if (at < pixels) assert (\dut.last == last && \dut.mirror == mirror);
  end

  // A pixel that may not advance stays.
  reg held = 0;
  reg [2 * coord_bits:0] held_pixel;
  always @(posedge clk) begin
    held <= pixel_valid && !advance && !reset;
    held_pixel <= {pixel_last, pixel_x, pixel_y};
  end
  always @* if (held) assert (pixel_valid && {pixel_last, pixel_x, pixel_y} == held_pixel);

endmodule
