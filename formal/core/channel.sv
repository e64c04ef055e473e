// SPDX-License-Identifier: Apache-2.0
//
// scanline_channel and pixel_channel: at scanline m of a primitive and N pixels right of the major edge
// without carries (the carries so far and the pixels along the span), modulo 2**word_width and for ever,
//   value = f(m, N) = I + m d_row + C(m, 2) dd_row + N d_col + m N dd_mixed + C(N + 1, 2) dd_col
// for all words and carries. f is kept here as its prefix sums, row = f's step down, col its step to the
// right:
//   down:  col += dd_mixed + carry * dd_col,  f += row + carry * col (the new one),
//          row += dd_row + carry * dd_mixed,
//   right: f += col + dd_col,  col += dd_col;
// channel_polynomial.smt2 shows over the integers that these are f. Words beyond the channel's order count as
// zero. Between the two channels stands any delay, as the span chain gives, and enables stall at will. What
// is assumed of the edge walker, edge_walker.sv proves: primitives enter at least three scanlines apart, and
// `copy` comes when a first scanline has just come to stage 1.

`ifndef MAX_ORDER_0
`define LINEAR
`endif
`ifdef MAX_ORDER_2
`define QUADRATIC
`endif

module channel_properties #(
  parameter word_width = 4,
  parameter max_order = 2
) (
  input clk,
  input enable,
  input enters,
  input carry,
  input [word_width - 1:0] setup_value, setup_d_row, setup_d_col, setup_dd_row, setup_dd_mixed, setup_dd_col,
  input capture,
  input advance,
  input load
);

  localparam w = word_width;
  localparam [w - 1:0] zero = 0;

  // A place on a primitive: its words dd_col, dd_mixed, dd_row, then col, row, and f lowest.
  localparam place_bits = 6 * w;
  function [w - 1:0] word(input [place_bits - 1:0] place, input integer index);
    word = place >> index * w;
  endfunction
  `define F(place) word(place, 0)
  `define ROW(place) word(place, 1)
  `define COL(place) word(place, 2)
  `define DD_ROW(place) word(place, 3)
  `define DD_MIXED(place) word(place, 4)
  `define DD_COL(place) word(place, 5)

  function [place_bits - 1:0] right(input [place_bits - 1:0] at);
    right = {at[place_bits - 1:3 * w], `COL(at) + `DD_COL(at), `ROW(at), `F(at) + (`COL(at) + `DD_COL(at))};
  endfunction
  function [w - 1:0] col_below(input [place_bits - 1:0] at, input carry);
    col_below = `COL(at) + (carry ? `DD_MIXED(at) + `DD_COL(at) : `DD_MIXED(at));
  endfunction
  function [w - 1:0] row_below(input [place_bits - 1:0] at, input carry);
    row_below = `ROW(at) + (carry ? `DD_ROW(at) + `DD_MIXED(at) : `DD_ROW(at));
  endfunction
  function [place_bits - 1:0] down(input [place_bits - 1:0] at, input carry);
    down = {at[place_bits - 1:3 * w], col_below(at, carry), row_below(at, carry),
      `F(at) + (`ROW(at) + (carry ? col_below(at, 1'b1) : zero))};
  endfunction
  // What a primitive begins with: the words that the channel's order has.
  wire [place_bits - 1:0] words = {
    max_order >= 2 ? {setup_dd_col, setup_dd_mixed, setup_dd_row} : {3{zero}},
    max_order >= 1 ? {setup_d_col, setup_d_row} : {2{zero}}, setup_value
  };

  // Stages 0 to 2 of the edge walker: where first scanlines are, and when words are copied.
  reg first_0 = 0, first_1 = 0, first_2 = 0, copy = 0;
  always @* if (enters) assume (!first_0 && !first_1);
  always @(posedge clk) begin
    copy <= first_0 && enable;
    if (enable) {first_0, first_1, first_2} <= {enters, first_0, first_1};
  end

  wire [w - 1:0] span_value, span_d_col, span_dd_col;
  scanline_channel dut (
    .clk(clk), .enable(enable), .copy(copy), .first(first_2), .carry(carry),
    .setup_value(setup_value), .setup_d_row(setup_d_row), .setup_d_col(setup_d_col),
    .setup_dd_row(setup_dd_row), .setup_dd_mixed(setup_dd_mixed), .setup_dd_col(setup_dd_col),
    .span_value(span_value), .span_d_col(span_d_col), .span_dd_col(span_dd_col)
  );

  // Places of the words that were copied last, and of the scanlines in stages 3 to 6; their carries.
  reg [place_bits - 1:0] at_0, at_3, at_4, at_5, at_6;
  reg copied = 0, valid_3 = 0, valid_4 = 0, valid_5 = 0, valid_6 = 0;
  reg first_3 = 0, first_4 = 0, first_5 = 0;
  reg carry_3, carry_4, carry_5, carry_6;
  always @(posedge clk) begin
    if (copy) begin
      copied <= 1;
      at_0 <= words;
    end
    if (enable) begin
      at_3 <= first_2 ? at_0 : down(at_3, carry_3);
      {at_4, at_5, at_6} <= {at_3, at_4, at_5};
      {valid_3, valid_4, valid_5, valid_6} <= {valid_3 || first_2, valid_3, valid_4, valid_5};
      {first_3, first_4, first_5} <= {first_2, first_3, first_4};
      {carry_3, carry_4, carry_5, carry_6} <= {carry, carry_3, carry_4, carry_5};
    end
  end

  // A span in the chain, and the pixel that is drawn.
  reg held = 0, drawn = 0;
  reg [place_bits - 1:0] at_held, at_drawn;
  reg [w - 1:0] held_value, held_d_col, held_dd_col;
  always @(posedge clk) begin
    if (capture && valid_6) begin
      held <= 1;
      {at_held, held_value, held_d_col, held_dd_col} <= {at_6, span_value, span_d_col, span_dd_col};
    end
    if (advance) begin
      // What is loaded where no span is held is not shown.
      drawn <= load ? held : drawn;
      at_drawn <= load ? at_held : right(at_drawn);
    end
  end

  wire [w - 1:0] pixel_value;
  pixel_channel pixel (
    .clk(clk), .advance(advance), .load(load),
    .span_value(held_value), .span_d_col(held_d_col), .span_dd_col(held_dd_col), .pixel_value(pixel_value)
  );

  // The claim, on the ports.
  always @* begin
    if (valid_6) begin
      assert (span_value == `F(at_6));
      assert (span_d_col == `COL(right(at_6)));
      assert (span_dd_col == `DD_COL(at_6));
    end
    if (held) begin
      assert (held_value == `F(at_held));
      assert (held_d_col == `COL(right(at_held)));
      assert (held_dd_col == `DD_COL(at_held));
    end
    if (drawn) assert (pixel_value == `F(at_drawn));
  end

  // What makes it so. The stages follow each other, and the first ones are three apart.
  always @* begin
    assert (first_0 + first_1 + first_2 <= 1 && first_1 + first_2 + first_3 <= 1);
    assert (first_2 + first_3 + first_4 <= 1 && first_3 + first_4 + first_5 <= 1);
    if (copy) assert (first_1);
    if (first_2 || valid_3 || first_1 && !copy) assert (copied);
    if (first_3) assert (valid_3 && at_3 == at_0);
    if (valid_3 && !first_2 && !first_1) assert (at_3[6 * w - 1:3 * w] == at_0[6 * w - 1:3 * w]);
    if (valid_4) assert (valid_3 && (first_3 || at_3 == down(at_4, carry_4)));
    if (valid_5) assert (valid_4 && (first_4 || at_4 == down(at_5, carry_5)));
    if (valid_6) assert (valid_5 && (first_5 || at_5 == down(at_6, carry_6)));
    if (valid_3 && !valid_4) assert (first_3);
    if (valid_4 && !valid_5) assert (first_4);
    if (valid_5 && !valid_6) assert (first_5);
    assert ({first_3, first_4, first_5} == {\dut.first_3 , \dut.first_4 , \dut.first_5 });
  end

  // Words beyond the order stay zero.
  function [place_bits - 1:0] beyond(input [place_bits - 1:0] at);
    beyond = max_order == 0 ? at >> w : max_order == 1 ? at >> 3 * w : 0;
  endfunction
  always @* begin
    if (copied) assert (beyond(at_0) == 0);
    if (valid_3) assert (beyond(at_3) == 0);
    if (valid_4) assert (beyond(at_4) == 0);
    if (valid_5) assert (beyond(at_5) == 0);
    if (valid_6) assert (beyond(at_6) == 0);
    if (held) assert (beyond(at_held) == 0);
    if (drawn) assert (beyond(at_drawn) == 0);
  end

  (* hierconn *) wire \dut.first_3 ;
  (* hierconn *) wire \dut.first_4 ;
  (* hierconn *) wire \dut.first_5 ;
  (* hierconn *) wire [w - 1:0] \dut.value_0 ;
  (* hierconn *) wire [w - 1:0] \dut.value_4 ;
  always @* begin
    if (copied) assert (\dut.value_0 == `F(at_0));
    if (first_4) assert (\dut.value_4 == `F(at_4));
    if (first_5) assert (\dut.value_4 == `F(at_5));
  end

`ifdef LINEAR
  (* hierconn *) wire [w - 1:0] \dut.row_0 ;
  (* hierconn *) wire [w - 1:0] \dut.col_0 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_row_3 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_row_4 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_row_5 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_col_3 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_col_5 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_step_6 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_first_col_4 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_first_col_5 ;
  (* hierconn *) wire \dut.varying_gen_carry_3 ;
  (* hierconn *) wire \dut.varying_gen_carry_4 ;
  (* hierconn *) wire [w - 1:0] \pixel.d_col ;
  always @* begin
    if (copied) assert (\dut.row_0 == `ROW(at_0) && \dut.col_0 == `COL(at_0));
    if (valid_3) begin
      assert (\dut.varying_gen_row_3 == `ROW(at_3) && \dut.varying_gen_col_3 == `COL(at_3));
      assert (\dut.varying_gen_carry_3 == carry_3);
    end
    if (valid_4) begin
      assert (\dut.varying_gen_row_4 == `ROW(at_4));
      assert (\dut.varying_gen_first_col_4 == `COL(right(at_4)));
      assert (\dut.varying_gen_carry_4 == carry_4);
    end
    if (valid_5) begin
      assert (\dut.varying_gen_row_5 == `ROW(at_5));
      assert (\dut.varying_gen_first_col_5 == `COL(right(at_5)));
      // A carry is one more step to the right, on the next scanline.
      if (!first_4) assert (\dut.varying_gen_col_5 == (carry_5 ? col_below(at_5, 1'b1) : zero));
    end
    if (valid_6 && !first_5)
      assert (\dut.varying_gen_step_6 == `ROW(at_6) + (carry_6 ? col_below(at_6, 1'b1) : zero));
    if (drawn) assert (\pixel.d_col == `COL(right(at_drawn)));
  end
`endif

`ifdef QUADRATIC
  (* hierconn *) wire [w - 1:0] \dut.dd_row_0 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_quadratic_gen_dd_row_carry_0 ;
  (* hierconn *) wire [w - 1:0] \dut.dd_mixed_0 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_quadratic_gen_dd_mixed_carry_0 ;
  (* hierconn *) wire [w - 1:0] \dut.dd_col_0 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_quadratic_gen_dd_col_3 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_quadratic_gen_row_step_3 ;
  (* hierconn *) wire [w - 1:0] \dut.varying_gen_quadratic_gen_col_step_3 ;
  (* hierconn *) wire [w - 1:0] \pixel.dd_col ;
  always @* begin
    if (copied) begin
      assert (\dut.dd_row_0 == `DD_ROW(at_0));
      assert (\dut.varying_gen_quadratic_gen_dd_row_carry_0 == `DD_ROW(at_0) + `DD_MIXED(at_0));
      assert (\dut.dd_mixed_0 == `DD_MIXED(at_0));
      assert (\dut.varying_gen_quadratic_gen_dd_mixed_carry_0 == `DD_MIXED(at_0) + `DD_COL(at_0));
      assert (\dut.dd_col_0 == `DD_COL(at_0));
    end
    if (valid_3) assert (\dut.varying_gen_quadratic_gen_dd_col_3 == `DD_COL(at_3));
    if (valid_3 && !first_2) begin
      assert (\dut.varying_gen_quadratic_gen_row_step_3
        == `DD_ROW(at_3) + (carry_3 ? `DD_MIXED(at_3) : zero));
      assert (\dut.varying_gen_quadratic_gen_col_step_3
        == `DD_MIXED(at_3) + (carry_3 ? `DD_COL(at_3) : zero));
    end
    if (drawn) assert (\pixel.dd_col == `DD_COL(at_drawn));
  end
`endif

endmodule
