// SPDX-License-Identifier: Apache-2.0
//
// framebuffer against an ideal memory at one free place: what is written there is the last pixel accepted,
// or the colour of a clear after it. The memory is cut out: only what it is given is looked at.

module framebuffer_properties #(
  parameter width = 3,
  parameter height = 2,
  parameter coord_bits = 2,
  parameter value_bits = 2
) (
  input clk,
  input reset,
  input clear,
  input [value_bits - 1:0] clear_value,
  input pixel_valid,
  input [coord_bits - 1:0] pixel_x,
  input [coord_bits - 1:0] pixel_y,
  input [value_bits - 1:0] pixel_value,
  input read_enable,
  input [$clog2(width * height) - 1:0] read_address
);

  localparam words = width * height;
  localparam address_bits = $clog2(words);

  wire busy, pixel_ready;
  wire [value_bits - 1:0] read_value;

  framebuffer dut (
    .clk(clk), .reset(reset), .clear(clear), .clear_value(clear_value), .busy(busy),
    .pixel_valid(pixel_valid), .pixel_ready(pixel_ready), .pixel_x(pixel_x), .pixel_y(pixel_y),
    .pixel_value(pixel_value),
    .read_enable(read_enable), .read_address(read_address), .read_value(read_value)
  );

  (* hierconn *) wire \dut.valid_1 ;
  (* hierconn *) wire \dut.valid_2 ;
  (* hierconn *) wire \dut.write_enable ;
  (* hierconn *) wire \dut.filling ;
  (* hierconn *) wire \dut.clear_inst.draining ;
  (* hierconn *) wire [coord_bits - 1:0] \dut.x_1 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.row_1 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address_2 ;
  (* hierconn *) wire [address_bits - 1:0] \dut.fill_address ;
  (* hierconn *) wire [address_bits - 1:0] \dut.write_address ;
  (* hierconn *) wire [value_bits - 1:0] \dut.value_1 ;
  (* hierconn *) wire [value_bits - 1:0] \dut.value_2 ;
  (* hierconn *) wire [value_bits - 1:0] \dut.fill_value ;
  (* hierconn *) wire [value_bits - 1:0] \dut.write_data ;

  (* anyconst *) wire [coord_bits - 1:0] x, y;
  always @* assume (x < width && y < height);
  wire [address_bits - 1:0] place = y * width + x;

  // What stands at this place: in the memory, and ideally after the pixel of stage k and all ahead of it.
  reg [value_bits - 1:0] word, ideal, ideal_2, ideal_3, colour;
  reg hit_1 = 0, hit_2 = 0;
  wire hit = pixel_valid && pixel_ready && pixel_x == x && pixel_y == y;
  always @(posedge clk) begin
    if (\dut.write_enable && \dut.write_address == place) word <= \dut.write_data ;
    hit_1 <= hit;
    hit_2 <= hit_1;
    if (hit) ideal <= pixel_value;
    ideal_2 <= ideal;
    ideal_3 <= ideal_2;
    if ((clear && !busy) || reset) colour <= clear_value;
    if (reset) {hit_1, hit_2} <= 0;
    // A place has the colour once it was filled; the pixels ahead are written before that.
    if (\dut.filling ) {ideal, ideal_2, ideal_3} <= {3{\dut.fill_value }};
  end

  always @* begin
    assert (hit_1 == (\dut.valid_1 && \dut.row_1 + \dut.x_1 == place));
    if (\dut.valid_1 ) assert (\dut.row_1 + \dut.x_1 < words);
    assert (hit_2 == (\dut.valid_2 && \dut.address_2 == place));
    if (hit_1) assert (ideal == \dut.value_1 );
    if (hit_2) assert (ideal_2 == \dut.value_2 );

    // The fill: nothing is on its way, every address up to the last one, the colour of the request.
    assert (pixel_ready == !busy);
    assert (busy == (\dut.filling || \dut.clear_inst.draining ));
    assert (!(\dut.filling && \dut.clear_inst.draining ));
    if (\dut.filling ) assert (!\dut.valid_1 && !\dut.valid_2 );
    assert (\dut.fill_address < words && (\dut.filling || \dut.fill_address == 0));
    if (\dut.filling && \dut.fill_address > place) assert (word == \dut.fill_value );
  end

  // Nothing is known from power-up or reset to the end of the first fill.
  // The claim: what the memory holds is what was drawn, as soon as nothing for this place is on its way.
  reg known = 0;
  always @(posedge clk) begin
    known <= (known || (\dut.filling && \dut.fill_address == words - 1)) && !reset;
  end
  always @* begin
    if (!\dut.filling && !hit_1) assert (!known || ideal == ideal_2);
    if (known && !\dut.filling && !hit_2) assert (ideal_2 == ideal_3);
    if (known && !\dut.filling ) assert (word == ideal_3);
    if (!known) assert (\dut.filling );
  end

  // The colour is that of the clear, or of the reset.
  reg asked = 0;
  always @(posedge clk) asked <= reset || asked || (clear && !busy);
  always @* if (asked && busy) assert (\dut.fill_value == colour);

endmodule
