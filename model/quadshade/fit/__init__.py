# SPDX-License-Identifier: Apache-2.0
"""
Which quadratic a triangle gets: through six points, or the best one over the whole mesh.

The hardware draws any quadratic. ``elements`` says which sample values neighbours share, ``places`` where the
error is taken, ``solve`` finds the values for which it is least.
"""

from quadshade.fit.fits import fit_colours
from quadshade.fit.places import PLACES

__all__ = ["PLACES", "fit_colours"]
