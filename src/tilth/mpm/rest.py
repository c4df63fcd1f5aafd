# SPDX-License-Identifier: BSD-3-Clause
"""How far a step's motion says whether soil flows.

The elastic share of a point's last strain says what moduli and tractions follow from it. In soil at
rest it is that of a strain next to nothing, and may be another one in each step: what would follow
it changes forces in steps in which nothing changes, and so moves the soil.
"""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats

REST_MOTION = 1e-3
"""Motion in a step [cells] up to which soil is at rest."""


def followed(motion: Floats) -> Floats:
    """Returns how far the elastic share of a step with this motion [cells] is followed [-]."""
    return np.asarray(-np.expm1(-motion / REST_MOTION))
