# SPDX-License-Identifier: BSD-3-Clause
"""Material points that have come apart from the soil."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags
from tilth.mpm.points import MaterialPoints

TORN_OFF = 1.5
"""Volume over that at first from which on soil has come apart: no soil dilates so much."""


def torn_off(points: MaterialPoints) -> Flags:
    """Returns which points are torn off at an edge of the soil, where they bear nothing, (n,)."""
    return np.asarray(points.volume > TORN_OFF * points.initial_volume)
