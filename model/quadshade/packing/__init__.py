# SPDX-License-Identifier: Apache-2.0
"""Packets in few bytes, the file that holds a frame of them, and its dump."""
