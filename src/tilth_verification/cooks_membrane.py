# SPDX-License-Identifier: BSD-3-Clause
"""Cook's membrane, nearly incompressible, sheared on its edge: finite elements of the same law."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.surface.tracked import TrackedSurface
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative, vanishing

PROBLEM = "cooks_membrane"
CORNER = (48.0, 60.0)
"""Upper right corner before loading [mm]."""
FULL, HALF = 6.93, 3.72
"""Rise of the corner under the full and half the load [mm].

Body-fitted quadratic elements of the same Hencky law: 6.767, 6.861 and 6.889 under the full load,
3.647, 3.700 and 3.717 under half of it, with 16, 32 and 48 elements a side; the limit of the full
load is extrapolated, within 0.02, the other is the last number.
"""
SOURCE = "FE, quadratic, extrapolated"
TOLERANCE = 0.02
LOAD = 100.0
"""Upward load on the right edge [N/mm]."""
FEW_STEPS = MappingProxyType({"schedule.steps": 6, "schedule.outputs": 1})
NO_CHANGES: Mapping[str, Any] = MappingProxyType({})


def comparisons(long: bool) -> Iterator[Comparison]:
    """The corner with F-bar on 16 and 32 cells a side; without it the membrane locks."""
    coarse = corner(3.0)
    fine = corner(1.5, NO_CHANGES if long else FEW_STEPS)
    yield from against_elements(coarse, 16)
    yield from against_elements(fine, 32)
    quantity = "reaction of the clamp plus the load over the load, 32 cells a side"
    yield vanishing(quantity, fine["clamp"] / LOAD + 1.0, 1e-8, "equilibrium")
    quantity = "distance of the corner from the limit, 16 over 32 cells a side"
    ratio = abs(FULL - coarse[1.0]) / abs(FULL - fine[1.0])
    yield at_least(quantity, ratio, 1.0, 0.0, "falls with the grid")
    locked = corner(3.0, {"bodies.0.anti_locking": "none"})
    quantity = "rise of the corner with F-bar over that without, 16 cells a side"
    yield at_least(quantity, coarse[1.0] / locked[1.0], 1.25, 0.0, "it locks")
    if long:
        yield from grids_and_points()


def grids_and_points() -> Iterator[Comparison]:
    """The corner on cells a quarter, a half and three quarters higher, and by other points."""
    for share in (0.25, 0.5, 0.75):
        rise = corner(1.5, {"grid.origin": [0.0, 1.5 * share]})[1.0]
        quantity = f"rise of the corner, 32 cells a side, grid {share:g} of a cell higher"
        yield relative(quantity, rise, FULL, TOLERANCE, SOURCE, "mm")
    rise = corner(1.5, {"bodies.0.points_per_cell": 4})[1.0]
    quantity = "rise of the corner, 32 cells a side, 4 x 4 points a cell"
    yield relative(quantity, rise, FULL, TOLERANCE, SOURCE, "mm")
    rise = corner(44.0 / 32.0)[1.0]
    quantity = "rise of the corner, 32 cells along the clamp, the loaded edge inside cells"
    yield relative(quantity, rise, FULL, TOLERANCE, SOURCE, "mm")
    locked = corner(1.5, {"bodies.0.anti_locking": "none"})[1.0]
    quantity = "rise of the corner over the limit without F-bar, 32 cells a side"
    yield at_least("1 - " + quantity, 1.0 - locked / FULL, 0.1, 0.0, "it locks")


def against_elements(rise: Mapping[Any, float], cells: int) -> Iterator[Comparison]:
    """Full and half load."""
    at = f"{cells} cells a side"
    yield relative(f"rise of the corner, {at}", rise[1.0], FULL, TOLERANCE, SOURCE, "mm")
    quantity = f"rise of the corner under half the load, {at}"
    yield relative(quantity, rise[0.5], HALF, TOLERANCE, "FE, quadratic, 48 a side", "mm")


def corner(cell_size: float, changes: Mapping[str, Any] = NO_CHANGES) -> dict[Any, float]:
    """Returns the corner's rise [mm] at each share of the load, and the force of the "clamp"."""
    model = varied(example(PROBLEM), {"grid.cell_size": cell_size, **changes})
    found: dict[Any, float] = {}

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        surface = simulation.state.surfaces["membrane"]
        assert isinstance(surface, TrackedSurface)
        chain = surface.chains[0]
        nearest = int(np.linalg.norm(chain.initial.points - CORNER, axis=1).argmin())
        found[round(time, 6)] = float(
            chain.current.points[nearest, 1] - chain.initial.points[nearest, 1]
        )
        found["clamp"] = float(result.resultant("clamp")[1])

    march(model, after_step)
    return found
