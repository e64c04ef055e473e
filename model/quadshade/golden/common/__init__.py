# SPDX-License-Identifier: Apache-2.0
"""Units that several stages use: memories, CRC, the skid buffer."""
