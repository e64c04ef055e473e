# SPDX-License-Identifier: Apache-2.0
"""Packets in few bytes, the file that holds a frame of them, and its dump."""

from quadshade.packing.frame_dump import packet_lines, summary_lines
from quadshade.packing.frame_file import (
    FrameFile,
    decode_frame_file,
    encode_frame_file,
    pack_frame,
    read_frame_file,
)
from quadshade.packing.pack import Packed, pack_primitives, unpack

__all__ = [
    "FrameFile",
    "Packed",
    "decode_frame_file",
    "encode_frame_file",
    "pack_frame",
    "pack_primitives",
    "packet_lines",
    "read_frame_file",
    "summary_lines",
    "unpack",
]
