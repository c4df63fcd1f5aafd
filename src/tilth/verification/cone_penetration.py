# SPDX-License-Identifier: BSD-3-Clause
"""A cone pressed into clay: from its surface in axisymmetry and in 3D, and deep with its shaft."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.verification.cases import example, varied
from tilth.verification.closed_forms.limit_loads import cone_factor
from tilth.verification.comparison import Comparison, relative, vanishing
from tilth.verification.curves import Curve, largest_difference, reaction_curve

PROBLEM = "cone_penetration"
START = 0.25
"""Depth of the tip from which on curves are compared [m]: half of the displacement."""
INCREMENTS = 50
"""Number of increments of the whole displacement, for the roughness."""
DIAMETER, STRENGTH, RIGIDITY = 1.0, 10e3, 100.0
"""Of the deep cone [m]; s_u of its clay by Tresca's law, half of the strength in compression [Pa];
G / s_u [-]."""
STEP = 0.02
"""How far a step pushes it [m]."""
DEEP = 3.0
"""How far it has been pushed from the bottom of its hole where its force is compared [m]."""
TRAVEL = 4.0
"""How far the case file pushes it [m]."""
WINDOW = 0.1
"""Length of the way over which its force is averaged [m]: where a material point comes into
contact the force of a single step differs by up to 2 %."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Both curves to the end, and how smooth they are; in 3D and deep only if long."""
    ring = reaction_curve(example(PROBLEM))
    quantity = "RMS of the second difference of the force over its mean"
    source = "a smooth curve"
    rough = ring.roughness(INCREMENTS, START)
    yield vanishing(f"{quantity}, axisymmetric", rough, 0.015, source)
    if long:
        model = example(PROBLEM, "three_dimensional.toml")
        quarter = reaction_curve(model)
        rough = quarter.roughness(INCREMENTS, START)
        yield vanishing(f"{quantity}, 3D", rough, 0.015, source)
        same_cells = {"grid.cell_size": model.cell_size[0]}
        ring = reaction_curve(varied(example(PROBLEM), same_cells))
        displacement, computed, exact = largest_difference(quarter, ring, START)
        quantity = f"force at {displacement:.3g} m, the farthest apart, 3D and axisymmetric"
        yield relative(quantity, computed, exact, 0.1, "axisymmetry", "N")
        yield from deep()  # 10 to 25 minutes on one core


def deep() -> Iterator[Comparison]:
    """The cone factor below its hole: at three diameters on two grids, and steady at four."""
    source = "Lu et al. 2004, from memory"
    curve = penetrate(6, TRAVEL)
    coarse, steady = cone_resistance(curve, DEEP), cone_resistance(curve, TRAVEL)
    fine = cone_resistance(penetrate(8, DEEP), DEEP)
    exact = cone_factor(RIGIDITY)
    yield relative("N_kt, Ir 100, h D/8", fine, exact, 0.12, source)
    yield relative("N_kt at the end, Ir 100, h D/6", steady, exact, 0.12, source)
    yield relative("N_kt, Ir 100, h D/6", coarse, fine, 0.05, "h D/8")
    change = steady / cone_resistance(curve, TRAVEL - DIAMETER) - 1.0
    quantity = "change of N_kt over the fourth diameter, Ir 100, h D/6"
    yield vanishing(quantity, change, 0.03, "steady")


def penetrate(cells: int, travel: float) -> Curve:
    """Returns N_kt = q / s_u against the depth.

    cells: of the grid, to the diameter. travel: depth below the hole at the end [m].
    """
    changes = {
        "grid.cell_size": DIAMETER / cells,
        "boundaries.2.displacement": {"y": -travel},
        "schedule.steps": round(travel / STEP),
    }
    curve = reaction_curve(varied(example(PROBLEM, "contact.toml"), changes))
    area = 0.25 * math.pi * DIAMETER**2
    return Curve(curve.displacement, curve.force / (area * STRENGTH))


def cone_resistance(curve: Curve, depth: float) -> float:
    """Returns the mean of a curve over the last tenth of a metre to a depth [m]."""
    return float(curve.at(np.linspace(depth - WINDOW, depth, 11)).mean())
