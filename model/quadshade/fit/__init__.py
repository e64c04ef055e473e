# SPDX-License-Identifier: Apache-2.0
"""
Which quadratic a triangle gets: through six points, or the best one over the whole mesh.

The hardware draws any quadratic. ``elements`` says which sample values neighbours share, ``places`` where the
error is taken, ``solve`` finds the values for which it is least, and ``weighting`` lowers peaks. ``cosines``
fits what goes through a power. ``split`` and ``powell_sabin`` cut triangles so that ``c1`` has no Mach bands.
"""

from quadshade.fit.fits import Fitted, fit_colours, fit_scene
from quadshade.fit.places import PLACES

__all__ = ["PLACES", "Fitted", "fit_colours", "fit_scene"]
