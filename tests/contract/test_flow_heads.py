# SPDX-License-Identifier: BSD-3-Clause
"""Heads given on lines of the grid, on geometries and on surfaces: steady flow along a column."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from clay_columns import HEIGHT, UNDER_WATER, column, computed, pressures

WEIGHT = 10.0
STEADY = {"end": 1e6, "steps": 1}
RISE = 0.2
"""Head at the foot over the level at the top [m]."""

FOOT: dict[str, dict[str, Any]] = {
    "plane": {"type": "plane", "axis": "y", "at": 0.0},
    "implicit": {
        "type": "implicit",
        "geometry": {"type": "plane", "point": [0.0, 0.0], "normal": [0.0, 1.0]},
    },
    "surface": {"type": "surface", "body": "soil", "start": [0.0, 0.0], "end": [0.5, 0.0]},
}


@pytest.mark.parametrize("where", FOOT)
def test_a_head_above_the_level_drives_water_up(where: str) -> None:
    """The excess falls linearly from gamma_w times the rise to none, whatever the level is."""
    level = HEIGHT + 0.5
    foot = {"name": "foot", "condition": "head", "head": level + RISE, **FOOT[where]}
    top = {"name": "top", "type": "plane", "axis": "y", "at": HEIGHT, "condition": "head",
           "head": 2.0 * level, "factor": [[0, 0.5], [1e6, 0.5]]}  # fmt: skip
    changes = {**UNDER_WATER, "water": {"level": level, "unit_weight": WEIGHT},
               "loads": UNDER_WATER["loads"][:1], "flow.boundaries": [foot, top],
               "schedule": STEADY}  # fmt: skip
    analysis = computed(column(changes))
    height = analysis.state.points.position[:, 1]
    expected = WEIGHT * RISE * (1.0 - height / HEIGHT)
    np.testing.assert_allclose(pressures(analysis), expected, atol=0.01 * WEIGHT * RISE)
