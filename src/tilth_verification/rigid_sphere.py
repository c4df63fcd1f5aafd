# SPDX-License-Identifier: BSD-3-Clause
"""A rigid sphere pressed into clay: the same smooth curve on other grids and in 3D."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.curves import Curve, largest_difference, reaction_curve

PROBLEM = "rigid_sphere"
DIAMETER = 1.0
"""Of the sphere [m]."""
START = 0.1 * DIAMETER
"""Displacement from which on curves are compared [m]."""
INCREMENTS = 30
"""Number of increments of the whole displacement, for the roughness."""
TOLERANCE = {"smooth": 0.06, "rough": 0.11}
"""Largest difference between cells of an eighth and a twentieth of the diameter [-]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Curves on coarse and fine cells; long: finer ones, and the quarter in 3D."""
    yield from refined(long)
    if long:
        yield from three_dimensional()


def refined(long: bool) -> Iterator[Comparison]:
    """Cells of an eighth of the diameter against finer ones."""
    fine = 20 if long else 12
    for name, file in (("smooth", "case.toml"), ("rough", "rough.toml")):
        curves = [press(file, n) for n in (8, fine)]
        yield same(curves[0], curves[1], f"{name}, h D/8 and D/{fine}", TOLERANCE[name])
        if long:
            finest = press(file, 40)
            displacement = np.linspace(START, curves[0].displacement[-1], 21)
            errors = [
                np.abs(c.at(displacement) / finest.at(displacement) - 1.0).mean() for c in curves
            ]
            order = float(np.log(errors[0] / errors[1]) / np.log(20.0 / 8.0))
            quantity = f"order of the mean difference from h D/40, {name}, h D/8 and D/20"
            yield at_least(quantity, order, 0.8, 0.0, "first order")


def three_dimensional() -> Iterator[Comparison]:
    """A quarter in 3D against the axisymmetric curve on cells of the same size."""
    for n in (8, 10):
        quarter = press("three_dimensional.toml", n)
        yield same(quarter, press("case.toml", n), f"3D and axisymmetric, h D/{n}", 0.08)
        quantity = f"RMS of the second difference of the force over its mean, 3D, h D/{n}"
        yield vanishing(quantity, quarter.roughness(INCREMENTS, START), 0.01, "a smooth curve")
    sizes = graded_sizes(DIAMETER / 8)
    model = varied(example(PROBLEM, "three_dimensional.toml"), {"grid.cell_size": sizes})
    quarter = reaction_curve(model)
    yield same(quarter, press("case.toml", 8), "3D, graded, and axisymmetric, h D/8", 0.04)


def graded_sizes(h: float) -> dict[str, list[list[float]]]:
    """Returns cell sizes that grow from `h` within 0.75 D of the sphere's path to 0.5 D."""
    across = [[0.0, h], [0.75, h], [2.5, 0.5]]
    return {"x": across, "y": across, "z": [[0.0, 0.5], [1.5, h], [2.5, h]]}


def same(curve: Curve, reference: Curve, of: str, tolerance: float) -> Comparison:
    """Returns a row: the forces at the largest difference of two curves."""
    displacement, computed, exact = largest_difference(curve, reference, START)
    quantity = f"force at {displacement:.3g} m, the farthest apart from 0.1 D on, {of}"
    return relative(quantity, computed, exact, tolerance, "the other grid", "N")


def press(file: str, cells: int) -> Curve:
    """Returns the curve of a case file's sphere, with this number of cells to its diameter."""
    return reaction_curve(varied(example(PROBLEM, file), {"grid.cell_size": DIAMETER / cells}))
