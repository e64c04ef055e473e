// SPDX-License-Identifier: Apache-2.0
//
// Writes the pixels of Amaranth's painter to painter.csv: columns of `quadshade words` but for the packet.

`timescale 1ns / 1ps

module painter_tb;
  reg clk = 0;
  reg rst = 1;
  integer cycle = 0, file;

  wire valid, idle;
  wire [64:0] pixel;
  // Ready in two of three clocks.
  wire ready = cycle % 3 != 2;

  painter painter_inst (
    .clk(clk), .rst(rst), .idle(idle),
    .pixels__valid(valid), .pixels__ready(ready), .pixels__payload(pixel)
  );

  always #5 clk = ~clk;

  initial begin
    file = $fopen("painter.csv", "w");
    $fwrite(file, "x,y,r,g,b,depth,last\n");
    #25 rst = 0;
  end

  always @(posedge clk) begin
    cycle <= cycle + 1;
    if (!rst && valid && ready)
      $fwrite(file, "%0d,%0d,%0d,%0d,%0d,%0d,%0d\n", pixel[11:0], pixel[23:12], pixel[31:24], pixel[39:32],
        pixel[47:40], pixel[63:48], pixel[64]);
    if (!rst && idle && cycle > 100) begin
      $fclose(file);
      $finish;
    end
  end
endmodule
