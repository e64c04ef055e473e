// SPDX-License-Identifier: Apache-2.0
//
// raster_core: when a channel copies the words of a primitive, they are those that its packet brought, and
// zero where it brought none, at whatever pace beats come and scanlines go: the next packet's words, which
// follow close behind, never show. One word, chosen once and for all by whoever looks for a fault, is
// followed from the stream. A difference is one set-up word: word_width is 32 at most.

module raster_core_words_properties `include "raster_core.svh"

  localparam carried = num_channels + with_depth;
  localparam beat_words = stream_width / 32;
  localparam edge_bits = coord_bits + subpixel_bits + 2;
  localparam edge_words_bits = 2 * (2 * column_bits + 3 * edge_bits + 2);
  localparam edges = (3 + 2 * carried + coord_bits + 2 * column_bits + edge_words_bits + stream_width - 1)
    / stream_width;
  localparam seconds = (edge_words_bits / 2 + stream_width - 1) / stream_width;
  localparam groups = (carried + beat_words - 1) / beat_words;
  localparam differences = 6 * groups;
  localparam places = edges + seconds + differences;

  // The word.
  (* anyconst *) wire [$clog2(carried) - 1:0] channel;
  (* anyconst *) wire [2:0] difference;
  always @* assume (channel < carried && difference < 6);
  wire [$clog2(places) - 1:0] place = edges + seconds + channel / beat_words * 6 + difference;
  wire [word_width - 1:0] on_stream = setup_data >> channel % beat_words * 32;
  (* hierconn *) wire [carried * 6 * word_width - 1:0] \dut.words ;
  wire [word_width - 1:0] word = \dut.words >> (channel * 6 + difference) * word_width;

  // The loader: places of the next beat, and of the beat that is being written. First places stand highest.
  (* hierconn *) wire [places:0] \dut.loader_inst.state ;
  (* hierconn *) wire [edges - 1:0] \dut.loader_inst.edge_write ;
  (* hierconn *) wire [differences - 1:0] \dut.loader_inst.plane_write ;
  (* hierconn *) wire [stream_width - 1:0] \dut.loader_inst.beat ;
  (* hierconn *) wire \dut.packet_taken ;
  (* hierconn *) wire \dut.words_copy ;
  reg [places - 1:0] here;
  integer index;
  always @* begin
    for (index = 0; index < edges; index = index + 1)
      here[index] = \dut.loader_inst.state [edges - 1 - index];
    for (index = 0; index < seconds; index = index + 1)
      here[edges + index] = \dut.loader_inst.state [edges + seconds - 1 - index];
    for (index = 0; index < differences; index = index + 1)
      here[edges + seconds + index] = \dut.loader_inst.state [places - 1 - index];
  end
  wire accept = setup_valid && setup_ready;

  // What the packet that comes in says of the word, and what the packet said that was taken last.
  reg [word_width - 1:0] coming, taken;
  reg pending = 0;
  always @(posedge clk) begin
    if (accept && here[place]) coming <= on_stream;
    else if (accept && here[0]) coming <= 0;
    if (\dut.packet_taken ) taken <= coming;
    if (\dut.packet_taken ) pending <= 1;
    else if (\dut.words_copy ) pending <= 0;
    if (reset) pending <= 0;
  end

  // The claim.
  always @* if (pending && \dut.words_copy ) assert (word == taken);

  // What makes it so. The beat that is being written, and what the word will be after it.
  reg [places - 1:0] writing = 0;
  reg [stream_width - 1:0] written;
  always @(posedge clk) begin
    writing <= accept ? here : 0;
    written <= setup_data;
  end
  wire clears = \dut.loader_inst.edge_write [0];
  wire writes = \dut.loader_inst.plane_write >> places - 1 - place;
  wire [word_width - 1:0] on_beat = written >> channel % beat_words * 32;
  wire [word_width - 1:0] next_word = clears && difference != 0 ? 0 : writes ? on_beat : word;
  wire [places - 1:0] passed = {places{1'b1}} << place + 1;

  always @* begin
    assert (here != 0 && (here & here - 1'b1) == 0 && (writing & writing - 1'b1) == 0);
    assert (clears == writing[edges - 1] && writes == writing[place]);
    if (writing != 0) assert (\dut.loader_inst.beat == written);
    if (here >> edges - 1 != 0) assert (\dut.loader_inst.state [places]);
    if (\dut.loader_inst.full ) assert (here == 1 && next_word == coming);
    if (here > 1 && here >> edges == 0) assert (coming == 0);
    // Words are cleared with the last edge beat, and the first difference is always sent.
    if (here >> edges != 0 && (difference != 0 || (here & passed) != 0)) assert (next_word == coming);
    // From the take to the copy nothing touches the words.
    if (pending) begin
      assert (\dut.walker_inst.first_0 || \dut.words_copy );
      assert (!\dut.loader_inst.full && here >> edges == 0 && !clears && !writes && word == taken);
    end
  end

endmodule
