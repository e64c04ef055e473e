# SPDX-License-Identifier: Apache-2.0
"""The shade unit and the core with it: a module per unit of ``rtl/shade``."""
