// SPDX-License-Identifier: Apache-2.0
//
// setup_loader: whatever the words say, a packet ends. Exactly one of the places edge 0.., second 0.., plane
// 0.. is the next beat's; every accepted beat moves it on in that order, to the place that has_second and the
// orders name, or ends the packet, which waits, and refuses beats, until it is taken. So a packet has
// `places` beats at most. With with_last, setup_last amid a packet drops it: setup_cut says so once, no beat
// is taken meanwhile, and the next one is a packet's first; without, setup_last changes nothing.

module setup_loader_properties #(
  parameter num_channels = 1,
  parameter max_order = 2,
  parameter with_depth = 1,
  parameter word_width = 12,
  parameter stream_width = 32,
  parameter edge_section_bits = 68,
  parameter second_section_bits = 25,
  parameter orders_low = 3,
  parameter with_last = 0
) (
  input clk,
  input reset,
  input setup_valid,
  input [stream_width - 1:0] setup_data,
  input setup_last,
  input packet_taken,
  input words_pending
);

  localparam carried = num_channels + with_depth;
  localparam beat_words = stream_width / 32;
  localparam difference_words = (word_width + 31) / 32;
  localparam edges = (edge_section_bits + stream_width - 1) / stream_width;
  localparam seconds = (second_section_bits + stream_width - 1) / stream_width;
  localparam group_size = beat_words < difference_words ? 1 : beat_words / difference_words;
  localparam groups = (carried + group_size - 1) / group_size;
  localparam difference_beats = (difference_words + beat_words - 1) / beat_words;
  localparam differences = groups * 6 * difference_beats;
  localparam places = edges + seconds + differences;

  wire setup_ready, setup_cut, busy, packet_valid;
  wire [edge_section_bits - 1:0] edge_data;
  wire [second_section_bits - 1:0] second_data;
  wire [carried * 6 * word_width - 1:0] words;

  setup_loader dut (
    .clk(clk), .reset(reset),
    .setup_valid(setup_valid), .setup_ready(setup_ready), .setup_data(setup_data),
    .setup_last(setup_last), .setup_cut(setup_cut), .busy(busy),
    .packet_valid(packet_valid), .packet_taken(packet_taken), .words_pending(words_pending),
    .edge_data(edge_data), .second_data(second_data), .words(words)
  );

  // The state record: edge_at lowest, then second_at, plane_at, each with its first place highest,
  // writes_words.
  (* hierconn *) wire [places:0] \dut.state ;
  reg [places - 1:0] here;
  integer index;
  always @* begin
    for (index = 0; index < edges; index = index + 1)
      here[index] = \dut.state [edges - 1 - index];
    for (index = 0; index < seconds; index = index + 1)
      here[edges + index] = \dut.state [edges + seconds - 1 - index];
    for (index = 0; index < differences; index = index + 1)
      here[edges + seconds + index] = \dut.state [places - 1 - index];
  end

  wire accept = setup_valid && setup_ready;

  // A packet is taken when it is there.
  always @* if (packet_taken) assume (packet_valid);

  // What the packet's first beat said, and its length in beats, which follows from that alone.
  reg has_second;
  reg [2 * carried - 1:0] orders;
  wire has_second_now = here[0] ? setup_data[0] : has_second;
  wire [2 * carried - 1:0] orders_now = here[0] ? setup_data >> orders_low : orders;
  always @(posedge clk) if (accept) {has_second, orders} <= {has_second_now, orders_now};

  // The highest order of a group's channels, as far as they are built for it: 0, 1, or 2 (3 is 2).
  function [1:0] order_of(input [2 * carried - 1:0] all_orders, input integer group);
    integer channel;
    integer order, built, wanted;
    begin
      order = 0;
      built = 0;
      for (channel = 0; channel < carried; channel = channel + 1) if (channel / group_size == group) begin
        wanted = all_orders >> 2 * channel & 3;
        if (wanted > order) order = wanted;
        if ((channel < num_channels ? max_order : 1) > built) built = channel < num_channels ? max_order : 1;
      end
      order_of = order > built ? built : order > 2 ? 2 : order;
    end
  endfunction

  // Beats of a group: 1, 3 or 6 differences.
  function integer beats_of(input [1:0] order);
    beats_of = difference_beats * (order == 0 ? 1 : order == 1 ? 3 : 6);
  endfunction

  // The place that follows each place; `places` stands for the packet's end.
  integer group, offset, after;
  reg [places:0] next_places;
  always @* begin
    next_places = 0;
    for (index = 0; index < places; index = index + 1) begin
      group = (index - edges - seconds) / (6 * difference_beats);
      offset = (index - edges - seconds) % (6 * difference_beats);
      after = index + 1;
      if (index == edges - 1 && !has_second_now) after = edges + seconds;
      if (index >= edges + seconds && offset + 1 == beats_of(order_of(orders_now, group)))
        after = edges + seconds + (group + 1) * 6 * difference_beats;
      if (here[index]) next_places = next_places | 1 << after;
      // Only places that the first beat named are reached.
      if (here[index] && index >= edges && index < edges + seconds) assert (has_second);
      if (here[index] && index >= edges + seconds) assert (offset < beats_of(order_of(orders, group)));
    end
  end

  // One cycle later.
  reg advanced = 0, stayed = 0, was_reset = 0, was_taken = 0, was_full, was_last, was_cut;
  reg [places:0] expected;
  reg [places - 1:0] stays;
  always @(posedge clk) begin
    advanced <= accept && !reset;
    stayed <= !accept && !reset;
    was_reset <= reset;
    was_taken <= packet_taken;
    was_full <= packet_valid;
    was_last <= setup_last && with_last == 1;
    was_cut <= setup_cut;
    expected <= next_places;
    stays <= here;
  end

  always @* begin
    // One place, always.
    assert (here != 0 && (here & here - 1'b1) == 0);
    // Each beat goes on to a later place, or ends the packet.
    if (advanced) begin
      assert (packet_valid == expected[places]);
      assert (here == (expected[places] ? 1 : expected[places - 1:0]));
      assert (packet_valid || here > stays);
    end
    // The sender's last beat amid a packet, and only that, cuts it; a cycle later nothing is left of it.
    if (advanced) assert (setup_cut == (was_last && !packet_valid));
    if (stayed) assert (!setup_cut);
    if (setup_cut) assert (!setup_ready && here != 1);
    // Else nothing moves without a beat, and a waiting packet stays until it is taken.
    if (stayed) assert (here == (was_cut ? 1 : stays) && packet_valid == (was_full && !was_taken));
    if (packet_valid) assert (!setup_ready && here == 1);
    if (!packet_valid && !setup_cut && !words_pending) assert (setup_ready);
    assert (busy == (packet_valid || here != 1));
    if (was_reset) assert (!busy && !setup_cut && here == 1);
  end

  (* hierconn *) wire \dut.has_second ;
  (* hierconn *) wire [2 * carried - 1:0] \dut.orders ;
  always @* if (here > 1) assert (\dut.has_second == has_second && \dut.orders == orders);

endmodule
