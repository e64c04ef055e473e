# SPDX-License-Identifier: Apache-2.0
"""The page that shows what accuracy costs: static, from data that commands have written."""

from quadshade.report.build import build_page

__all__ = ["build_page"]
