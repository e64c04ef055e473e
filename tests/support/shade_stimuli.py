# SPDX-License-Identifier: Apache-2.0
"""What tests feed the shade unit with: states and values, whether or not a host would send them."""

from __future__ import annotations

import numpy as np

from quadshade.contract.formats import Formats
from quadshade.contract.shade_state import ShadeState, table_entries


def random_state(formats: Formats, rng: np.random.Generator) -> ShadeState:
    """Any registers and tables, whether or not a host would send them."""
    masks = rng.integers(0, 1 << formats.num_specular, 2)
    return ShadeState(
        rng.integers(0, 1 << (formats.value_bits + 16), 3),
        rng.integers(0, 1 << 18, (formats.num_channels, 3)) >> rng.integers(0, 10),
        rng.integers(0, 1 << 32, (formats.num_specular, table_entries(formats)), dtype=np.uint32),
        int(masks[0]),
        int(masks[1]),
        formats.shade_guard_bits,
    )


def random_values(formats: Formats, rng: np.random.Generator, count: int) -> np.ndarray:
    """Values of all sizes, zero and full scale among them."""
    bits = formats.lane_value_bits
    values = rng.integers(0, 1 << bits, (count, formats.num_channels)) >> rng.integers(
        0, bits, (count, formats.num_channels)
    )
    full = (1 << bits) - 1
    kind = rng.integers(0, 8, values.shape)
    return np.select([kind == 0, kind == 1, kind < 5], [0, full, full - values], values).clip(0)
