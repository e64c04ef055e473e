// SPDX-License-Identifier: Apache-2.0
//
// raster_core: the rules of AXI4-Stream at the pixel port. A pixel that is shown stays, all of it, until it
// is taken; none is shown after reset. That no ready or valid depends on another port within the cycle is a
// matter of structure: the `cones` of proofs.toml.

module raster_core_ports_properties `include "raster_core.svh"

  localparam pixel_bits = 2 * coord_bits + num_channels * value_bits + depth_bits + 1;
  wire [pixel_bits - 1:0] pixel = {pixel_last, pixel_x, pixel_y, pixel_value, pixel_depth};

  reg held = 0, was_reset = 0;
  reg [pixel_bits - 1:0] held_pixel;
  always @(posedge clk) begin
    held <= pixel_valid && !pixel_ready && !reset;
    held_pixel <= pixel;
    was_reset <= reset;
  end

  always @* begin
    if (held) assert (pixel_valid && pixel == held_pixel);
    if (was_reset) assert (!pixel_valid && setup_ready && idle);
  end

endmodule
