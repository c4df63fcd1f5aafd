# SPDX-License-Identifier: BSD-3-Clause
"""A footing pushed into sand without cohesion and dilation on few cells, which creeps."""

from __future__ import annotations

from tilth import Model
from tilth_verification.cases import varied
from tilth_verification.strip_footing_friction import sunk

GROUND, BASE, SIDE = 3.0, 1.4, 3.0
"""Places of the soil's sides [m]."""


def small_footing(steps: int, way: float = 0.2) -> Model:
    """A rough strip footing of 1 m pushed into sand of 37 degrees, cells of a fifth of it."""
    return varied(
        sunk(0.0, 37.0, 5, way),
        {
            "bodies.0.shape.lower": [0.0, BASE],
            "bodies.0.shape.upper": [SIDE, GROUND],
            "boundaries.1.at": SIDE,
            "boundaries.2.at": BASE,
            "loads.1.start": [SIDE, GROUND],
            "schedule.steps": steps,
        },
    )
