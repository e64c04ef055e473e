// SPDX-License-Identifier: Apache-2.0
//
// edge_dda: an exact rational DDA, for every edge and for ever. With m = column dy + remainder at the first
// scanline, dx = step dy + increment, and m += dx from scanline to scanline, the column stays floor(m / dy):
// there is a q with
//   over = m - q dy,   0 <= over < dy,   column = q modulo 2**column_bits.
// From scanline to scanline q grows by step + carry, and so over by increment - carry dy: those two are kept
// here, and edge_dda_exact.smt2 shows over the integers that this is m - q dy, and that floor(m / dy) is
// ceil(x - 1/2).

module edge_dda_properties #(
  parameter column_bits = 4,
  parameter edge_bits = 5
) (
  input clk,
  input enable,
  input load,
  input [column_bits - 1:0] load_column, load_step,
  input [edge_bits - 1:0] load_dy, load_remainder, load_increment
);

  // What the host sends: of every edge, whatever its numbers.
  always @* if (load) assume (load_remainder < load_dy && load_increment < load_dy);

  wire carry;
  wire [column_bits - 1:0] column;

  edge_dda dut (
    .clk(clk), .enable(enable), .load(load),
    .load_column(load_column), .load_step(load_step),
    .load_error({1'b0, load_remainder} + load_increment - load_dy),
    .load_increment(load_increment),
    .load_decrement({1'b0, load_increment} - load_dy),
    .carry(carry), .column(column)
  );

  (* hierconn *) wire [edge_bits:0] \dut.error ;
  (* hierconn *) wire [edge_bits:0] \dut.decrement ;
  (* hierconn *) wire [edge_bits - 1:0] \dut.increment ;
  (* hierconn *) wire [column_bits - 1:0] \dut.start ;
  (* hierconn *) wire [column_bits - 1:0] \dut.step ;
  (* hierconn *) wire \dut.starting ;
  (* hierconn *) wire \dut.carry_reg ;

  // The exact edge at the scanline that stands in the first stage. One bit more than any value here needs.
  reg valid = 0, fresh = 0;
  reg [column_bits - 1:0] q, step;
  reg [edge_bits + 1:0] over, increment, dy;
  wire carries = over + increment >= dy;
  always @(posedge clk) if (enable) begin
    fresh <= load;
    if (load) begin
      valid <= 1;
      q <= load_column;
      step <= load_step;
      over <= load_remainder;
      increment <= load_increment;
      dy <= load_dy;
    end else begin
      q <= q + step + carries;
      over <= over + increment - (carries ? dy : 0);
    end
  end

  // The same, one scanline later: that of the column.
  reg shown = 0, shown_carries;
  reg [column_bits - 1:0] shown_q;
  reg [edge_bits + 1:0] shown_over, shown_dy;
  always @(posedge clk) if (enable) begin
    shown <= valid;
    {shown_q, shown_over, shown_dy, shown_carries} <= {q, over, dy, carries};
  end

  wire [edge_bits:0] error = over + increment - dy;
  wire [edge_bits:0] decrement = increment - dy;
  wire [column_bits - 1:0] next_q = shown_q + step + shown_carries;
  always @* begin
    // The claim.
    if (shown) begin
      assert (shown_over < shown_dy);
      assert (column == shown_q);
    end
    // The carry says whether the edge moves one pixel more than its step.
    if (valid) assert (carry == carries);
    // What makes it so.
    if (valid) begin
      assert (over < dy && increment < dy && dy < 1 << edge_bits);
      assert (\dut.error == error);
      assert (\dut.increment == increment);
      assert (\dut.decrement == decrement);
      assert (\dut.step == step);
      assert (\dut.starting == fresh);
      if (fresh) assert (\dut.start == q);
    end
    if (shown) assert (\dut.carry_reg == shown_carries);
    if (shown && !fresh) assert (valid && shown_dy == dy && q == next_q);
    if (valid && !shown) assert (fresh);
  end

endmodule
