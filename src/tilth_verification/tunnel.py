# SPDX-License-Identifier: BSD-3-Clause
"""A tunnel in undrained clay that loses a part of its section: the trough at the surface."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import CircleGeometry, ImplicitBoundary, Model, Polygon
from tilth.surface.tracked import TrackedSurface
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.line_sink import LineSink
from tilth_verification.comparison import Comparison, relative, vanishing

PROBLEM = "tunnel"
TUNNEL = "boundaries.3"
"""The tunnel's lining in the case file."""
COARSE, FINE, FINEST = 0.6, 0.3, 0.15
"""Cell sizes [m]: a tenth of the diameter, a twentieth and half of that."""
VOLUME_TOLERANCE = 0.02
"""Of the trough's area against the lost one; K / G is 500, not infinite."""
SETTLEMENT_TOLERANCE = {COARSE: 0.06, FINE: 0.04, FINEST: 0.04}
"""Of the greatest settlement: the closed form has a line of no radius where the tunnel has R, and
this differs by the order of (R / h)^2 = 0.041; on the coarse grid in addition that of the cells.
"""
FAR = 2.0
"""Beyond so many depths from the axis the whole trough is compared."""
SOURCE = "line sink, Sagaseta (1987)"


@dataclass(frozen=True)
class Trough:
    """The state at the end, of the whole tunnel.

    Attributes:
        sink: of the lost area, in the layer.
        x, settlement: of the boundary points on the surface [length], shape (n,), by increasing x.
        area: of the trough, from the boundary points [length^2].
        area_of_points: the same from the topmost material points.
        area_change: of the tracked surface that encloses the soil, over the lost area [-].
        lift: resultant of the tunnel's vertical forces over the sum of their magnitudes [-].
    """

    sink: LineSink
    x: Floats
    settlement: Floats
    area: float
    area_of_points: float
    area_change: float
    lift: float


def comparisons(long: bool) -> Iterator[Comparison]:
    """Two grids, and the fine one with a lining to which the clay sticks; long: a third grid."""
    for h in (COARSE, FINE, FINEST) if long else (COARSE, FINE):
        yield from trough(varied(example(PROBLEM), {"grid.cell_size": h}), f"h {h:g} m", h)
    stuck = {"grid.cell_size": FINE, f"{TUNNEL}.condition": "fixed"}
    yield from trough(varied(example(PROBLEM), stuck), f"h {FINE:g} m, rough lining", FINE)


def trough(model: Model, at: str, h: float) -> Iterator[Comparison]:
    """The trough's area and depth, and its shape beside the tunnel."""
    found = settle(model)
    lost, deepest = found.sink.lost, found.settlement.max()
    for what, area in (("surface", found.area), ("points", found.area_of_points)):
        quantity = f"area of the trough, by the {what}, {at}"
        yield relative(quantity, area, lost, VOLUME_TOLERANCE, "volume loss", "m^2")
    quantity = f"change of the soil's area over the lost one, {at}"
    yield vanishing(quantity, found.area_change, VOLUME_TOLERANCE, "incompressible")
    expected = found.sink.settlement(found.x)
    quantity = f"greatest settlement, {at}"
    tolerance = SETTLEMENT_TOLERANCE[h]
    yield relative(quantity, deepest, float(expected[0]), tolerance, SOURCE, "m")
    far = found.x > FAR * found.sink.depth
    difference = np.abs(found.settlement - expected)[far].max() / deepest
    quantity = f"difference of the settlement beyond {FAR:g} depths over the greatest, {at}"
    yield vanishing(quantity, float(difference), 0.01, SOURCE)
    quantity = f"force on the tunnel over the sum of its nodes' magnitudes, {at}"
    yield vanishing(quantity, found.lift, 0.02, "moves with the soil")


def settle(model: Model) -> Trough:
    """Contracts the tunnel of a model of half the ground, and returns the trough of the whole."""
    tunnel = model.boundaries[3]
    assert isinstance(tunnel, ImplicitBoundary)
    assert isinstance(tunnel.geometry, CircleGeometry)
    assert isinstance(model.bodies[0].shape, Polygon)
    width, height = np.max(model.bodies[0].shape.vertices, axis=0)
    radius, axis = tunnel.geometry.radius, tunnel.geometry.centre[1]
    lost = math.pi * (radius**2 - tunnel.radius(1.0) ** 2)
    lift = 0.0

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        nonlocal lift
        force = result.forces[tunnel.name][:, 1]
        lift = abs(float(force.sum())) / float(np.abs(force).sum())

    before = _surface(Simulation(model)).enclosed()
    simulation = march(model, after_step)
    surface = _surface(simulation)
    (chain,) = surface.chains
    top = np.isclose(chain.initial.points[:, 1], height)
    x, y = chain.current.points[top].T
    order = np.argsort(x)
    settlement = (height - y)[order]
    start, cell = initial_position(simulation.state.points), model.cell_size[0]
    row = start[:, 1] > height - 0.5 * cell
    spacing = width / np.count_nonzero(row)
    return Trough(
        sink=LineSink(lost, height - axis, height, width),
        x=x[order],
        settlement=settlement,
        area=2.0 * float(trapezoid(settlement, x[order])),
        area_of_points=-2.0 * spacing * float(simulation.state.points.displacement[row, 1].sum()),
        area_change=2.0 * abs(surface.enclosed() - before) / lost,
        lift=lift,
    )


def _surface(simulation: Simulation) -> TrackedSurface:
    surface = simulation.state.surfaces["soil"]
    assert isinstance(surface, TrackedSurface)
    return surface
