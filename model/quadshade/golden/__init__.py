# SPDX-License-Identifier: Apache-2.0
"""
The golden model: integers only, one module per RTL unit under the same name.

``raster_core.draw_scalar`` reads like the specification; ``compiled`` is the same in numba, a test holds them
equal; ``clocks`` steps the control registers of the RTL cycle by cycle.
"""

__all__ = ["board", "clocks", "common", "compiled", "core", "link", "screen", "shade"]
