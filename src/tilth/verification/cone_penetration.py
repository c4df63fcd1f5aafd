# SPDX-License-Identifier: BSD-3-Clause
"""A cone pressed into clay: from its surface in axisymmetry and in 3D, and deep with its shaft."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tilth.verification.cases import example, varied
from tilth.verification.closed_forms.limit_loads import cone_factor
from tilth.verification.comparison import Comparison, absolute, relative, vanishing
from tilth.verification.contact_runs import run_contact
from tilth.verification.curves import Curve, largest_difference, reaction_curve

PROBLEM = "cone_penetration"
START = 0.25
"""Depth of the tip from which on curves are compared [m]: half of the displacement."""
DIAMETER, STRENGTH = 1.0, 10e3
"""Of the deep cone [m]; s_u of its clay [Pa]."""
INCREMENTS = 50
"""Number of increments of the whole displacement, for the roughness."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Both curves to the end, and how smooth they are; in 3D only if long."""
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
        yield from deep()


def deep() -> Iterator[Comparison]:
    """The cone factor three diameters below its hole, for two stiffnesses and on two grids."""
    factors = {}
    for rigidity in (100.0, 300.0):
        curve = penetrate(rigidity, 8)
        factor = float(curve.force[-1])
        factors[rigidity] = factor
        label = f"Ir {rigidity:g}, h D/8"
        exact, source = cone_factor(rigidity), "Lu et al. 2004, from memory"
        yield relative(f"N_kt, {label}", factor, exact, 0.12, source)
        before = float(curve.at(curve.displacement[-1] - DIAMETER))
        quantity = f"change of N_kt over the last diameter, {label}"
        yield vanishing(quantity, 1.0 - before / factor, 0.03, "steady")
    difference = factors[300.0] - factors[100.0]
    yield absolute("N_kt of Ir 300 less that of Ir 100", difference, 1.9, 0.5, "1.4 to 2.4")
    fine = float(penetrate(100.0, 12).force[-1])
    quantity = "N_kt, Ir 100, h D/8 against D/12"
    yield relative(quantity, factors[100.0], fine, 0.05, "the other grid")


def penetrate(rigidity: float, cells: int) -> Curve:
    """Returns N_kt = q / s_u against the depth, with this number of cells to the diameter.

    rigidity: G / s_u of Tresca's law, whose s_u is half of the strength in compression [-].
    """
    young = 2.0 * (1.0 + 0.49) * rigidity * STRENGTH
    changes = {"grid.cell_size": DIAMETER / cells, "materials.clay.young_modulus": young}
    model = varied(example(PROBLEM, "contact.toml"), changes)
    area = 0.25 * math.pi * DIAMETER**2
    return run_contact(model).curve("cone", 1, -1.0 / (area * STRENGTH))
