# SPDX-License-Identifier: BSD-3-Clause
"""A vertical cut in clay: the gravity at which it fails, on three grids."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from tilth.analysis.clock import Clock
from tilth.analysis.load_steps import load_steps
from tilth.analysis.march import initial_position
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.errors import AnalysisFailed
from tilth.model import BodyForce, Model, Tresca
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.comparison import Comparison, at_least, relative

PROBLEM = "vertical_cut"
HEIGHT = 4.0
"""Height of the cut [m]."""
CREST = np.array([4.0, 6.0])
"""Where its vertical face meets the surface [m]."""
FAILURE = 3.78
"""gamma H / c at failure by limit analysis; the best slip circle gives the upper bound 3.83 [-]."""
TOLERANCE = 0.03
SHOWN = 10.0
"""Settlements of the curve over the elastic one at failure, as drawn to read its curvature [-]."""
COLLAPSE = 100.0
"""Rate of settlement over the first one at which the run ends, well beyond failure [-]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Failure extrapolated from three grids with GIMP; long: finer ones, and the linear basis."""
    yield from extrapolated("gimp", (8, 16, 32) if long else (4, 8, 16))
    if long:
        yield from extrapolated("linear", (8, 16, 32))


def extrapolated(basis: str, cells: tuple[int, int, int]) -> Iterator[Comparison]:
    """Failure on grids with so many cells over the height, and its limit at first order."""
    coarse, middle, fine = (failure(with_basis(with_cells(n), basis)) for n in cells)
    grids = ", ".join(f"H/{n}" for n in cells)
    quantity = f"gamma H / c at failure, {basis}, extrapolated from h {grids}"
    yield relative(quantity, 2.0 * fine - middle, FAILURE, TOLERANCE, "limit analysis")
    quantity = f"gamma H / c at failure, {basis}, h H/{cells[-1]}"
    tolerance = 0.6 / cells[-1]
    yield relative(quantity, fine, FAILURE, tolerance, "limit analysis, first order in h")
    order = math.log2((coarse - middle) / (middle - fine))
    yield at_least(f"order, {basis}, h {grids}", order, 0.7, 0.0, "first order")


def with_cells(cells: int) -> Model:
    """Returns the cut with so many cells over its height."""
    return varied(example(PROBLEM), {"grid.cell_size": HEIGHT / cells})


def failure(model: Model) -> float:
    """Returns gamma H / c [-] at the largest curvature of the crest's settlement over gravity."""
    stability, settlement = raise_gravity(model)
    return float(stability[sharpest(stability, settlement)])


def sharpest(load: Floats, settlement: Floats) -> int:
    """Returns where the curve of a settlement over a load bends the most.

    The curvature depends on the scales of a drawing. Here the load is drawn up to where the elastic
    settlement, in proportion to the first one, is a tenth of the drawing's height: the curve begins
    with the slope 1 / 10, whatever the units and the stiffness.
    """
    drawn = settlement * (load[0] / settlement[0]) / SHOWN
    slope = np.gradient(drawn, load)  # of both sides of a step, whose sizes may differ
    curvature = np.gradient(slope, load) / (1.0 + slope**2) ** 1.5
    return int(curvature[1:-1].argmax()) + 1


def raise_gravity(model: Model) -> tuple[Floats, Floats]:
    """Raises gravity until the cut has failed: a step fails, or the crest settles very fast.

    Returns gamma H / c [-] and the settlement of the crest [length] after each step, (n,) each.
    """
    clay, gravity = model.materials["clay"], model.loads[0]
    assert isinstance(clay, Tresca)
    assert isinstance(gravity, BodyForce)
    assert clay.density is not None
    unit = -gravity.acceleration[1] * clay.density * HEIGHT / clay.undrained_shear_strength
    simulation = Simulation(model)
    simulation.check()
    points = simulation.state.points
    nearest = np.abs(initial_position(points) - CREST).sum(axis=1).argmin()
    crest = points.point_id[[nearest]]
    rows: list[tuple[float, float]] = []
    with suppress(AnalysisFailed):
        for _, result in load_steps(simulation, Clock(model.schedule)):
            points = simulation.state.points
            settlement = -points.displacement[points.index_of(crest)[0], 1]
            rows.append((unit * model.load_curve(gravity).factor(result.time), settlement))
            if len(rows) > 1 and rate(rows[-2:]) > COLLAPSE * rate([(0.0, 0.0), rows[0]]):
                break
    load, settlements = np.array(rows).T
    return load, settlements


def rate(rows: list[tuple[float, float]]) -> float:
    """Returns the slope between two pairs of load and settlement [length]."""
    (before, then), (now, settled) = rows
    return (settled - then) / (now - before)
