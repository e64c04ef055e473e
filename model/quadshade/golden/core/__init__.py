# SPDX-License-Identifier: Apache-2.0
"""The rasteriser core, from set-up words to pixels: a module per unit of ``rtl/core``."""
