// SPDX-License-Identifier: Apache-2.0
//
// pixel_packer: whatever the bytes are, an answer ends. `rank` bounds the cycles until then: in every cycle
// in which the screen and the link do their part it becomes smaller, and it never grows but where a READ is
// taken. No byte takes more than 13 bits in all, so a length never overflows; it stands while bytes are sent,
// and is less than READ's count. A byte that is shown stays until it is taken, and none is shown unasked.

module pixel_packer_properties #(
  parameter value_bytes = 3,
  parameter depth_bytes = 2
) (
  input clk,
  input reset,
  input read_valid,
  input read_packed,
  input [15:0] read_count,
  input [1:0] read_plane,
  input data_ready,
  input area_ready,
  input byte_valid,
  input [7:0] byte_data
);

  wire read_ready, data_valid, area_valid, byte_ready;
  wire [9:0] answer_bytes;
  wire [7:0] data;

  pixel_packer dut (
    .clk(clk), .reset(reset), .read_valid(read_valid), .read_ready(read_ready), .read_packed(read_packed),
    .read_count(read_count), .read_plane(read_plane), .answer_bytes(answer_bytes), .data_valid(data_valid),
    .data_ready(data_ready), .data(data), .area_valid(area_valid), .area_ready(area_ready),
    .byte_valid(byte_valid), .byte_ready(byte_ready), .byte_data(byte_data)
  );

  (* hierconn *) wire [3:0] \dut.place ;
  (* hierconn *) wire \dut.sends , \dut.full , \dut.running , \dut.step_done , \dut.is_zero , \dut.emits ;
  (* hierconn *) wire \dut.asks , \dut.any_left ;
  (* hierconn *) wire [10:0] \dut.packed_bytes ;
  (* hierconn *) wire [9:0] \dut.left , \dut.run , \dut.step ;
  (* hierconn *) wire [3:0] \dut.word_left ;
  (* hierconn *) wire [2:0] \dut.bits ;
  (* hierconn *) wire [7:0] \dut.residual ;
  wire [3:0] place = \dut.place , word_left = \dut.word_left ;
  wire sends = \dut.sends , full = \dut.full , running = \dut.running , step_done = \dut.step_done ;
  wire is_zero = \dut.is_zero , emits = \dut.emits ;
  wire [10:0] packed_bytes = \dut.packed_bytes ;
  wire [9:0] left = \dut.left , run = \dut.run , step = \dut.step ;
  wire [2:0] bits = \dut.bits ;

  localparam rest = 0, fetch = 1, subtract = 2, judge = 3, code = 4, run_end = 5, flush = 6, ended = 7,
    again = 8;
  localparam code_bits = 13, most = 1023;

  // The longest answer of READ is shorter than that; a READ stands until it is taken.
  reg was_waiting = 0;
  reg [15:0] was_count;
  reg [1:0] was_plane;
  reg was_packed;
  always @(posedge clk) begin
    was_waiting <= read_valid && !read_ready && !reset;
    was_count <= read_count;
    was_plane <= read_plane;
    was_packed <= read_packed;
  end
  always @* begin
    assume (read_count >= 1 && read_count <= most);
    if (was_waiting)
      assume (read_valid && read_count == was_count && read_plane == was_plane && read_packed == was_packed);
  end

  // Of a reading: its bytes, and the bits that came of them.
  reg [9:0] count = 0;
  reg [14:0] given = 0;
  always @(posedge clk)
    if (place == rest || place == again) begin
      count <= read_count[9:0];
      given <= 0;
    end else if (emits) given <= given + 1;
  wire [9:0] fetched = count - left;
  wire signed [17:0] spare = code_bits * fetched - given;

  // Halvings of step until it is 1.
  reg [3:0] halvings;
  integer index;
  always @* begin
    halvings = 0;
    for (index = 0; index < 10; index = index + 1)
      if (step[index]) halvings = index;
  end
  wire one_step = step != 0 && (step & (step - 1)) == 0;

  // More cycles than a byte takes, and than come behind the last one.
  localparam byte_cycles = 40, end_cycles = 20, reading = byte_cycles * (most + 1);
  wire [16:0] behind = byte_cycles * left + end_cycles;
  reg [16:0] cycles;
  always @* begin
    cycles = 0;
    case (place)
      fetch: cycles = behind + (running && run != 0);
      subtract: cycles = behind + 38;
      judge: cycles = behind + (running ? 37 : 20);
      run_end: cycles = behind + 21 + halvings;
      code: cycles = behind + 2 + word_left;
      flush: cycles = 3 + ((8 - bits) & 7);
      ended: cycles = 2;
      default: ;
    endcase
  end
  wire [17:0] rank = place == rest ? 0 : 2 * (cycles + (sends ? 0 : reading)) + full;

  // Bits that the byte in work, and the end of its run, may still take; what fills the last byte is beyond.
  wire [17:0] for_run = running ? 12 + halvings + (run != 0 ? code_bits : 0) : 0;
  reg signed [17:0] needed;
  always @* begin
    needed = -100000;
    case (place)
      fetch: needed = for_run;
      subtract: needed = code_bits + for_run;
      judge: needed = code_bits + for_run;
      run_end: needed = 24 + halvings;
      code: needed = word_left + (running ? 12 : 0);
      flush: needed = bits == 0 ? -7 : 1 - bits;
      ended: needed = -7;
      default: ;
    endcase
  end

  // One cycle later.
  reg started = 0, was_reset = 1, was_resting = 1, served, held, sent = 0;
  reg [17:0] before;
  reg [7:0] shown;
  reg [10:0] announced;
  always @(posedge clk) begin
    started <= 1;
    was_reset <= reset;
    was_resting <= place == rest;
    served <= !(place == fetch && left != 0 && !byte_valid) && !(place == again && !area_ready)
      && !(full && sends && !data_ready);
    held <= place != rest && data_valid && !data_ready && !reset;
    before <= rank;
    shown <= data;
    sent <= sends && !reset;
    announced <= packed_bytes;
  end

  always @* begin
    if (started && !was_reset && !was_resting) begin
      assert (rank <= before);
      if (served) assert (rank < before);
    end
    if (place != rest) assert (code_bits * most + 7 >= 8 * packed_bytes);
    if (sends && place != rest) assert (answer_bytes == packed_bytes && packed_bytes < count);
    if (sent && sends) assert (packed_bytes == announced);
    if (started && held) assert (data_valid && data == shown);
    if (data_valid) assert (place == rest ? byte_valid : sends);
    if (byte_ready) assert (place == rest ? data_ready : place == fetch && left != 0);
    if (area_valid) assert (read_valid);
    if (read_ready) assert (area_ready && (place == rest || place == again));
    if (started && was_reset) assert (place == rest && !full);
  end

  // What makes it inductive.
  always @* begin
    assert (place <= again);
    assert (\dut.asks == (place == fetch && left != 0));
    if (place == judge || place == run_end || place == code) assert (\dut.any_left == (left != 0));
    if (place == again) assert (!sends);
    if (place == rest || place == again) assert (!full && bits == 0);
    if (place != rest && !sends) begin
      assert (read_valid && read_packed);
      assert (place == again || read_count == count);
    end
    if (place != rest && place != again) begin
      assert (left <= count);
      assert (count <= most && count != 0);
      if (!sends) assert (8 * packed_bytes + 8 * full + bits == given);
      else assert (bits == given[2:0]);
    end
    if (place == again) assert (8 * packed_bytes <= code_bits * read_count + 7);
    if (place == flush || place == ended) assert (left == 0);
    if (place == ended) assert (bits == 0 && !full);
    if (place == subtract || place == judge || place == run_end || place == code) assert (fetched != 0);
    if (place == judge) begin
      assert (is_zero == (\dut.residual == 0));
      assert (step_done == (run + 1 == step) || !running);
    end
    if (place == run_end) assert (!running && one_step && is_zero == (\dut.residual == 0));
    if (running && place != rest && place != again) begin
      assert (one_step && run < step);
      if (place == fetch || place == code) assert ({1'b0, step} + run <= fetched);
      if (place == subtract || place == judge) assert ({1'b0, step} + run < fetched);
    end
    assert (spare >= needed);
    if (place == code) begin
      assert (word_left != 0 && word_left <= code_bits);
      if (running) assert (step == 1 && run == 0 && word_left == 1);
    end
  end

endmodule
