// SPDX-License-Identifier: Apache-2.0
//
// shade's stream: a pixel, chosen freely, comes out behind those ahead of it and before all others, with what
// came along with it, once; the state is taken only while no pixel is in the unit. The power tables are cut
// out.

module shade_properties #(
  parameter num_channels = 2,
  parameter num_specular = 1,
  parameter value_bits = 4,
  parameter shade_guard_bits = 4,
  parameter along_bits = 4,
  parameter stages = 13
) (
  input clk,
  input reset,
  input state_valid,
  input [31:0] state_address,
  input [31:0] state_data,
  input pixel_valid,
  input [num_channels * (value_bits + shade_guard_bits) - 1:0] pixel_value,
  input [along_bits - 1:0] pixel_along,
  input shaded_ready,
  input chosen
);

  wire state_ready, pixel_ready, shaded_valid, busy;
  wire [3 * value_bits - 1:0] shaded_value;
  wire [along_bits - 1:0] shaded_along;

  shade dut (
    .clk(clk), .reset(reset),
    .state_valid(state_valid), .state_ready(state_ready), .state_address(state_address),
    .state_data(state_data),
    .pixel_valid(pixel_valid), .pixel_ready(pixel_ready), .pixel_value(pixel_value),
    .pixel_along(pixel_along),
    .shaded_valid(shaded_valid), .shaded_ready(shaded_ready), .shaded_value(shaded_value),
    .shaded_along(shaded_along), .busy(busy)
  );

  (* hierconn *) wire [stages - 1:0] \dut.valid ;
  (* hierconn *) wire [stages * along_bits - 1:0] \dut.along ;
  (* hierconn *) wire [3 * value_bits + along_bits - 1:0] \dut.output_inst.spare ;

  wire taken = pixel_valid && pixel_ready;
  wire given = shaded_valid && shaded_ready;

  // Pixels in stages above `place`; stages are numbered from 1.
  function [4:0] above(input [stages - 1:0] valid, input [4:0] place);
    integer stage;
    begin
      above = 0;
      for (stage = 1; stage <= stages; stage = stage + 1)
        if (stage > place) above = above + valid[stage - 1];
    end
  endfunction

  // The chosen pixel: where it is (behind the stages stand the output's register and its spare one), what
  // came with it, and how many are ahead of it.
  localparam front = stages + 1, spare = stages + 2;
  reg following = 0;
  reg [4:0] place, ahead, count = 0;
  reg [along_bits - 1:0] tag;
  always @(posedge clk) begin
    count <= count + taken - given;
    if (!following && chosen && taken) begin
      following <= 1;
      place <= 1;
      ahead <= count - given;
      tag <= pixel_along;
    end
    if (following) begin
      if (place < stages && pixel_ready) place <= place + 1;
      if (place == stages && pixel_ready) place <= shaded_valid && !shaded_ready ? spare : front;
      if (place == spare && shaded_ready) place <= front;
      if (given && ahead != 0) ahead <= ahead - 1;
      if (given && ahead == 0) following <= 0;
    end
    if (reset) begin
      following <= 0;
      count <= 0;
    end
  end

  always @* begin
    // What is claimed.
    if (following && given && ahead == 0) assert (shaded_along == tag);
    if (following) assert (count > ahead);
    assert (busy == (count != 0));
    if (count != 0) assert (!state_ready);

    // Why it holds.
    assert (count == above(\dut.valid , 0) + shaded_valid + !pixel_ready);
    if (!pixel_ready) assert (shaded_valid);
    if (following) begin
      assert (place >= 1 && place <= spare);
      if (place <= stages) begin
        assert (\dut.valid [place - 1] && \dut.along [(place - 1) * along_bits +: along_bits] == tag);
        assert (ahead == above(\dut.valid , place) + shaded_valid + !pixel_ready);
      end
      if (place == front) assert (shaded_valid && shaded_along == tag && ahead == 0);
      if (place == spare)
        assert (!pixel_ready && \dut.output_inst.spare [3 * value_bits +: along_bits] == tag && ahead == 1);
    end
  end

  // AXI4-Stream: a shown pixel stays until it is taken.
  reg held = 0;
  reg [3 * value_bits + along_bits - 1:0] held_pixel;
  always @(posedge clk) begin
    held <= shaded_valid && !shaded_ready && !reset;
    held_pixel <= {shaded_along, shaded_value};
  end
  always @* if (held) assert (shaded_valid && {shaded_along, shaded_value} == held_pixel);

endmodule
