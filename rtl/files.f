# SPDX-License-Identifier: Apache-2.0
# All RTL, bottom-up; every tool reads this list.
rtl/quadshade_pkg.vhd
rtl/link_pkg.vhd
rtl/screen_pkg.vhd
rtl/block_ram.vhd
rtl/crc32.vhd
rtl/uart_rx.vhd
rtl/uart_tx.vhd
rtl/cobs_decoder.vhd
rtl/cobs_encoder.vhd
rtl/skid_buffer.vhd
rtl/setup_loader.vhd
rtl/edge_dda.vhd
rtl/edge_walker.vhd
rtl/scanline_channel.vhd
rtl/span_chain.vhd
rtl/span_walker.vhd
rtl/pixel_channel.vhd
rtl/output_clamp.vhd
rtl/lane_handshake.vhd
rtl/channel_lane.vhd
rtl/raster_core.vhd
rtl/memory_clear.vhd
rtl/depth_test.vhd
rtl/framebuffer.vhd
rtl/read_out.vhd
