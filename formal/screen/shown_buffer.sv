// SPDX-License-Identifier: Apache-2.0
//
// framebuffer with two buffers, at one free place: between two swaps what the shown buffer holds there does
// not change, whatever is drawn, cleared or read, and neither in the clocks in which a swap shows it. Only a
// reset's fill is of both. Of block_ram, which is cut out, nothing is taken but that a write is done a clock
// later.

module shown_buffer_properties #(
  parameter width = 3,
  parameter height = 2,
  parameter coord_bits = 2,
  parameter value_bits = 8,
  parameter colour_bits = 8,
  parameter buffers = 2
) (
  input clk,
  input reset,
  input clear,
  input [value_bits - 1:0] clear_value,
  input swap,
  input pixel_valid,
  input [coord_bits - 1:0] pixel_x,
  input [coord_bits - 1:0] pixel_y,
  input [value_bits - 1:0] pixel_value,
  input read_enable,
  input [$clog2(width * height) - 1:0] read_address,
  input [$clog2(width * height) - 1:0] show_address
);

  localparam words = width * height;
  localparam address_bits = $clog2(words);
  localparam data_bits = value_bits * colour_bits / 8;

  wire busy, idle, pixel_ready;
  wire [value_bits - 1:0] read_value, show_value;

  framebuffer dut (
    .clk(clk), .reset(reset), .clear(clear), .clear_value(clear_value), .busy(busy), .idle(idle),
    .swap(swap), .pixel_valid(pixel_valid), .pixel_ready(pixel_ready), .pixel_x(pixel_x),
    .pixel_y(pixel_y), .pixel_value(pixel_value),
    .read_enable(read_enable), .read_address(read_address), .read_value(read_value),
    .show_address(show_address), .show_value(show_value)
  );

  // As screen does.
  always @* if (swap) assume (idle);

  (* hierconn *) wire \dut.valid_1 ;
  (* hierconn *) wire \dut.valid_2 ;
  (* hierconn *) wire \dut.filling ;
  (* hierconn *) wire \dut.clear_inst.draining ;
  (* hierconn *) wire [address_bits - 1:0] \dut.write_address ;
  (* hierconn *) wire [data_bits - 1:0] \dut.write_data ;
  (* hierconn *) wire \dut.double_gen_shown ;
  (* hierconn *) wire \dut.double_gen_fill_both ;
  (* hierconn *) wire \dut.double_gen_buffer_gen_n1_writes ;
  (* hierconn *) wire \dut.double_gen_buffer_gen_n2_writes ;

  (* anyconst *) wire [address_bits - 1:0] place;
  always @* assume (place < words);

  // What each buffer holds at this place, behind the register in which a write waits.
  reg [1:0] waits = 0;
  reg [data_bits - 1:0] data, word_0, word_1;
  always @(posedge clk) begin
    waits <= {\dut.double_gen_buffer_gen_n2_writes , \dut.double_gen_buffer_gen_n1_writes }
      & {2{\dut.write_address == place}};
    data <= \dut.write_data ;
    if (waits[0]) word_0 <= data;
    if (waits[1]) word_1 <= data;
  end

  // Since a reset's fill ended.
  reg known = 0;
  always @(posedge clk) known <= (known || !busy) && !reset;

  // The claim.
  wire [data_bits - 1:0] shown_word = \dut.double_gen_shown ? word_1 : word_0;
  reg [data_bits - 1:0] word_before;
  reg same = 0;
  always @(posedge clk) begin
    word_before <= shown_word;
    same <= known && !swap && !reset;
  end
  always @* if (same) assert (shown_word == word_before);

  // Why: nothing that is not a reset's fill is on its way to the buffer that is shown.
  always @* begin
    assert (!waits[\dut.double_gen_shown ] || \dut.double_gen_fill_both );
    assert (!(known && \dut.double_gen_fill_both ));
    if (\dut.double_gen_fill_both ) assert (!\dut.valid_1 && !\dut.valid_2 && !\dut.clear_inst.draining );
    assert (busy == (\dut.filling || \dut.clear_inst.draining ));
    assert (!(\dut.filling && \dut.clear_inst.draining ));
    if (\dut.filling ) assert (!\dut.valid_1 && !\dut.valid_2 );
  end

endmodule
