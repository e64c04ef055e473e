// SPDX-License-Identifier: Apache-2.0
//
// single_port_ram.vhd in iCE40UP5K's SPRAM, up to four of 16384 words of 16 bits: two words of eight bits
// side by side, the lower one at the even address. Synthesis puts it in the place of GHDL's module.

module single_port_ram #(
  parameter num_words = 131072,
  parameter address_bits = $clog2(num_words)
) (
  input clk,
  input write_enable,
  input [address_bits - 1:0] write_address,
  input [7:0] write_data,
  input read_enable,
  input [address_bits - 1:0] read_address,
  output reg [7:0] read_data
);

  localparam blocks = (num_words + 32767) / 32768;

  wire [16:0] address = write_enable ? write_address : read_address;

  // Of the word that is fetched.
  reg [1:0] block = 0;
  reg upper = 0;
  wire [15:0] fetched [0:3];

  genvar index;
  generate
    for (index = 0; index < 4; index = index + 1) begin : memory
      if (index < blocks) begin : built
        SB_SPRAM256KA ram (
          .CLOCK(clk),
          .ADDRESS(address[14:1]),
          .DATAIN({write_data, write_data}),
          .MASKWREN(address[0] ? 4'b1100 : 4'b0011),
          .WREN(write_enable),
          .CHIPSELECT((write_enable || read_enable) && address[16:15] == index),
          .STANDBY(1'b0),
          .SLEEP(1'b0),
          .POWEROFF(1'b1),
          .DATAOUT(fetched[index])
        );
      end else begin : absent
        assign fetched[index] = 16'b0;
      end
    end
  endgenerate

  always @(posedge clk) begin
    if (read_enable) begin
      block <= address[16:15];
      upper <= address[0];
      read_data <= upper ? fetched[block][15:8] : fetched[block][7:0];
    end
  end

endmodule
