# SPDX-License-Identifier: Apache-2.0
"""Triangles and shade state on disk."""
