// SPDX-License-Identifier: Apache-2.0
//
// The core and its control registers, by name, for the proofs of raster_core, with the invariants that they
// share. Built with two lanes, a colour and depth: further lanes are further instances with the same inputs.

#(
  parameter num_channels = 1,
  parameter max_order = 2,
  parameter with_depth = 1,
  parameter word_width = 12,
  parameter frac_bits = 2,
  parameter value_bits = 1,
  parameter depth_bits = 1,
  parameter subpixel_bits = 0,
  parameter coord_bits = 3,
  parameter stream_width = 32,
  parameter span_depth = 2
) (
  input clk,
  input reset,
  input setup_valid,
  input [stream_width - 1:0] setup_data,
  input pixel_ready
);

  localparam column_bits = coord_bits + 1;

  wire setup_ready, pixel_valid, pixel_last, idle;
  wire [coord_bits - 1:0] pixel_x, pixel_y;
  wire [num_channels * value_bits - 1:0] pixel_value;
  wire [depth_bits - 1:0] pixel_depth;

  raster_core dut (
    .clk(clk), .reset(reset),
    .setup_valid(setup_valid), .setup_ready(setup_ready), .setup_data(setup_data),
    .pixel_valid(pixel_valid), .pixel_ready(pixel_ready), .pixel_last(pixel_last),
    .pixel_x(pixel_x), .pixel_y(pixel_y), .pixel_value(pixel_value), .pixel_depth(pixel_depth), .idle(idle)
  );

  // Set-up loader: a packet waits; it waits or is begun.
  (* hierconn *) wire \dut.loader_inst.full ;
  (* hierconn *) wire \dut.loader_busy ;

  // Edge walker, stage by stage; bit 0 of `valids` is the last stage, bit 2 the fourth.
  (* hierconn *) wire \dut.walker_inst.valid_0 ;
  (* hierconn *) wire \dut.walker_inst.first_0 ;
  (* hierconn *) wire \dut.walker_inst.spacing ;
  (* hierconn *) wire \dut.walker_inst.second_pending ;
  (* hierconn *) wire signed [column_bits - 1:0] \dut.walker_inst.rows ;
  (* hierconn *) wire signed [column_bits - 1:0] \dut.walker_inst.rows_second ;
  (* hierconn *) wire \dut.walker_inst.valid_1 ;
  (* hierconn *) wire \dut.walker_inst.first_1 ;
  (* hierconn *) wire \dut.walker_inst.valid_2 ;
  (* hierconn *) wire \dut.walker_inst.valid_3 ;
  (* hierconn *) wire [2:0] \dut.walker_inst.valids ;

  // Span chain, bit 0 its last stage; span walker; output.
  (* hierconn *) wire [span_depth - 1:0] \dut.chain_inst.held ;
  (* hierconn *) wire \dut.chain_inst.full ;
  (* hierconn *) wire signed [column_bits - 1:0] \dut.span_inst.count ;
  (* hierconn *) wire \dut.span_inst.ending ;
  (* hierconn *) wire \dut.span_inst.valid ;
  (* hierconn *) wire \dut.clamped_valid ;
  (* hierconn *) wire \dut.skid_inst.ready ;
  (* hierconn *) wire \dut.skid_inst.front_valid ;

  // The handshake of the position's lane and of the two channels'.
  (* hierconn *) wire \dut.handshake_inst.walked ;
  (* hierconn *) wire \dut.handshake_inst.wanted ;
  (* hierconn *) wire \dut.handshake_inst.advancing ;
  (* hierconn *) wire \dut.handshake_inst.taking ;
  (* hierconn *) wire \dut.handshake_inst.walking ;
  (* hierconn *) wire \dut.channel_gen_n1_lane_inst.handshake_inst.walked ;
  (* hierconn *) wire \dut.channel_gen_n1_lane_inst.handshake_inst.wanted ;
  (* hierconn *) wire \dut.channel_gen_n1_lane_inst.handshake_inst.advancing ;
  (* hierconn *) wire \dut.channel_gen_n1_lane_inst.handshake_inst.taking ;
  (* hierconn *) wire \dut.channel_gen_n1_lane_inst.handshake_inst.walking ;
  (* hierconn *) wire [span_depth - 1:0] \dut.channel_gen_n1_lane_inst.chain_inst.held ;
  (* hierconn *) wire \dut.channel_gen_n1_lane_inst.chain_inst.full ;
  (* hierconn *) wire \dut.channel_gen_n2_lane_inst.handshake_inst.walked ;
  (* hierconn *) wire \dut.channel_gen_n2_lane_inst.handshake_inst.wanted ;
  (* hierconn *) wire \dut.channel_gen_n2_lane_inst.handshake_inst.advancing ;
  (* hierconn *) wire \dut.channel_gen_n2_lane_inst.handshake_inst.taking ;
  (* hierconn *) wire \dut.channel_gen_n2_lane_inst.handshake_inst.walking ;
  (* hierconn *) wire [span_depth - 1:0] \dut.channel_gen_n2_lane_inst.chain_inst.held ;
  (* hierconn *) wire \dut.channel_gen_n2_lane_inst.chain_inst.full ;

  // Where the units' own state says when things move.
  wire walked = \dut.walker_inst.valids [0];
  wire wanted = \dut.span_inst.count < 0;
  wire advance = \dut.skid_inst.ready ;
  wire chain_full = &\dut.chain_inst.held ;
  wire walk = !walked || !chain_full || wanted && advance;

  always @* begin
    // The copies agree with it.
    assert (\dut.handshake_inst.walked == walked && \dut.handshake_inst.wanted == wanted);
    assert (\dut.handshake_inst.advancing == advance && \dut.handshake_inst.taking == (wanted && advance));
    assert (\dut.handshake_inst.walking == walk);
    assert (\dut.chain_inst.full == chain_full);
    assert (\dut.span_inst.ending == (\dut.span_inst.count == 0));
    // A full skid buffer shows a pixel.
    if (!advance) assert (\dut.skid_inst.front_valid );
    // Stages 0 and 1: no scanline left where there is no primitive.
    if (\dut.walker_inst.first_0 ) assert (\dut.walker_inst.valid_0 );
    if (!\dut.walker_inst.valid_0 ) assert (\dut.walker_inst.rows < 0 && !\dut.walker_inst.second_pending );
    assert (\dut.walker_inst.spacing == (\dut.walker_inst.first_0 || \dut.walker_inst.first_1 ));
  end
