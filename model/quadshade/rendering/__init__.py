# SPDX-License-Identifier: Apache-2.0
"""Mesh to picture as a library: settings, shading, drawing."""
