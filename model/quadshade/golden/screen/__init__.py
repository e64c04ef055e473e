# SPDX-License-Identifier: Apache-2.0
"""What stands behind the pixel stream: a module per unit of ``rtl/screen``."""
