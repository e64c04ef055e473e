// SPDX-License-Identifier: Apache-2.0
//
// raster_core comes to rest whatever it was sent: with the sink ready, every cycle in which no beat is
// accepted makes `rank` smaller, a number made of what is on its way. At zero the core is idle, unless a
// packet has begun and its next beat is awaited, which is then accepted at once. So after the last beat of
// any packet, with any bits, the core is idle within `bound` cycles, and no beat waits for longer.
//
// In a cycle a pixel is drawn, or there is a bubble: no span waits at the chain's end. A pixel makes `pixels`
// smaller. In a bubble everything before the chain's end moves: `way`, from what is farthest back to the
// chain's end, is shorter.

module raster_core_idle_properties `include "raster_core.svh"

  // Most pixels of a span, and scanlines of a minor edge: the largest count, plus 2.
  localparam integer most = (1 << column_bits - 1) + 1;
  localparam integer bound = most * (4 * most + 6 + span_depth) + most + 4 * most + span_depth + 9;

  function integer segment(input signed [column_bits - 1:0] rows);
    segment = rows < 0 ? 1 : rows + 2;
  endfunction

  integer scanlines, spans, wait_to_take, way, tail, pixels, rank, index;
  always @* begin
    // Scanlines of the primitive in stage 0 that are still to come.
    scanlines = 0;
    if (\dut.walker_inst.valid_0 )
      scanlines = segment(\dut.walker_inst.rows )
        + (\dut.walker_inst.second_pending ? segment(\dut.walker_inst.rows_second ) : 0);

    // Spans, each of at most `most` pixels, and the pixels of the one that is drawn.
    spans = scanlines + (\dut.loader_inst.full ? 2 * most : 0)
      + \dut.walker_inst.valid_1 + \dut.walker_inst.valid_2
      + \dut.walker_inst.valid_3 ;
    for (index = 0; index < 3; index = index + 1) spans = spans + \dut.walker_inst.valids [index];
    for (index = 0; index < span_depth; index = index + 1) spans = spans + \dut.chain_inst.held [index];
    pixels = most * spans + (wanted ? 0 : \dut.span_inst.count + 1);

    // Moves until the waiting packet is taken: primitives enter three stages apart.
    wait_to_take = \dut.walker_inst.first_0 ? 3 : \dut.walker_inst.first_1 ? 2 : 1;
    if (scanlines > wait_to_take) wait_to_take = scanlines;
    way = 0;
    for (index = 0; index < span_depth; index = index + 1) if (\dut.chain_inst.held [index]) way = index;
    for (index = 0; index < 3; index = index + 1)
      if (\dut.walker_inst.valids [index]) way = index + span_depth;
    if (\dut.walker_inst.valid_3 ) way = 3 + span_depth;
    if (\dut.walker_inst.valid_2 ) way = 4 + span_depth;
    if (\dut.walker_inst.valid_1 ) way = 5 + span_depth;
    if (\dut.walker_inst.valid_0 ) way = 5 + span_depth + scanlines;
    if (\dut.loader_inst.full ) way = 5 + span_depth + 2 * most + wait_to_take;

    // From the drawn pixel to the port.
    tail = spans != 0 || !wanted || \dut.span_inst.valid ? 3 : \dut.clamped_valid ? 2 : pixel_valid ? 1 : 0;
    rank = pixels + way + tail + !advance;
  end

  reg draining = 0, was_reset = 0;
  integer last_rank;
  always @(posedge clk) begin
    draining <= pixel_ready && !(setup_valid && setup_ready) && !reset;
    was_reset <= reset;
    last_rank <= rank;
  end

  always @* begin
    assert (rank >= 0 && rank <= bound);
    if (draining) assert (rank < last_rank || rank == 0);
    if (rank == 0) assert (setup_ready && idle == !\dut.loader_busy );
    if (idle) assert (rank == 0);
    if (was_reset) assert (idle);
  end

endmodule
