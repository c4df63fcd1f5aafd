# SPDX-License-Identifier: BSD-3-Clause
"""A cone pressed into clay, a polyline in axisymmetry and an STL surface in 3D."""

from __future__ import annotations

from collections.abc import Iterator

from tilth.verification.cases import example, varied
from tilth.verification.comparison import Comparison, relative, vanishing
from tilth.verification.curves import largest_difference, reaction_curve

PROBLEM = "cone_penetration"
START = 0.25
"""Depth of the tip from which on curves are compared [m]: half of the displacement."""
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
