// SPDX-License-Identifier: Apache-2.0
//
// edge_walker: a primitive gives exactly its scanlines, (rows_first + 2) + (rows_second + 2) of them (one
// where the field is negative), y rising by one, `last` on the last one alone. Each scanline with pixels
// gives one span: it starts at the major column and counts minor - major - 2; one of minor = major (-2) gives
// none, nor any other even negative. To the channels: primitives enter at least three scanlines apart, `copy`
// comes in the first cycle of a first scanline in stage 1, and channel_carry is the major edge's, unless the
// primitive steps fractionally.

module edge_walker_properties #(
  parameter coord_bits = 3,
  parameter column_bits = 4,
  parameter edge_bits = 5
) (
  input clk,
  input reset,
  input enable,
  input setup_valid, setup_has_second, setup_mirror, setup_fractional,
  input [coord_bits - 1:0] setup_y,
  input signed [column_bits - 1:0] setup_rows_first, setup_rows_second,
  input [column_bits - 1:0] setup_major_column, setup_minor_column, setup_second_column,
  input [column_bits - 1:0] setup_major_step, setup_minor_step, setup_second_step,
  input [edge_bits:0] setup_major_error, setup_minor_error, setup_second_error,
  input [edge_bits:0] setup_major_decrement, setup_minor_decrement, setup_second_decrement,
  input [edge_bits - 1:0] setup_major_increment, setup_minor_increment, setup_second_increment
);

  wire busy, setup_ready, words_pending, words_copy, channel_first_coming, channel_carry;
  wire span_coming, span_valid, span_last, span_mirror;
  wire [column_bits - 1:0] span_column;
  wire signed [column_bits - 1:0] span_count;
  wire [coord_bits - 1:0] span_y;

  edge_walker dut (
    .clk(clk), .reset(reset), .enable(enable), .busy(busy),
    .setup_valid(setup_valid), .setup_ready(setup_ready), .setup_has_second(setup_has_second),
    .setup_mirror(setup_mirror), .setup_fractional(setup_fractional), .setup_y(setup_y),
    .setup_rows_first(setup_rows_first), .setup_rows_second(setup_rows_second),
    .setup_major_column(setup_major_column), .setup_minor_column(setup_minor_column),
    .setup_second_column(setup_second_column), .setup_major_error(setup_major_error),
    .setup_minor_error(setup_minor_error), .setup_second_error(setup_second_error),
    .setup_major_step(setup_major_step), .setup_minor_step(setup_minor_step),
    .setup_second_step(setup_second_step), .setup_major_increment(setup_major_increment),
    .setup_minor_increment(setup_minor_increment), .setup_second_increment(setup_second_increment),
    .setup_major_decrement(setup_major_decrement), .setup_minor_decrement(setup_minor_decrement),
    .setup_second_decrement(setup_second_decrement), .words_pending(words_pending), .words_copy(words_copy),
    .channel_first_coming(channel_first_coming), .channel_carry(channel_carry), .span_coming(span_coming),
    .span_valid(span_valid), .span_last(span_last), .span_mirror(span_mirror), .span_column(span_column),
    .span_y(span_y), .span_count(span_count)
  );

  function [column_bits + 1:0] segment(input signed [column_bits - 1:0] rows);
    segment = rows < 0 ? 1 : rows + 2;
  endfunction

  // The primitive in stage 0: scanlines of its two edges that are still to come, and where it is.
  reg valid_0 = 0, first_0 = 0, mirror_0, fractional_0;
  reg [column_bits + 1:0] left = 0, left_second = 0;
  reg [coord_bits - 1:0] y_0;
  wire last_0 = left + left_second == 1;
  wire take = setup_valid && setup_ready;
  always @(posedge clk) begin
    if (enable) first_0 <= take;
    if (take) begin
      valid_0 <= 1;
      left <= segment(setup_rows_first);
      left_second <= setup_has_second ? segment(setup_rows_second) : 0;
      {mirror_0, fractional_0, y_0} <= {setup_mirror, setup_fractional, setup_y};
    end else if (enable && valid_0) begin
      y_0 <= y_0 + 1;
      left <= left > 1 ? left - 1 : left_second;
      if (left == 1) left_second <= 0;
      valid_0 <= !last_0;
    end
    if (reset) begin
      {valid_0, first_0} <= 0;
      {left, left_second} <= 0;
    end
  end

  // Stages 1 to 6; from stage 2 on with the carry of stage 1, from stage 3 on with the columns that the two
  // DDAs gave in stage 2.
  (* hierconn *) wire [column_bits - 1:0] \dut.column_2 ;
  (* hierconn *) wire [column_bits - 1:0] \dut.minor_column_2 ;
  (* hierconn *) wire \dut.carry_1 ;
  localparam scanline_bits = 2 * column_bits + coord_bits + 2;
  reg [6:1] valid = 0;
  reg first_1 = 0, first_2 = 0, fractional_1, carry_2;
  reg last_1, mirror_1, last_2, mirror_2;
  reg [coord_bits - 1:0] y_1, y_2;
  reg [scanline_bits - 1:0] scanline_3, scanline_4, scanline_5, scanline_6;
  always @(posedge clk) begin
    if (enable) begin
      valid <= {valid[5:1], valid_0};
      {first_1, first_2} <= {first_0, first_1};
      {last_1, mirror_1, y_1, fractional_1} <= {last_0, mirror_0, y_0, fractional_0};
      carry_2 <= \dut.carry_1 && !fractional_1;
      {last_2, mirror_2, y_2} <= {last_1, mirror_1, y_1};
      scanline_3 <= {\dut.minor_column_2 , \dut.column_2 , y_2, mirror_2, last_2};
      {scanline_4, scanline_5, scanline_6} <= {scanline_3, scanline_4, scanline_5};
    end
    if (reset) {valid, first_1, first_2} <= 0;
  end
  function [column_bits - 1:0] count_of(input [scanline_bits - 1:0] scanline);
    count_of = scanline[scanline_bits - 1 -: column_bits]
      - scanline[scanline_bits - column_bits - 1 -: column_bits] - 2;
  endfunction
  // A count of -2, an empty span, gives none, nor any other that is even and negative.
  function has_pixels(input [scanline_bits - 1:0] scanline);
    has_pixels = count_of(scanline) < 1 << column_bits - 1 || count_of(scanline) & 1'b1;
  endfunction
  wire [column_bits - 1:0] minor, major;
  wire [coord_bits - 1:0] y;
  wire mirror, last;
  assign {minor, major, y, mirror, last} = scanline_6;

  // A first scanline has just come to stage 1.
  reg arrives = 0;
  always @(posedge clk) arrives <= first_0 && enable;

  always @* begin
    assert (span_valid == (valid[6] && has_pixels(scanline_6)));
    if (span_valid) begin
      assert (span_column == major && span_y == y && span_mirror == mirror && span_last == last);
      assert (span_count == count_of(scanline_6));
    end
    // What the channels are told.
    assert (channel_first_coming == first_1 && words_pending == first_0 && words_copy == arrives);
    if (valid[2]) assert (channel_carry == carry_2);
    assert (first_0 + first_1 + first_2 <= 1);
    if (take) assert (!first_0 && !first_1);
    if (take) assert (!valid_0 || last_0);
    // Busy while anything is under way.
    if (valid_0 || valid[1] || valid[2] || valid[3]) assert (busy);
    if (span_valid || span_coming) assert (busy);
  end

  // What makes it so: the registers by name, stage by stage.
  (* hierconn *) wire \dut.valid_0 ;
  (* hierconn *) wire \dut.first_0 ;
  (* hierconn *) wire \dut.spacing ;
  (* hierconn *) wire \dut.second_pending ;
  (* hierconn *) wire signed [column_bits - 1:0] \dut.rows ;
  (* hierconn *) wire signed [column_bits - 1:0] \dut.rows_second ;
  (* hierconn *) wire \dut.mirror_0 ;
  (* hierconn *) wire \dut.fractional_0 ;
  (* hierconn *) wire [coord_bits - 1:0] \dut.y_0 ;
  (* hierconn *) wire \dut.valid_1 ;
  (* hierconn *) wire \dut.first_1 ;
  (* hierconn *) wire \dut.last_1 ;
  (* hierconn *) wire \dut.mirror_1 ;
  (* hierconn *) wire \dut.fractional_1 ;
  (* hierconn *) wire [coord_bits - 1:0] \dut.y_1 ;
  (* hierconn *) wire \dut.valid_2 ;
  (* hierconn *) wire \dut.last_2 ;
  (* hierconn *) wire \dut.mirror_2 ;
  (* hierconn *) wire [coord_bits - 1:0] \dut.y_2 ;
  (* hierconn *) wire \dut.valid_3 ;
  (* hierconn *) wire [2:0] \dut.valids ;
  (* hierconn *) wire [4 * column_bits - 1:0] \dut.columns ;
  (* hierconn *) wire [4 * column_bits - 1:0] \dut.counts ;
  (* hierconn *) wire [4 * coord_bits - 1:0] \dut.ys ;
  (* hierconn *) wire [3:0] \dut.lasts ;
  (* hierconn *) wire [3:0] \dut.mirrors ;
  always @* begin
    assert (\dut.valid_0 == valid_0 && \dut.first_0 == first_0 && \dut.first_1 == first_1);
    assert (\dut.spacing == (first_0 || first_1));
    assert (\dut.second_pending == (left_second != 0));
    assert (valid_0 ? left == segment(\dut.rows ) : left + left_second == 0 && \dut.rows < 0);
    if (left_second != 0) assert (left_second == segment(\dut.rows_second ));
    if (first_0) assert (valid_0 && \dut.y_0 == y_0);
    if (valid_0) assert (\dut.mirror_0 == mirror_0 && \dut.fractional_0 == fractional_0);
    if (valid_0 && !first_0) assert (y_0 == next_y);
    assert (valid[3:1] == {\dut.valid_3 , \dut.valid_2 , \dut.valid_1 });
    if (valid[1]) assert (\dut.y_1 == y_1 && \dut.last_1 == last_1 && \dut.mirror_1 == mirror_1);
    if (valid[1]) assert (\dut.fractional_1 == fractional_1);
    if (valid[2]) assert (\dut.y_2 == y_2 && \dut.last_2 == last_2 && \dut.mirror_2 == mirror_2);
  end
  wire [coord_bits - 1:0] next_y = \dut.y_1 + 1;

  wire [4 * scanline_bits - 1:0] scanlines = {scanline_3, scanline_4, scanline_5, scanline_6};
  genvar stage;
  generate
    for (stage = 3; stage <= 6; stage = stage + 1) begin : stages
      wire [scanline_bits - 1:0] scanline = scanlines[(6 - stage) * scanline_bits +: scanline_bits];
      always @* if (valid[stage]) begin
        assert (\dut.counts [(6 - stage) * column_bits +: column_bits] == count_of(scanline));
        assert ({\dut.columns [(6 - stage) * column_bits +: column_bits],
          \dut.ys [(6 - stage) * coord_bits +: coord_bits], \dut.mirrors [6 - stage], \dut.lasts [6 - stage]}
          == scanline[scanline_bits - column_bits - 1:0]);
      end
      if (stage > 3) always @* assert (\dut.valids [6 - stage] == (valid[stage] && has_pixels(scanline)));
    end
  endgenerate

endmodule
