// SPDX-License-Identifier: Apache-2.0
//
// depth_test against an ideal z-buffer that decides when a pixel is accepted, at one free place. The memory
// is cut out; a word that is read in the cycle of its writing is free.

module depth_test_properties #(
  parameter width = 3,
  parameter height = 2,
  parameter coord_bits = 2,
  parameter value_bits = 2,
  parameter depth_bits = 2
) (
  input clk,
  input reset,
  input clear,
  input look,
  input look_enable,
  input [$clog2(width * height) - 1:0] look_address,
  input pixel_valid,
  input [coord_bits - 1:0] pixel_x,
  input [coord_bits - 1:0] pixel_y,
  input [value_bits - 1:0] pixel_value,
  input [depth_bits - 1:0] pixel_depth
);

  localparam words = width * height;
  localparam address_bits = $clog2(words);
  localparam pixel_bits = value_bits + 2 * coord_bits;
  localparam [depth_bits:0] empty = 1 << depth_bits;

  wire busy, drained, idle, pixel_ready, kept_valid;
  wire [coord_bits - 1:0] kept_x, kept_y;
  wire [value_bits - 1:0] kept_value;
  wire [depth_bits - 1:0] kept_depth;

  depth_test dut (
    .clk(clk), .reset(reset), .clear(clear), .busy(busy), .drained(drained), .idle(idle),
    .pixel_valid(pixel_valid), .pixel_ready(pixel_ready), .pixel_x(pixel_x), .pixel_y(pixel_y),
    .pixel_value(pixel_value), .pixel_depth(pixel_depth),
    .look(look), .look_enable(look_enable), .look_address(look_address),
    .kept_valid(kept_valid), .kept_x(kept_x), .kept_y(kept_y),
    .kept_value(kept_value), .kept_depth(kept_depth)
  );

  (* hierconn *) wire \dut.valid_1 ;
  (* hierconn *) wire \dut.valid_2 ;
  (* hierconn *) wire \dut.valid_3 ;
  (* hierconn *) wire \dut.valid_4 ;
  (* hierconn *) wire \dut.valid_5 ;
  (* hierconn *) wire \dut.valid_6 ;
  (* hierconn *) wire \dut.valid_7 ;
  (* hierconn *) wire \dut.kept_8 ;
  (* hierconn *) wire \dut.passed_3 ;
  (* hierconn *) wire \dut.passed_4 ;
  (* hierconn *) wire \dut.passed_5 ;
  (* hierconn *) wire \dut.passed_6 ;
  (* hierconn *) wire \dut.passed_7 ;
  (* hierconn *) wire \dut.same_7 ;
  (* hierconn *) wire \dut.filling ;
  (* hierconn *) wire \dut.clear_inst.draining ;
  (* hierconn *) wire [address_bits - 1:0] \dut.read_address ;
  (* hierconn *) wire \dut.write_enable ;
  (* hierconn *) wire [address_bits - 1:0] \dut.row_1 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_2 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_3 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_4 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_5 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_6 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_7 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_8 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.write_address ;
  (* hierconn *) wire [address_bits - 1:0] \dut.fill_address ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_1 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_2 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_3 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_4 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_5 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_6 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_7 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.depth_8 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.passed_depth_3 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.passed_depth_4 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.passed_depth_5 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.passed_depth_6 ;
  (* hierconn *) wire [depth_bits - 1:0] \dut.passed_depth_7 ;
  (* hierconn *) wire [depth_bits:0] \dut.read_data ;
  (* hierconn *) wire [depth_bits:0] \dut.write_data ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_1 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_2 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_3 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_4 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_5 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_6 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_7 ;
  (* hierconn *) wire [pixel_bits - 1:0] \dut.pixel_8 ;

  (* anyconst *) wire [coord_bits - 1:0] x, y;
  always @* assume (x < width && y < height);
  wire [address_bits - 1:0] place = y * width + x;

  // Two stored words that mean the same: whatever stands below the mark of an empty place.
  function same(input [depth_bits:0] one, input [depth_bits:0] other);
    same = one[depth_bits] ? other[depth_bits] : one == other;
  endfunction

  wire any = \dut.valid_1 || \dut.valid_2 || \dut.valid_3 || \dut.valid_4 || \dut.valid_5 || \dut.valid_6
    || \dut.valid_7 || \dut.kept_8 ;

  // What the port asks for: while pixels are on their way the memory moves.
  always @* assume (look_enable || (look && !any));

  // The memory, at this place: its word; whether the five registers of the read port lead to it for certain.
  // Both ports come a cycle late to the blocks, so a read meets the words that were written before it.
  reg [depth_bits:0] word, asked, fetched, banked, carried, read;
  reg asked_known = 0, fetched_known = 0, banked_known = 0, carried_known = 0, read_known = 0;
  wire written = \dut.write_enable && \dut.write_address == place;
  always @(posedge clk) begin
    if (written) word <= \dut.write_data ;
    if (look_enable) begin
      asked <= word;
      asked_known <= \dut.read_address == place && !written;
      {fetched, fetched_known} <= {asked, asked_known};
      {banked, banked_known} <= {fetched, fetched_known};
      {carried, carried_known} <= {banked, banked_known};
      {read, read_known} <= {carried, carried_known};
    end
  end
  always @* if (read_known) assume (\dut.read_data == read);

  // The ideal z-buffer at this place, after the pixel in stage k and all ahead of it; stage 9 has left.
  reg [depth_bits:0] ideal_1 = empty, ideal_2 = empty, ideal_3 = empty, ideal_4 = empty, ideal_5 = empty;
  reg [depth_bits:0] ideal_6 = empty, ideal_7 = empty, ideal_8 = empty, ideal_9 = empty;
  reg hit_1 = 0, hit_2 = 0, hit_3 = 0, hit_4 = 0, hit_5 = 0, hit_6 = 0, hit_7 = 0;
  reg won_1 = 0, won_2 = 0, won_3 = 0, won_4 = 0, won_5 = 0, won_6 = 0, won_7 = 0, won_8 = 0;
  reg [pixel_bits - 1:0] pixel_1, pixel_2, pixel_3, pixel_4, pixel_5, pixel_6, pixel_7, pixel_8;
  reg cleared = 1;
  wire hit = pixel_valid && pixel_ready && pixel_x == x && pixel_y == y;
  wire win = hit && pixel_depth < ideal_1;
  always @(posedge clk) begin
    ideal_1 <= win ? pixel_depth : ideal_1;
    {hit_1, hit_2, hit_3, hit_4} <= {hit, hit_1, hit_2, hit_3};
    {hit_5, hit_6, hit_7} <= {hit_4, hit_5, hit_6};
    {won_1, won_2, won_3, won_4} <= {win, won_1, won_2, won_3};
    {won_5, won_6, won_7, won_8} <= {won_4, won_5, won_6, won_7};
    {ideal_2, ideal_3, ideal_4, ideal_5} <= {ideal_1, ideal_2, ideal_3, ideal_4};
    {ideal_6, ideal_7, ideal_8, ideal_9} <= {ideal_5, ideal_6, ideal_7, ideal_8};
    pixel_1 <= {pixel_value, pixel_y, pixel_x};
    {pixel_2, pixel_3, pixel_4} <= {pixel_1, pixel_2, pixel_3};
    {pixel_5, pixel_6, pixel_7, pixel_8} <= {pixel_4, pixel_5, pixel_6, pixel_7};
    if (clear && !busy) cleared <= 0;
    if (drained) cleared <= 1;
    if (reset || drained) begin
      cleared <= 1;
      {hit_1, hit_2, hit_3, hit_4, hit_5, hit_6, hit_7} <= 0;
      {won_1, won_2, won_3, won_4, won_5, won_6, won_7, won_8} <= 0;
      {ideal_1, ideal_2, ideal_3, ideal_4} <= {4{empty}};
      {ideal_5, ideal_6, ideal_7, ideal_8, ideal_9} <= {5{empty}};
    end
  end

  always @* begin
    // What is claimed: a pixel of this place is kept if and only if the ideal z-buffer keeps it.
    assert (won_8 == (kept_valid && \dut.address_8 == place));
    if (won_8) assert ({kept_value, kept_y, kept_x} == pixel_8 && kept_depth == ideal_8);
    if (drained) assert (!any && !kept_valid);
    if (!busy) assert (cleared);
    if (busy) assert (!pixel_ready);
    assert (idle == (!any && !busy));

    // Why it holds, stage by stage.
    assert (kept_valid == \dut.kept_8 );
    if (\dut.valid_1 ) assert (\dut.row_1 + \dut.pixel_1 [coord_bits - 1:0] < words);
    assert (hit_1 == (\dut.valid_1 && \dut.row_1 + \dut.pixel_1 [coord_bits - 1:0] == place));
    assert (hit_2 == (\dut.valid_2 && \dut.address_2 == place));
    assert (hit_3 == (\dut.valid_3 && \dut.address_3 == place));
    assert (hit_4 == (\dut.valid_4 && \dut.address_4 == place));
    assert (hit_5 == (\dut.valid_5 && \dut.address_5 == place));
    assert (hit_6 == (\dut.valid_6 && \dut.address_6 == place));
    assert (hit_7 == (\dut.valid_7 && \dut.address_7 == place));
    if (hit_1) assert (\dut.pixel_1 == pixel_1);
    if (hit_2) assert (\dut.pixel_2 == pixel_2);
    if (hit_3) assert (\dut.pixel_3 == pixel_3);
    if (hit_4) assert (\dut.pixel_4 == pixel_4);
    if (hit_5) assert (\dut.pixel_5 == pixel_5);
    if (hit_6) assert (\dut.pixel_6 == pixel_6);
    if (hit_7) assert (\dut.pixel_7 == pixel_7);
    assert (won_1 == (hit_1 && \dut.depth_1 < ideal_2) && ideal_1 == (won_1 ? \dut.depth_1 : ideal_2));
    assert (won_2 == (hit_2 && \dut.depth_2 < ideal_3) && ideal_2 == (won_2 ? \dut.depth_2 : ideal_3));
    assert (won_3 == (hit_3 && \dut.depth_3 < ideal_4) && ideal_3 == (won_3 ? \dut.depth_3 : ideal_4));
    assert (won_4 == (hit_4 && \dut.depth_4 < ideal_5) && ideal_4 == (won_4 ? \dut.depth_4 : ideal_5));
    assert (won_5 == (hit_5 && \dut.depth_5 < ideal_6) && ideal_5 == (won_5 ? \dut.depth_5 : ideal_6));
    assert (won_6 == (hit_6 && \dut.depth_6 < ideal_7) && ideal_6 == (won_6 ? \dut.depth_6 : ideal_7));
    assert (won_7 == (hit_7 && \dut.depth_7 < ideal_8) && ideal_7 == (won_7 ? \dut.depth_7 : ideal_8));
    assert (ideal_8 == (won_8 ? \dut.depth_8 : ideal_9));
    if (hit_3 && \dut.passed_3 ) assert (ideal_9 == \dut.passed_depth_3 );
    if (hit_3 && !\dut.passed_3 ) assert (asked_known && same(asked, ideal_9));
    if (hit_4 && \dut.passed_4 ) assert (ideal_9 == \dut.passed_depth_4 );
    if (hit_4 && !\dut.passed_4 ) assert (fetched_known && same(fetched, ideal_9));
    if (hit_5 && \dut.passed_5 ) assert (ideal_9 == \dut.passed_depth_5 );
    if (hit_5 && !\dut.passed_5 ) assert (banked_known && same(banked, ideal_9));
    if (hit_6 && \dut.passed_6 ) assert (ideal_9 == \dut.passed_depth_6 );
    if (hit_6 && !\dut.passed_6 ) assert (carried_known && same(carried, ideal_9));
    if (hit_7 && \dut.passed_7 ) assert (ideal_9 == \dut.passed_depth_7 );
    if (hit_7 && !\dut.passed_7 ) assert (read_known && same(read, ideal_9));
    if (hit_7) assert (\dut.same_7 == (\dut.address_8 == place));
    if (!\dut.filling ) assert (same(word, ideal_9));

    // The fill.
    assert (busy == (\dut.filling || \dut.clear_inst.draining ));
    assert (!(\dut.filling && \dut.clear_inst.draining ));
    assert (\dut.fill_address < words && (\dut.filling || \dut.fill_address == 0));
    if (\dut.filling ) assert (cleared && !any);
    if (\dut.filling && \dut.fill_address > place) assert (word[depth_bits]);
    if (busy && cleared) begin
      assert ({ideal_1, ideal_2, ideal_3, ideal_4} == {4{empty}});
      assert ({ideal_5, ideal_6, ideal_7, ideal_8, ideal_9} == {5{empty}});
    end
    if (\dut.clear_inst.draining ) assert (!cleared);
  end

endmodule
