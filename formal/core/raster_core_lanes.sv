// SPDX-License-Identifier: Apache-2.0
//
// raster_core: the lanes' copies of the handshake and their chains are always equal to those of the edge
// walker's and span walker's own lane, so that every channel's value meets its pixel; and those say what the
// units' state says.

module raster_core_lanes_properties `include "raster_core.svh"

  always @* begin
    assert (\dut.channel_gen_n1_lane_inst.handshake_inst.walked == walked);
    assert (\dut.channel_gen_n1_lane_inst.handshake_inst.wanted == wanted);
    assert (\dut.channel_gen_n1_lane_inst.handshake_inst.advancing == advance);
    assert (\dut.channel_gen_n1_lane_inst.handshake_inst.taking == (wanted && advance));
    assert (\dut.channel_gen_n1_lane_inst.handshake_inst.walking == walk);
    assert (\dut.channel_gen_n1_lane_inst.chain_inst.held == \dut.chain_inst.held );
    assert (\dut.channel_gen_n1_lane_inst.chain_inst.full == chain_full);
    assert (\dut.channel_gen_n2_lane_inst.handshake_inst.walked == walked);
    assert (\dut.channel_gen_n2_lane_inst.handshake_inst.wanted == wanted);
    assert (\dut.channel_gen_n2_lane_inst.handshake_inst.advancing == advance);
    assert (\dut.channel_gen_n2_lane_inst.handshake_inst.taking == (wanted && advance));
    assert (\dut.channel_gen_n2_lane_inst.handshake_inst.walking == walk);
    assert (\dut.channel_gen_n2_lane_inst.chain_inst.held == \dut.chain_inst.held );
    assert (\dut.channel_gen_n2_lane_inst.chain_inst.full == chain_full);
  end

endmodule
