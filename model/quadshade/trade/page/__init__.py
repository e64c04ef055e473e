# SPDX-License-Identifier: Apache-2.0
"""The page that shows what accuracy costs: static, from data that commands have written."""

from quadshade.trade.page.build import build_page

__all__ = ["build_page"]
