// SPDX-License-Identifier: Apache-2.0
//
// A Verilog bench around the core's netlist, raster_core.v, with its default generics: it sends words.hex and
// compares every pixel with words.pixels.csv, which `quadshade words triangles.json -o words.hex` writes.

`timescale 1ns / 1ps

module core_tb;
  parameter WORDS = 4096;

  reg clk = 0;
  reg reset = 1;
  reg [31:0] words [0:WORDS - 1];
  integer sent = 0, count = 0, cycle = 0, pixels, fields;
  integer packet, x, y, red, green, blue, depth, last;
  reg [8 * 80 - 1:0] head;

  wire setup_ready, pixel_valid, pixel_last, idle;
  wire [11:0] pixel_x, pixel_y;
  wire [23:0] pixel_value;
  wire [15:0] pixel_depth;
  wire setup_valid = !reset && ^words[sent] !== 1'bx && sent < WORDS;
  // Ready in two of three clocks.
  wire pixel_ready = cycle % 3 != 2;

  raster_core core (
    .clk(clk), .reset(reset),
    .setup_valid(setup_valid), .setup_ready(setup_ready), .setup_data(words[sent]),
    .pixel_valid(pixel_valid), .pixel_ready(pixel_ready), .pixel_last(pixel_last),
    .pixel_x(pixel_x), .pixel_y(pixel_y), .pixel_value(pixel_value), .pixel_depth(pixel_depth),
    .idle(idle)
  );

  always #5 clk = ~clk;

  initial begin
    $readmemh("words.hex", words);
    pixels = $fopen("words.pixels.csv", "r");
    fields = $fgets(head, pixels);
    #25 reset = 0;
  end

  always @(posedge clk) begin
    cycle <= cycle + 1;
    if (setup_valid && setup_ready) sent <= sent + 1;
    if (pixel_valid && pixel_ready) begin
      fields = $fscanf(
        pixels, "%d,%d,%d,%d,%d,%d,%d,%d\n", packet, x, y, red, green, blue, depth, last
      );
      if (fields != 8 || {pixel_x, pixel_y} !== {x[11:0], y[11:0]} || pixel_depth !== depth[15:0]
          || pixel_value !== {blue[7:0], green[7:0], red[7:0]} || pixel_last !== last[0]) begin
        $display("pixel %0d is wrong", count);
        $stop;
      end
      count <= count + 1;
    end
    if (!reset && idle && !setup_valid && cycle > 100) begin
      fields = $fscanf(pixels, "%d", packet);
      if (fields == 1) $display("pixels are missing after %0d", count);
      else $display("%0d pixels are equal", count);
      $finish;
    end
  end
endmodule
