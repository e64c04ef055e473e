// SPDX-License-Identifier: Apache-2.0
//
// read_out against an ideal walk of the area by column and row: every address is that of the area's next
// pixel, on the screen, and the pixels are as many as asked for, or end with the screen's last scanline.

module read_out_properties #(
  parameter width = 3,
  parameter height = 2,
  parameter coord_bits = 2,
  parameter num_channels = 1,
  parameter read_stages = 3
) (
  input clk,
  input reset,
  input area_valid,
  input [coord_bits - 1:0] area_x,
  input [coord_bits - 1:0] area_y,
  input [coord_bits:0] area_width,
  input [$clog2(width * height):0] area_count,
  input [8 * num_channels - 1:0] read_value,
  input pixel_ready
);

  localparam address_bits = $clog2(width * height);

  wire area_ready, refused, read_enable, pixel_valid, pixel_last;
  wire [address_bits - 1:0] read_address;
  wire [8 * num_channels - 1:0] pixel_value;
  wire [31:0] crc;

  read_out dut (
    .clk(clk), .reset(reset), .area_valid(area_valid), .area_ready(area_ready), .area_x(area_x),
    .area_y(area_y), .area_width(area_width), .area_count(area_count), .refused(refused),
    .read_enable(read_enable), .read_address(read_address), .read_value(read_value),
    .pixel_valid(pixel_valid), .pixel_ready(pixel_ready), .pixel_last(pixel_last),
    .pixel_value(pixel_value), .crc(crc)
  );

  (* hierconn *) wire \dut.starting ;
  (* hierconn *) wire \dut.running ;
  (* hierconn *) wire \dut.advance ;
  (* hierconn *) wire [read_stages - 1:0] \dut.valids ;
  (* hierconn *) wire \dut.last_1 ;
  (* hierconn *) wire [read_stages - 1:0] \dut.lasts ;
  (* hierconn *) wire [address_bits - 1:0] \dut.row ;
  (* hierconn *) wire [address_bits - 1:0] \dut.below ;
  (* hierconn *) wire [address_bits - 1:0] \dut.address ;
  (* hierconn *) wire [coord_bits - 1:0] \dut.x ;
  (* hierconn *) wire [coord_bits:0] \dut.columns ;
  (* hierconn *) wire [coord_bits:0] \dut.columns_left ;
  (* hierconn *) wire [coord_bits - 1:0] \dut.rows_left ;
  (* hierconn *) wire [address_bits:0] \dut.count_left ;
  (* hierconn *) wire [8 * num_channels:0] \dut.emitted ;

  // The area, and the pixel of it that is read next.
  reg [coord_bits:0] x, across, column, row;
  reg [address_bits + 1:0] count, index;
  reg active = 0;
  wire accept = area_valid && area_ready;
  wire fits = area_width != 0 && area_count != 0 && area_x + area_width <= width && area_y < height;
  wire step = \dut.running && \dut.advance ;
  wire line_end = column == x + across - 1;
  wire last = index == count - 1 || (line_end && row == height - 1);
  always @(posedge clk) begin
    if (accept) begin
      {x, across, count} <= {1'b0, area_x, area_width, 1'b0, area_count};
      {column, row, index} <= {1'b0, area_x, 1'b0, area_y, {(address_bits + 2){1'b0}}};
      active <= fits;
    end else if (step) begin
      active <= !last;
      index <= index + 1;
      column <= line_end ? x : column + 1;
      row <= row + line_end;
    end
    if (reset) active <= 0;
  end

  wire idle = !active && \dut.valids == 0 && !pixel_valid;
  integer stage;
  // Below the scanline's first pixel; wrong below the screen, where nothing reads it.
  wire [address_bits - 1:0] below = (row + 1) * width + x;
  always @* begin
    // An area is walked from its acceptance to its last pixel, by addresses that are on the screen.
    assert (active == (\dut.starting || \dut.running ));
    assert (!(\dut.starting && \dut.running ));
    assert (area_ready == idle);
    assert (read_enable == \dut.advance && read_address == \dut.address );
    assert (\dut.address < width * height);
    if (active) begin
      assert (x < width && across != 0 && x + across <= width && row < height && index < count);
      assert (column >= x && column < x + across && count <= (2 << address_bits));
      assert (\dut.columns == across - 1 && \dut.rows_left == height - 1 - row);
      assert (\dut.count_left == count - 1 - index);
    end
    if (\dut.starting ) assert (\dut.row == row * width && \dut.x == x && column == x && index == 0);
    if (\dut.running ) begin
      assert (\dut.address == row * width + column && \dut.below == below);
      assert (\dut.columns_left == x + across - 1 - column);
      assert (\dut.last_1 == last);
    end
    // One last pixel, the one in front of which all others are.
    for (stage = 0; stage < read_stages; stage = stage + 1) begin
      if (\dut.valids [stage] && \dut.lasts [stage]) assert (!active && \dut.valids >> (stage + 1) == 0);
      if (!active && \dut.valids [stage] && \dut.valids >> (stage + 1) == 0) assert (\dut.lasts [stage]);
    end
  end

  // read_stages enabled cycles from an address to its value; a value that waits is the memory's, unchanged.
  reg [read_stages - 1:0] stepped = 0;
  always @(posedge clk) begin
    if (\dut.advance ) stepped <= {\dut.running , stepped} >> 1;
    if (reset) stepped <= 0;
  end
  always @* assert (\dut.valids == stepped);
  always @* assert (\dut.emitted == {\dut.lasts [0], read_value});

  // AXI4-Stream: a shown pixel stays until it is taken.
  reg held = 0, refuses = 0;
  reg [8 * num_channels:0] held_pixel;
  always @(posedge clk) begin
    held <= pixel_valid && !pixel_ready && !reset;
    held_pixel <= {pixel_last, pixel_value};
    refuses <= accept && !fits && !reset;
  end
  always @* begin
    if (held) assert (pixel_valid && {pixel_last, pixel_value} == held_pixel);
    assert (refused == refuses);
  end

endmodule
