# SPDX-License-Identifier: Apache-2.0
"""What each step of accuracy costs: fraction, order, shading and subdivision swept over one scene."""

from quadshade.choices import COSTS
from quadshade.trade.grid import Grid, Point
from quadshade.trade.pareto import mark_pareto, pareto_front
from quadshade.trade.run_sweep import Sweep, sweep
from quadshade.trade.view import View

__all__ = ["COSTS", "Grid", "Point", "Sweep", "View", "mark_pareto", "pareto_front", "sweep"]
