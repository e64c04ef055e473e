# SPDX-License-Identifier: Apache-2.0
"""A scene under one's own hand, in a browser: state, pictures, server and page."""

from quadshade.view.shown import Shown, Viewed
from quadshade.view.state import ViewState

__all__ = ["Shown", "ViewState", "Viewed"]
