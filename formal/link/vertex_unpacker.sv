// SPDX-License-Identifier: Apache-2.0
//
// vertex_unpacker: whatever the line says, a packet ends. `rank` bounds the clocks until then: it becomes
// smaller in every clock in which nothing outside makes the unit wait, and it never grows but by a start bit.
// What is asserted at each address of the program stands in a table that scripts/vertex_ranks.py makes when
// the proof runs, `rows`. All numbers are free but three words of the memory that addresses are counted with.

`include "vertex_unpacker_table.svh"

module vertex_unpacker_properties #(
  parameter num_channels = 3,
  parameter max_order = 2,
  parameter with_depth = 1,
  parameter word_width = 32,
  parameter frac_bits = 22,
  parameter depth_bits = 16,
  parameter subpixel_bits = 8,
  parameter coord_bits = 12
) (
  input clk,
  input reset,
  input line_valid,
  input [31:0] line_data,
  input packed_ready,
  input unpacking,
  input unpacked_valid,
  input [31:0] unpacked_data,
  input setup_ready
);

  wire line_ready, packed_valid, unpacked_ready, setup_valid, busy;
  wire [31:0] packed_data, setup_data;

  vertex_unpacker dut (
    .clk(clk), .reset(reset), .line_valid(line_valid), .line_ready(line_ready), .line_data(line_data),
    .packed_valid(packed_valid), .packed_ready(packed_ready), .packed_data(packed_data),
    .unpacking(unpacking), .unpacked_valid(unpacked_valid), .unpacked_ready(unpacked_ready),
    .unpacked_data(unpacked_data), .setup_valid(setup_valid), .setup_ready(setup_ready),
    .setup_data(setup_data), .busy(busy)
  );

  (* hierconn *) wire [30:0] \dut.code , \dut.code_next , \dut.code_read ;
  (* hierconn *) wire [2:0] \dut.step , \dut.index ;
  (* hierconn *) wire [9:0] \dut.pc , \dut.place , \dut.pointer , \dut.read_address ;
  (* hierconn *) wire [9:0] \dut.returns[0] , \dut.returns[1] ;
  (* hierconn *) wire [1:0] \dut.depth ;
  (* hierconn *) wire [5:0] \dut.left , \dut.leaving_bits ;
  (* hierconn *) wire [4:0] \dut.line_index , \dut.lane_bit ;
  (* hierconn *) wire [23:0] \dut.run ;
  (* hierconn *) wire [31:0] \dut.line_word ;
  (* hierconn *) wire \dut.no_step , \dut.last_step , \dut.by_four , \dut.known , \dut.computes ;
  (* hierconn *) wire \dut.shifts , \dut.reads , \dut.tells , \dut.counted , \dut.comes_late ;
  (* hierconn *) wire \dut.waits_first ;
  (* hierconn *) wire \dut.line_held , \dut.filling , \dut.runs , \dut.pads , \dut.full , \dut.passes ;
  (* hierconn *) wire \dut.memory_write , \dut.numbers.copies , \dut.numbers.sums ;
  (* hierconn *) wire [49:0] \dut.memory_data , \dut.read_data , \dut.numbers.number ;
  (* hierconn *) wire [51:0] \dut.numbers.sum , \dut.numbers.value ;

  wire [2:0] step = \dut.step ;
  wire [2:0] index = \dut.index ;
  wire [30:0] code = \dut.code ;
  wire [9:0] place = \dut.place ;
  wire [5:0] left = \dut.left ;
  wire held = \dut.line_held ;
  wire full = \dut.full ;
  wire pads = \dut.pads ;
  wire write = \dut.memory_write ;
  wire [49:0] data = \dut.memory_data ;
  localparam jumped = 1, fetching = 2, loading = 3, executing = 4;

  // The instruction's fields.
  wire quick = code[30];
  wire [4:0] operation = code[28:24];
  wire immediate = code[23];
  wire indexed = code[22];
  wire [15:0] operand = code[21:6];
  localparam do_st = 8, do_stq = 9, do_shl = 14, do_shr = 15, do_put = 16, do_get = 17, do_take = 18,
    do_ones = 19, do_start = 20, do_raw = 21, do_word = 22, do_align = 23, do_jz = 25, do_jnn = 28,
    do_ret = 30;

  // The table, and the address of the instruction that is executed, or comes next.
  reg [`ROW_BITS - 1:0] rows [0:1023];
  initial $readmemh("vertex_unpacker_table.hex", rows);
  wire [9:0] at = \dut.pc - (step > loading ? loading : step);
  wire [30:0] row_code;
  wire reached, by_t, leaves_may, pads_may;
  wire [2:0] owner, site, index_low, index_high, acc_kind, pointer_kind;
  wire [1:0] row_depth;
  wire [13:0] row_rank;
  wire [11:0] slope;
  wire [6:0] own;
  wire signed [17:0] acc_least;
  wire signed [10:0] pointer_least;
  wire [9:0] acc_more, pointer_more;
  wire [10:0] t_low, t_high, vertex_low, vertex_high, middle_low, middle_high;
  assign {row_code, reached, owner, site, row_depth, row_rank, slope, by_t, own, index_low, index_high,
    acc_kind, acc_least, acc_more, pointer_kind, pointer_least, pointer_more, t_low, t_high, vertex_low,
    vertex_high, middle_low, middle_high, leaves_may, pads_may} = rows[at];
  localparam code_low = `ROW_BITS - 31;
  wire [9:0] behind = at + 1;
  wire [9:0] second = at + 2;
  wire [30:0] code_behind = rows[behind] >> code_low;
  wire [30:0] code_second = rows[second] >> code_low;
  wire [2:0] owner_0, site_0, owner_1, site_1;
  wire [13:0] rank_0, rank_1;
  wire unused_0, unused_1;
  wire [1:0] depth_0, depth_1;
  assign {unused_0, owner_0, site_0, depth_0, rank_0} = rows[\dut.returns[0] ] >> (code_low - 23);
  assign {unused_1, owner_1, site_1, depth_1, rank_1} = rows[\dut.returns[1] ] >> (code_low - 23);

  // The memory is cut out: what was not written in the clock of its reading is what was written last.
  reg [49:0] cell_t = 0, cell_vertex = 0, cell_middle = 0;
  reg [9:0] read = 0;
  reg rewritten = 0, told = 0;
  always @(posedge clk) begin
    read <= \dut.read_address ;
    rewritten <= write && place == \dut.read_address ;
    if (write && place == `PLACE_T) cell_t <= data;
    if (write && place == `PLACE_VERTEX) cell_vertex <= data;
    if (write && place == `PLACE_MIDDLE) cell_middle <= data;
    told <= !reset && (told || (write && at == `TOLD_AT));
  end
  always @* if (!rewritten) begin
    if (read == `PLACE_T) assume (\dut.read_data == cell_t);
    if (read == `PLACE_VERTEX) assume (\dut.read_data == cell_vertex);
    if (read == `PLACE_MIDDLE) assume (\dut.read_data == cell_middle);
  end

  // Clocks to go: of what goes out, of what is read, of the instruction.
  wire [6:0] lane_end = \dut.lane_bit + \dut.leaving_bits ;
  wire [4:0] padding = -lane_end[4:0];
  wire [7:0] out = \dut.leaving_bits + full + lane_end[5] + 2 * lane_end[6]
    + (pads ? 1 + padding + (padding != 0) : 0);
  wire [6:0] line_end = \dut.line_index + left;
  wire [7:0] bits = left == 0 ? 1 : left + !held + (line_end > 32) + (line_end > 64);
  wire [7:0] shift = left < 4 ? (left == 0 ? 1 : left) : left[5:2] + left[1:0];
  reg [7:0] inner;
  always @* begin
    inner = left == 0 ? 1 : left;
    if (\dut.shifts ) inner = shift;
    if (\dut.reads ) inner = bits;
    if (operation == do_put || operation == do_word) inner = 1 + out;
    if (operation == do_align) inner = 1;
    if (operation == do_raw) inner = 1 + left + (\dut.line_index != 0) + full;
    inner = inner + !\dut.known ;
  end
  wire [13:0] to_go = row_rank - (by_t ? `ROUND * cell_t[9:3] : slope * index);
  wire [13:0] stacked = (\dut.depth > 0 ? rank_0 : 0) + (\dut.depth > 1 ? rank_1 : 0);
  wire starting = step == executing && operation == do_start;
  wire [13:0] rank = stacked + (step != executing ? to_go + (loading - step)
    : starting ? 0 : to_go - own + inner);

  // One clock later. `any`: since the unit was not busy something came that is not zero.
  wire passing = step == executing && operation == do_raw;
  reg started = 0, was_reset = 1, waited, any = 0, passed;
  reg [13:0] before;
  reg [23:0] run_before;
  always @(posedge clk) begin
    started <= 1;
    was_reset <= reset;
    waited <= (line_ready && (!line_valid || passing)) || packed_valid || (setup_valid && !setup_ready);
    before <= rank;
    passed <= \dut.passes && packed_ready;
    run_before <= \dut.run ;
    any <= !reset && ((any && busy) || (line_valid && line_ready && line_data != 0));
  end

  // Claims. No clock counts in which the unit waits for line or core, or gives word_unpacker a word.
  always @* begin
    assert (rank <= `BOUND);
    if (started && !was_reset && before != 0) begin
      assert (rank <= before);
      if (!waited) assert (rank < before);
    end
    if (rank == 0 && !held && !full) assert (!busy);
    // Of a run as many words pass as it says.
    if (\dut.passes ) assert (\dut.run != 0);
    if (started && !was_reset && passed) assert (\dut.run == run_before - 1);
    // Nothing comes of zeros.
    if (!any) assert (setup_valid == unpacked_valid && !packed_valid);
    // A write stays in the table that it belongs to: of named words, of vertices, of middles; or clears both.
    // Of pointers that no parameters have set nothing is claimed.
    if (write && !indexed) assert (place >= `SCRATCH);
    if (write && indexed) begin
      if (pointer_kind == 1) assert (place >= `SCRATCH);
      if (pointer_kind == 2) assert (place < `SCRATCH);
      if (pointer_kind == 3 && told) assert (place < `MIDDLES);
      if (pointer_kind == 4 && told) assert (place >= `MIDDLES && place < `SCRATCH);
      assert (pointer_kind != 0);
    end
  end

  wire jumps = operation >= do_jz && operation <= do_jnn;
  wire [9:0] asked = operand + (indexed ? \dut.pointer + index : 0);

  // What makes it inductive: the instructions are those of the program at its addresses.
  always @* begin
    assert (step <= executing && reached && \dut.depth == row_depth);
    if (step == jumped) assert (\dut.code_read == row_code);
    if (step == fetching) assert (\dut.code_next == row_code && \dut.code_read == code_behind);
    if (step >= loading)
      assert (code == row_code && \dut.code_next == code_behind && \dut.code_read == code_second);
    if (\dut.depth == 1) assert (site_0 == owner);
    if (\dut.depth == 2) assert (site_1 == owner && site_0 == owner_1);
    if (step >= loading) begin
      assert (\dut.computes == (operation < do_put || operation > do_ret));
      assert (\dut.shifts == (operation == do_shl || operation == do_shr));
      assert (\dut.reads == (operation == do_get || operation == do_take || operation == do_ones));
      assert (\dut.tells == (operation == do_ones));
      assert (\dut.counted == (operation >= do_shl && operation <= do_take));
      assert (\dut.comes_late == (\dut.counted && !immediate));
      assert (\dut.waits_first == (operation == do_raw));
    end
    if (step == loading) begin
      assert (read == place);
      assert (place == asked);
      if (!immediate && operation != do_st && operation != do_stq) assert (!rewritten);
      if (operation == do_st || jumps || operation == do_raw) assert (!\dut.numbers.sums );
      if (jumps || operation == do_raw) assert (!\dut.numbers.copies );
    end
    if (step == executing) begin
      assert (!quick);
      if (operation == do_put) assert (\dut.known && !\dut.by_four && left == operand[5:0]);
      else if (\dut.known ) begin
        assert (\dut.no_step == (left == 0));
        assert (\dut.last_step == (left <= 1 || (\dut.shifts && left == 4)));
        assert (\dut.by_four == (\dut.shifts && left >= 4));
      end else assert (\dut.comes_late && !\dut.by_four );
      if (operation != do_start) assert (inner < own);
    end
    assert (index >= index_low && index <= index_high);
    if (!held) assert (\dut.line_index == 0);
    assert (\dut.leaving_bits <= 32);
    if (\dut.leaving_bits != 0) assert (leaves_may);
    if (pads) assert (pads_may);
    if (!any) assert (at == 0 && !full && (!held || \dut.line_word == 0));
    if (\dut.filling ) assert (passing);
    if (passing && \dut.no_step && held) assert (\dut.runs == (\dut.run != 0));
  end

  // Numbers.
  wire [49:0] acc = \dut.numbers.copies ? \dut.numbers.number
    : \dut.numbers.sums ? \dut.numbers.sum [49:0] : \dut.numbers.value [49:0];
  reg [49:0] acc_base, pointer_base, acc_beyond;
  reg [9:0] pointer_beyond;
  always @* begin
    acc_base = acc_kind == 2 ? cell_t : acc_kind == 3 ? cell_vertex : acc_kind == 4 ? cell_middle : 0;
    pointer_base = pointer_kind == 2 ? cell_t : pointer_kind == 3 ? cell_vertex
      : pointer_kind == 4 ? cell_middle : 0;
    acc_beyond = acc - acc_base - {{32{acc_least[17]}}, acc_least};
    pointer_beyond = \dut.pointer - pointer_base[9:0] - pointer_least[9:0];
    if (step != executing && acc_kind != 0 && (acc_kind < 3 || told)) assert (acc_beyond <= acc_more);
    if (pointer_kind != 0 && (pointer_kind < 3 || told)) assert (pointer_beyond <= pointer_more);
    if (t_high != 2047) assert (cell_t >= t_low && cell_t <= t_high && cell_t[2:0] == 0);
    if (told && vertex_high != 2047)
      assert (cell_vertex >= vertex_low && cell_vertex <= vertex_high && cell_vertex[2:0] == 0);
    if (told && middle_high != 2047)
      assert (cell_middle >= middle_low && cell_middle <= middle_high && cell_middle[1:0] == 0);
  end

endmodule
