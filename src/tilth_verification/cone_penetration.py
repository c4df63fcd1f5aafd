# SPDX-License-Identifier: BSD-3-Clause
"""A cone pressed into clay: from its surface in axisymmetry and in 3D, and deep with its shaft."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.model import Model, Polygon
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.limit_loads import cone_factor
from tilth_verification.comparison import Comparison, absolute, relative, vanishing
from tilth_verification.curves import Curve, largest_difference, reaction_curve

PROBLEM = "cone_penetration"
START = 0.25
"""Depth of the tip from which on curves are compared [m]: half of the displacement."""
INCREMENTS = 50
"""Number of increments of the whole displacement, for the roughness."""
DIAMETER, STRENGTH, POISSON = 1.0, 10e3, 0.49
"""Of the deep cone [m]; s_u of its clay by Tresca's law, half of the strength in compression [Pa];
Poisson's ratio of the clay [-]."""
SOFT, STIFF = 100.0, 300.0
"""G / s_u of the case file and of a second clay [-]."""
WIDE = 10.0
"""Outer radius of the second clay, whose plastic zone is larger [m]; that of the case file is 8."""
STEP, STEP_FINE = 0.025, 0.02
"""How far a step pushes it [m], on cells of a sixth and an eighth of the diameter."""
TRAVEL, SHORTER, FARTHER = 3.0, 2.0, 4.0
"""How far it is pushed from the bottom of its hole where both clays are compared, how far on the
finer grid, and how far until its resistance is steady [m]."""
WINDOW = 0.25
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
        yield from deep()  # about 15 minutes on one core


def deep() -> Iterator[Comparison]:
    """The cone factor far below the surface: its size, steadiness and grid; in stiffer clay."""
    source = "Lu et al. 2004, from memory"
    curves = {}
    for rigidity, model in ((SOFT, example(PROBLEM, "contact.toml")), (STIFF, stiff_clay())):
        curve = penetrate(model, 6, FARTHER)
        curves[rigidity] = curve
        here, end = cone_resistance(curve, TRAVEL), cone_resistance(curve, FARTHER)
        what, exact = f"Ir {rigidity:g}, h D/6", cone_factor(rigidity)
        yield relative(f"N_kt at three diameters, {what}", here, exact, 0.12, source)
        yield relative(f"N_kt at four diameters, {what}", end, exact, 0.12, source)
        quantity = f"change of N_kt over the fourth diameter, {what}"
        yield vanishing(quantity, end / here - 1.0, 0.03, "steady")
    quantity = "N_kt of Ir 300 less that of Ir 100 at three diameters, h D/6"
    soft, stiff = (cone_resistance(curves[each], TRAVEL) for each in (SOFT, STIFF))
    yield absolute(quantity, stiff - soft, 1.9, 0.5, "1.4 to 2.4; Lu et al. 1.76")
    finer = penetrate(example(PROBLEM, "contact.toml"), 8, SHORTER, STEP_FINE)
    coarse, fine = (cone_resistance(each, SHORTER) for each in (curves[SOFT], finer))
    yield relative("N_kt at two diameters, Ir 100, h D/6", coarse, fine, 0.05, "h D/8")


def stiff_clay() -> Model:
    """Returns the deep cone in the second clay, in a wider cylinder."""
    model = example(PROBLEM, "contact.toml")
    shape = model.bodies[0].shape
    assert isinstance(shape, Polygon)
    edge = max(x for x, _ in shape.vertices)
    corners = [[WIDE if x == edge else x, y] for x, y in shape.vertices]
    changes = {
        "materials.clay.young_modulus": 2.0 * (1.0 + POISSON) * STIFF * STRENGTH,
        "bodies.0.shape.vertices": corners,
        "boundaries.0.at": WIDE,
    }
    return varied(model, changes)


def penetrate(model: Model, cells: int, travel: float, step: float = STEP) -> Curve:
    """Returns N_kt = q / s_u against the depth.

    cells: of the grid, to the diameter. travel: depth below the hole at the end [m].
    step: how far a step pushes [m].
    """
    changes = {
        "grid.cell_size": DIAMETER / cells,
        "boundaries.2.displacement": {"y": -travel},
        "schedule.steps": round(travel / step),
    }
    curve = reaction_curve(varied(model, changes))
    area = 0.25 * math.pi * DIAMETER**2
    return Curve(curve.displacement, curve.force / (area * STRENGTH))


def cone_resistance(curve: Curve, depth: float) -> float:
    """Returns the mean of a curve over the last `WINDOW` to a depth [m]."""
    return float(curve.at(np.linspace(depth - WINDOW, depth, 11)).mean())
