# SPDX-License-Identifier: BSD-3-Clause
"""The starting state of a layered slope with a bench and a water table, and of level ground."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np

from tilth.analysis.initial_equilibrium import InitialEquilibrium, find_initial_equilibrium
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, absolute, at_least, relative, vanishing

PROBLEM = "k0_slope"
RESIDUAL = 1e-8
"""Greatest residual of the undisplaced soil relative to the forces [-]."""
HEAVIEST = 20e3
"""Greatest unit weight of the soil [N/m3]."""
LENGTH, EDGE = 120.0, 5.0
"""Length of the slope, and of its far field at either end [m]."""
GROUND_STRESS = 80e3
"""Vertical stress at the base of the level ground [Pa]."""
SHIFT = 0.4
"""Shift of the grid, in cells; also the distance of the points that then fit the body."""
SLOPE = ((0.0, 0.0), (16.0, 0.0), (16.0, 2.0), (10.0, 2.0), (6.0, 4.0), (0.0, 4.0))
"""Sloping ground between smooth walls [m]."""
LINEAR_CHANGE = 0.4
"""Greatest change with the linear basis and points that form no pattern in the cells, over the
stress at the base [-]: the quadrature of standard points does not converge there."""
AT_REST = "at rest"


@dataclass(frozen=True)
class Start:
    """A model before its first step, in equilibrium; arrays by the points' numbers.

    Attributes:
        position: of the points [length], shape (n, dim).
        declared, stress: effective stress before and after [stress], shape (n, 6).
        report: of the equilibrium.
        moved: largest displacement of a point, found there and in the next step [length].
    """

    position: Floats
    declared: Floats
    stress: Floats
    report: InitialEquilibrium
    moved: tuple[float, float]

    @classmethod
    def of(cls, model: Model) -> Start:
        """Finds the equilibrium, then takes a step with the same loads."""
        simulation = Simulation(model)
        simulation.check()
        points = simulation.state.points
        declared = points.stress[points.index_of(np.arange(len(points)))]
        report = find_initial_equilibrium(simulation)
        order = points.index_of(np.arange(len(points)))
        position, stress = points.position[order], points.stress[order]
        moved = [float(np.abs(points.displacement).max())]
        simulation.advance(0.0, model.schedule.regular_time(1))
        moved.append(float(np.abs(points.displacement).max()))
        return cls(position, declared, stress, report, (moved[0], moved[1]))

    @property
    def change(self) -> Floats:
        """Largest change of a component of the stress of each point [stress], shape (n,)."""
        return np.asarray(np.abs(self.stress - self.declared).max(axis=1))


def comparisons(long: bool) -> Iterator[Comparison]:
    """The slope on two grids, in the long form on three; level, sloping ground; a bench in 3D."""
    for size in (1.0, 0.5, 0.25) if long else (1.0, 0.5):
        start = Start.of(varied(example(PROBLEM), {"grid.cell_size": size}))
        yield from _in_equilibrium(f"layered slope, h {size:g} m", start)
        yield from _far_field(size, start)
    yield from _level_ground()
    yield from _sloping_ground((0.5, 0.25, 0.125) if long else (1.0, 0.5, 0.25))
    start = Start.of(example(PROBLEM, "bench_3d.toml"))
    yield from _in_equilibrium("bench in 3D", start)
    force = start.report.result.resultant("base")[2]
    weight = HEAVIEST * (8.0 * 8.0 * 4.0 + 4.0 * 4.0 * 2.0)
    yield relative("force on the base, bench in 3D", force, weight, RESIDUAL, "weight", "N")


def _in_equilibrium(what: str, start: Start) -> Iterator[Comparison]:
    residual, (found, next_step) = start.report.residual_after, start.moved
    yield vanishing(f"residual, {what}", residual, RESIDUAL, "equilibrium")
    yield vanishing(f"displacement, {what}", found, 0.0, "the soil stays", "m")
    quantity = f"displacement in the next step under the same loads, {what}"
    yield vanishing(quantity, next_step, 0.0, "no force is carried along", "m")


def _far_field(size: float, start: Start) -> Iterator[Comparison]:
    """Vertical stress of columns far from the slope; within a cell it may be constant."""
    x, y = start.position.T
    vertical = -start.stress[:, 1]
    for side, chosen, expected in (
        ("crest", x < EDGE, _below_crest(y)),
        ("toe", x > LENGTH - EDGE, _below_toe(y)),
    ):
        error = np.where(chosen, np.abs(vertical - expected), -1.0)
        worst = int(error.argmax())
        bound = HEAVIEST * 0.25 * size
        quantity = f"effective vertical stress far from the slope, {side}, h {size:g} m, the worst"
        yield absolute(quantity, vertical[worst], expected[worst], bound, AT_REST, "Pa")


def _below_crest(y: Floats) -> Floats:
    """Returns the effective vertical stress below the crest, y = 12 m: sand to 6 m, water to 9."""
    dry, wet = 12.0 - np.maximum(y, 9.0), np.maximum(9.0 - np.maximum(y, 6.0), 0.0)
    clay, water = np.maximum(6.0 - y, 0.0), np.maximum(9.0 - y, 0.0)
    return np.asarray(18e3 * dry + 20e3 * wet + 19.5e3 * clay - 10e3 * water)


def _below_toe(y: Floats) -> Floats:
    """Returns the effective vertical stress below the toe at y = 4 m: clay under water to there."""
    return np.asarray((19.5e3 - 10e3) * (4.0 - y))


def _level_ground() -> Iterator[Comparison]:
    """Stress that is in equilibrium as declared changes by what the grid cannot represent."""
    start = Start.of(ground("gimp", 1.0, shifted=False))
    quantity = "largest change of stress over that at the base, level ground, gimp on grid lines"
    yield vanishing(quantity, start.change.max() / GROUND_STRESS, 1e-13, AT_REST)
    for basis, measure in (("gimp", np.max), ("cpdi2", _mean_square)):
        what = "largest" if measure is np.max else "mean square"
        changes = []
        for size in (1.0, 0.5, 0.25):
            change = Start.of(ground(basis, size, shifted=True)).change
            changes.append(float(measure(change)) / GROUND_STRESS)
            quantity = f"{what} change over the stress at the base, level, {basis}, h {size:g} m"
            yield vanishing(f"{quantity}, shifted", changes[-1], 0.01 * size, AT_REST)
        quantity = (
            f"{what} change of stress at h 0.5 m over that at 0.25 m, level, {basis}, shifted"
        )
        yield at_least(quantity, changes[1] / changes[2], 1.4, 0.0, "falls with the grid")

    for size in (1.0, 0.25):
        change = Start.of(ground("linear", size, shifted=True)).change.max() / GROUND_STRESS
        quantity = f"largest change over the stress at the base, level, linear, h {size:g} m"
        yield vanishing(f"{quantity}, shifted", change, LINEAR_CHANGE, AT_REST)


def _mean_square(change: Floats) -> float:
    return float(np.sqrt((change**2).mean()))


def _sloping_ground(sizes: tuple[float, ...]) -> Iterator[Comparison]:
    """The stress at rest is not in equilibrium there: what is found differs less on finer grids."""
    for basis in ("gimp", "cpdi2"):
        for shifted in (False, True):
            starts = [Start.of(ground(basis, h, shifted, vertices=SLOPE)) for h in sizes]
            place = "shifted" if shifted else "on grid lines"
            differences = [_difference(coarse, fine) for coarse, fine in pairwise(starts)]
            quantity = f"mean square change of the found stress with the grid, {basis}, {place}, "
            quantity += f"h {sizes[0]:g} to {sizes[1]:g} m over the next"
            yield at_least(
                quantity, differences[0] / differences[1], 1.4, 0.0, "falls with the grid"
            )


def _difference(coarse: Start, fine: Start) -> float:
    """Returns the mean square difference of the stress on two grids [stress]."""
    from scipy.interpolate import LinearNDInterpolator

    found = LinearNDInterpolator(fine.position, fine.stress)(coarse.position)
    inside = ~np.isnan(found[:, 0])
    return _mean_square(np.abs(found - coarse.stress)[inside].max(axis=1))


def ground(
    basis: str, size: float, shifted: bool, vertices: tuple[tuple[float, float], ...] = ()
) -> Model:
    """Returns homogeneous ground at rest on cells of this size [m].

    shifted: whether walls and base are inside cells. vertices: of its outline, level if not given.
    """
    changes: dict[str, Any] = {
        "bodies.0.basis": basis,
        "bodies.0.domain_update": None,
        "bodies.0.spacing": (SHIFT if shifted else 0.5) * size,
        "grid.cell_size": size,
    }
    length = 8.0
    if vertices:
        changes["bodies.0.shape.vertices"] = vertices
        length = changes["boundaries.2.at"] = vertices[1][0]
    if shifted:
        changes["grid.origin"] = [-SHIFT * size, -SHIFT * size]
        changes["boundaries"] = [
            _wall("base", [0.0, 0.0], [0.0, 1.0]),
            _wall("left", [0.0, 0.0], [1.0, 0.0]),
            _wall("right", [length, 0.0], [-1.0, 0.0]),
        ]
    return varied(example(PROBLEM, "level.toml"), changes)


def _wall(name: str, point: list[float], normal: list[float]) -> Mapping[str, Any]:
    plane = {"type": "plane", "point": point, "normal": normal}
    wall = {"name": name, "type": "implicit", "condition": "roller", "geometry": plane}
    return MappingProxyType(wall)
