// SPDX-License-Identifier: Apache-2.0
//
// crc32 against the division by x^32 + x^26 + ... + 1 with the highest power first (0x04C11DB7), bytes and
// result mirrored: the textbook's register, of which the RTL's is the mirror image.

module crc32_properties (
  input clk,
  input clear,
  input byte_valid,
  input [7:0] byte_data
);

  wire [31:0] crc;
  crc32 dut (
    .clk(clk), .clear(clear), .byte_valid(byte_valid), .byte_data(byte_data), .crc(crc)
  );

  reg [31:0] divided = 32'hffffffff;
  reg [31:0] next;
  integer index;
  always @* begin
    next = clear ? 32'hffffffff : divided;
    if (byte_valid)
      for (index = 0; index < 8; index = index + 1)
        next = {next[30:0], 1'b0} ^ (next[31] ^ byte_data[index] ? 32'h04c11db7 : 32'h0);
  end
  always @(posedge clk) divided <= next;

  integer place;
  always @* for (place = 0; place < 32; place = place + 1) assert (crc[place] == !divided[31 - place]);

endmodule
