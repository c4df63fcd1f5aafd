# SPDX-License-Identifier: BSD-3-Clause
"""Bounds on the domains of GIMP points, and a word when they act."""

from __future__ import annotations

from tilth.grid import Grid
from tilth.points import MaterialPoints

LEAST_HALF_LENGTH = 1e-3
"""Half lengths stay above this share of a cell; only a degenerate update comes so far."""

LARGEST_HALF_LENGTH = 0.5
"""Half lengths stay below this share of a cell, so that a point touches at most two per axis."""


def bound_domains(points: MaterialPoints, grid: Grid) -> dict[str, int]:
    """Clips half lengths to [1e-3, 0.5] cells; returns how many points each bound held.

    Keys: "floor" and "cap". Only bodies whose basis has a domain are looked at.
    """
    held = {"floor": 0, "cap": 0}
    round_off = 1e-12
    low = LEAST_HALF_LENGTH * grid.cell_size
    high = LARGEST_HALF_LENGTH * grid.cell_size
    for body in points.bodies:
        if body.domain_update is None:
            continue
        half = points.half_length[body.start : body.stop]
        held["floor"] += int((half < low).any(axis=1).sum())
        held["cap"] += int((half > high * (1.0 + round_off)).any(axis=1).sum())
        half.clip(low, high, out=half)
    return held
