// SPDX-License-Identifier: Apache-2.0
//
// word_unpacker: whatever the words say, a packet ends. `rank` bounds the cycles until then: in every
// cycle in which a packed word is there and no set-up word waits for the core, it becomes smaller, and it
// never grows but by a start bit. Words of zeros give nothing; a set-up word stays until it is taken.

module word_unpacker_properties #(
  parameter num_channels = 1,
  parameter max_order = 2,
  parameter with_depth = 1,
  parameter word_width = 12,
  parameter subpixel_bits = 0,
  parameter coord_bits = 3,
  parameter with_shade = 0,
  parameter num_specular = 1
) (
  input clk,
  input reset,
  input packed_valid,
  input [31:0] packed_data,
  input setup_ready
);

  localparam carried = num_channels + with_depth;
  localparam num_orders = 2 * carried;
  localparam width = 4 + (word_width + 31) / 32;
  localparam address = 5 + with_shade;
  localparam change = width + address;

  wire packed_ready, setup_valid, busy;
  wire [31:0] setup_data;

  word_unpacker dut (
    .clk(clk), .reset(reset), .packed_valid(packed_valid), .packed_ready(packed_ready),
    .packed_data(packed_data), .setup_valid(setup_valid), .setup_ready(setup_ready),
    .setup_data(setup_data), .busy(busy)
  );

  // The state record, its first element lowest.
  localparam state_bits = 31 + 2 * width + change + address + num_orders;
  (* hierconn *) wire [state_bits - 1:0] \dut.state ;
  wire full, fill, in_words, same, has_second;
  wire [4:0] lane_bit, index;
  wire [width - 1:0] below, position;
  wire [3:0] group, step;
  wire [2:0] part;
  wire [num_orders - 1:0] orders;
  wire [address - 1:0] changes;
  wire [change - 1:0] changed;
  assign {full, lane_bit, fill, below, group, part, in_words, orders, same, has_second, changes, changed,
    position, index, step} = \dut.state ;

  localparam clearing = 0, waiting = 1, listing = 2, changing = 3, storing = 4, flagging = 5, asking = 6,
    ordering = 7, fetching = 8, reading = 9, running = 10, padding = 11;

  // Fields of the edges, then differences; more cycles than a field takes, with its padding.
  localparam edge_fields = 18;
  localparam fields = edge_fields + 6 * carried;
  localparam field_cycles = (1 << width) + 36;
  localparam packet_cycles = field_cycles * fields + num_orders + 6;
  localparam change_cycles = change + 3;
  localparam bound = packet_cycles + (1 << address) * change_cycles;

  // Edges are 0, 1, 3; behind one its section is padded, and part that of a first field.
  wire [1:0] edge_index = group == 3 ? 2 : group;
  wire [2:0] edge_part = step == padding ? 6 : part;
  wire [6:0] field = in_words ? edge_fields + 6 * group + part
    : part == 0 ? 0 : part == 1 ? 1 + group : edge_part + 1 + 5 * edge_index;
  wire [31:0] packet_left = field_cycles * (fields - field);
  wire [31:0] changes_left = packet_cycles + ((1 << address) - changes) * change_cycles;
  reg [31:0] left;
  always @* begin
    left = 0;
    case (step)
      clearing: left = (1 << address) - changed[address - 1:0];
      listing: left = changes_left;
      changing: left = changes_left - 1 - position;
      storing: left = changes_left - change - 2;
      flagging: left = packet_cycles - 1 - position;
      asking: left = packet_cycles - 4;
      ordering: left = packet_cycles - 5 - position;
      fetching: left = packet_left;
      reading: left = packet_left - 1;
      running: left = packet_left - 2 - position;
      padding: left = packet_left - 2 - (1 << width) - (lane_bit == 0 ? 32 : lane_bit);
    endcase
  end
  wire [31:0] rank = 2 * left + full;

  // One cycle later.
  reg started = 0, was_reset = 1, served, was_waiting, held, any = 0;
  reg [31:0] before, shown;
  always @(posedge clk) begin
    started <= 1;
    was_reset <= reset;
    served <= packed_valid && (!full || setup_ready);
    was_waiting <= step == waiting;
    held <= setup_valid && !setup_ready && !reset;
    before <= rank;
    shown <= setup_data;
    any <= !reset && (any || (packed_valid && packed_data != 0));
  end

  always @* begin
    assert (rank <= 2 * bound + 1);
    if (started && !was_reset && !was_waiting) begin
      assert (rank <= before);
      if (served) assert (rank < before);
    end
    if (rank == 0) assert (!busy);
    if (!busy) assert (!setup_valid);
    if (packed_ready) assert (packed_valid);
    if (started && held) assert (setup_valid && setup_data == shown);
    if (started && was_reset) assert (!setup_valid && !packed_ready);
    if (!any) assert (!setup_valid);
  end

  // A field's last bit, a channel's last difference.
  reg [6:0] last_bit;
  always @* begin
    case (part)
      0: last_bit = coord_bits - 1;
      3: last_bit = coord_bits + subpixel_bits + 2;
      5: last_bit = coord_bits + subpixel_bits + 1;
      6: last_bit = coord_bits + subpixel_bits + 2;
      default: last_bit = coord_bits;
    endcase
    if (in_words) last_bit = word_width - 1;
  end
  wire depth = with_depth && group == num_channels;
  wire [2:0] last_plane = orders[1] && max_order >= 2 && !depth ? 5
    : orders[1:0] != 0 && (max_order >= 1 || depth) ? 2 : 0;

  // What makes it inductive.
  always @* begin
    assert (step <= padding);
    if (!any) assert (step == clearing || step == waiting);
    case (step)
      changing: assert (position < change);
      flagging: assert (position < 3);
      ordering: assert (position < num_orders && !in_words && part == 0 && group == 0);
      running: assert (position <= last_bit);
      default: ;
    endcase
    if (step >= fetching) begin
      assert (part <= (in_words ? last_plane : 6));
      assert (in_words ? group < carried : group < (part < 1 ? 1 : 2) || (group == 3 && part >= 2));
      if (!in_words && group == 3) assert (has_second);
      if (!in_words && step == padding) assert (part == 2 && group > 0);
      if (step == fetching) assert (in_words);
    end
  end

endmodule
