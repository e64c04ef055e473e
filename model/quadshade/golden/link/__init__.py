# SPDX-License-Identifier: Apache-2.0
"""The board's end of the serial link: a module per unit of ``rtl/link``."""
