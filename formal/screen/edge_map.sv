// SPDX-License-Identifier: Apache-2.0
//
// The line buffers of edge_map: at one free column, what a pixel meets are the pixels of the last two
// scanlines of its frame, for any size of frame from 3 columns on, frames back to back. The memory is cut
// out; a word that is read in the cycle of its writing is free.

module edge_map_properties #(
  parameter max_width = 5,
  parameter coord_bits = 3,
  parameter depth_bits = 8
) (
  input clk,
  input reset,
  input frame_valid,
  input [coord_bits:0] frame_width,
  input [coord_bits:0] frame_height,
  input frame_variant,
  input pixel_valid,
  input [23:0] pixel_normal,
  input [depth_bits - 1:0] pixel_depth,
  input edge_ready
);

  localparam address_bits = $clog2(max_width);
  localparam pixel_bits = 24 + depth_bits;

  wire frame_ready, refused, pixel_ready, edge_valid, edge_last;
  wire [7:0] edge_normal, edge_depth;

  edge_map dut (
    .clk(clk), .reset(reset), .frame_valid(frame_valid), .frame_ready(frame_ready),
    .frame_width(frame_width), .frame_height(frame_height), .frame_variant(frame_variant),
    .refused(refused), .pixel_valid(pixel_valid), .pixel_ready(pixel_ready),
    .pixel_normal(pixel_normal), .pixel_depth(pixel_depth), .edge_valid(edge_valid),
    .edge_ready(edge_ready), .edge_last(edge_last), .edge_normal(edge_normal), .edge_depth(edge_depth)
  );

  (* hierconn *) wire \dut.streaming ;
  (* hierconn *) wire \dut.repeating ;
  (* hierconn *) wire \dut.ending ;
  (* hierconn *) wire \dut.begun ;
  (* hierconn *) wire \dut.second ;
  (* hierconn *) wire \dut.step ;
  (* hierconn *) wire \dut.advance ;
  (* hierconn *) wire [coord_bits:0] \dut.columns ;
  (* hierconn *) wire [coord_bits:0] \dut.columns_left ;
  (* hierconn *) wire [address_bits - 1:0] \dut.column ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_1 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_2 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_3 ;
  // From bit 0: valid, first, last, final, shows, top, below, variant.
  (* hierconn *) wire [7:0] \dut.step_1 ;
  (* hierconn *) wire [7:0] \dut.step_2 ;
  (* hierconn *) wire [7:0] \dut.step_3 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_1 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_2 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_3 ;
  (* hierconn *) wire [2 * pixel_bits - 1:0] \dut.read_data ;
  (* hierconn *) wire [2 * pixel_bits - 1:0] \dut.write_data ;

  (* anyconst *) wire [address_bits - 1:0] place;
  always @* assume (place < max_width);

  wire at_1 = \dut.step_1 [0] && \dut.address_1 == place;
  wire at_2 = \dut.step_2 [0] && \dut.address_2 == place;
  wire at_3 = \dut.step_3 [0] && \dut.address_3 == place;

  // The memory, at this column.
  reg [2 * pixel_bits - 1:0] word, fetched, read;
  reg fetched_known = 0, read_known = 0;
  always @(posedge clk) begin
    if (at_3) word <= \dut.write_data ;
    if (\dut.advance ) begin
      fetched <= word;
      fetched_known <= \dut.address_1 == place && !at_3;
      read <= fetched;
      read_known <= fetched_known;
    end
  end
  always @* if (read_known) assume (\dut.read_data == read);

  // Ideal: the pixels that this frame had here, the last and the one before, and how many, up to 2. A step
  // takes them along; `ours_k` says that the step in stage k is of the frame that is walked now.
  reg [pixel_bits - 1:0] last, before, last_1, last_2, last_3, before_1, before_2, before_3;
  reg [1:0] had = 0, had_1 = 0, had_2 = 0, had_3 = 0;
  reg ours_1 = 0, ours_2 = 0, ours_3 = 0;
  always @(posedge clk) begin
    if (\dut.advance ) begin
      {ours_1, ours_2, ours_3} <= {\dut.step , ours_1, ours_2};
      {had_1, had_2, had_3} <= {\dut.ending ? 2'd0 : had, had_1, had_2};
      {last_1, last_2, last_3} <= {last, last_1, last_2};
      {before_1, before_2, before_3} <= {before, before_1, before_2};
    end
    if (\dut.step && \dut.streaming && \dut.column == place) begin
      last <= {pixel_normal, pixel_depth};
      before <= last;
      had <= had == 2 ? 2 : had + 1;
    end
    if (frame_valid && frame_ready) had <= 0;
    if ((frame_valid && frame_ready) || reset) {ours_1, ours_2, ours_3} <= 0;
  end

  // Word, and what must stand in it where so many pixels were here.
  function holds(
    input [2 * pixel_bits - 1:0] stored, input [1:0] count,
    input [pixel_bits - 1:0] newer, input [pixel_bits - 1:0] older
  );
    holds = (count == 0 || stored[pixel_bits - 1:0] == newer)
      && (count < 2 || stored[2 * pixel_bits - 1:pixel_bits] == older);
  endfunction

  function [address_bits - 1:0] previous(input [address_bits - 1:0] column, input [coord_bits:0] columns);
    previous = column == 0 ? columns : column - 1;
  endfunction

  wire active = \dut.streaming || \dut.repeating || \dut.ending ;
  wire within = place <= \dut.columns ;
  wire needed = \dut.streaming || (\dut.repeating && \dut.column <= place);
  wire mine_1 = ours_1 && at_1, mine_2 = ours_2 && at_2, mine_3 = ours_3 && at_3;
  wire [address_bits - 1:0] from_1 = previous(\dut.column , \dut.columns );
  wire [address_bits - 1:0] from_2 = ours_1 ? previous(\dut.address_1 , \dut.columns ) : from_1;
  wire [address_bits - 1:0] from_3 = ours_2 ? previous(\dut.address_2 , \dut.columns ) : from_2;

  always @* begin
    // The claim: what was read is the last scanline and the one before, and the step knows how many.
    if (at_3) assert (holds(\dut.read_data , had_3, last_3, before_3));
    if (at_3) assert (\dut.step_3 [4] == (had_3 != 0) && \dut.step_3 [5] == (had_3 == 1));

    // The walk.
    assert (\dut.streaming + \dut.repeating + \dut.ending <= 1);
    assert (frame_ready == !active);
    if (active) begin
      assert (\dut.columns >= 2 && \dut.columns < max_width && \dut.column <= \dut.columns );
      assert (\dut.columns_left == \dut.columns - \dut.column );
    end
    if (\dut.repeating || \dut.ending || \dut.second ) assert (!active || \dut.begun );
    if (\dut.ending ) assert (\dut.column == 0 && !\dut.second );
    if (within && \dut.streaming )
      assert (had == (\dut.column > place ? 1 + \dut.begun : !\dut.begun ? 0 : \dut.second ? 1 : 2));
    if (within && \dut.repeating ) assert (had == (\dut.second ? 1 : 2));

    // Steps follow each other by one column, those of the frame before are ahead.
    assert (!ours_1 || \dut.step_1 [0]);
    assert (!ours_2 || \dut.step_2 [0]);
    assert (!ours_3 || \dut.step_3 [0]);
    if (ours_3 && \dut.step_2 [0]) assert (ours_2);
    if ((ours_3 || ours_2) && \dut.step_1 [0]) assert (ours_1);
    if (active) begin
      if (ours_1) assert (\dut.address_1 == from_1);
      if (ours_2) assert (\dut.address_2 == from_2);
      if (ours_3) assert (\dut.address_3 == from_3);
    end

    // A step that reads has none ahead of it that writes here.
    if (at_1 && had_1 != 0) assert (!at_2 && !at_3);
    if (at_2 && had_2 != 0) assert (!at_3);
    if (active && within && had != 0) begin
      assert (!at_1 || ours_1);
      assert (!at_2 || ours_2 || mine_1);
      assert (!at_3 || ours_3 || mine_1 || mine_2);
    end
    if (at_1) assert (\dut.step_1 [4] == (had_1 != 0) && \dut.step_1 [5] == (had_1 == 1));
    if (at_2) assert (\dut.step_2 [4] == (had_2 != 0) && \dut.step_2 [5] == (had_2 == 1));

    // So the word follows it.
    if (at_1 && had_1 != 0) assert (holds(word, had_1, last_1, before_1));
    if (at_2 && had_2 != 0) assert (fetched_known && holds(fetched, had_2, last_2, before_2));
    if (at_3 && had_3 != 0) assert (read_known && holds(read, had_3, last_3, before_3));
    if (active && within && needed) begin
      if (!mine_1 && !mine_2 && !mine_3) assert (holds(word, had, last, before));
      if (mine_1) assert (last == \dut.pixel_1 && had == (had_1 == 2 ? 2 : had_1 + 1));
      if (mine_2) assert (last == \dut.pixel_2 && had == (had_2 == 2 ? 2 : had_2 + 1));
      if (mine_3) assert (last == \dut.pixel_3 && had == (had_3 == 2 ? 2 : had_3 + 1));
      if (mine_1 && had_1 != 0) assert (before == last_1);
      if (mine_2 && had_2 != 0) assert (before == last_2);
      if (mine_3 && had_3 != 0) assert (before == last_3);
    end
  end

endmodule
