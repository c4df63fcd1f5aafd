# SPDX-License-Identifier: BSD-3-Clause
"""A round blade drawn through soft clay: steady force, soil kept, Newton iterations, energy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.analysis.clock import Clock
from tilth.analysis.load_steps import load_steps
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.points import MaterialPoints
from tilth_verification.cases import example
from tilth_verification.comparison import Comparison, at_most, relative, vanishing

PROBLEM = "plough"
WIDTH = 1.0
"""Of the blade [m]."""
TRAVEL = 5.0
"""Of the blade in the case file [m]."""
WEIGHT = 0.04
"""Time at which all of the weight acts and the blade begins to move."""
SHORT_WAY = 0.05
"""Way of the blade in the short form [m]."""
CELL = 0.25
"""Of the grid [m]; the force is averaged over ways of this length."""


@dataclass(frozen=True)
class Tow:
    """What happened while a blade was drawn.

    Attributes:
        way: of the blade at the end of each step [m], shape (n,).
        force: that the whole blade needs [N], shape (n,).
        energy: elastic and dissipated energy of the soil [J] after each step, shape (n,).
        work: of the weight and the blade on it since the start [J], shape (n,).
        volume: of the soil after each step [m^3], shape (n,).
        jacobian: least and greatest current over initial volume of F-bar of all points [-], (n, 2).
        iterations: Newton iterations of all steps, without those of attempts that failed.
        end: the soil at the end.
    """

    way: Floats
    force: Floats
    energy: Floats
    work: Floats
    volume: Floats
    jacobian: Floats
    iterations: int
    end: Simulation

    def after(self, way: float) -> int:
        """Returns the number of the first step that ends beyond a way [m]."""
        return int(np.searchsorted(self.way, way, side="right"))

    def mean_force(self, start: float, end: float) -> float:
        """Returns the mean of 201 places over a part of the way [N]."""
        return float(np.interp(np.linspace(start, end, 201), self.way, self.force).mean())


def comparisons(long: bool) -> Iterator[Comparison]:
    """The first 0.05 m; long: the whole way of five widths, 7 minutes on one core."""
    run = tow(None if long else SHORT_WAY)
    yield from kept(run)
    if not long:
        return
    yield from steady(run)
    mean = run.iterations / len(run.way)
    yield at_most("mean Newton iterations of a step", mean, 12.0, 0.0, "at most 12")


def tow(way: float | None = None) -> Tow:
    """Draws the blade of the case file by a way [m], or to the end."""
    model = example(PROBLEM)
    until = None if way is None else WEIGHT + (1.0 - WEIGHT) * way / TRAVEL
    simulation = Simulation(model)
    simulation.check()
    points = simulation.state.points
    rows: list[tuple[float, ...]] = []
    work, iterations = 0.0, 0
    for _, result in load_steps(simulation, Clock(model.schedule, until=until)):
        work += result.work
        iterations += result.equilibrium.iterations
        dissipated = float(points.plastic[:, 1] @ points.initial_volume)
        jacobian = points.assumed_jacobian
        rows.append(
            (
                TRAVEL * max(0.0, (result.time - WEIGHT) / (1.0 - WEIGHT)),
                2.0 * result.resultant("blade")[0],
                points.stored_energy() + dissipated,
                work,
                float(points.volume.sum()),
                float(jacobian.min()),
                float(jacobian.max()),
            )
        )
    way_, force, energy, done, volume, least, greatest = np.array(rows).T
    ends = np.column_stack([least, greatest])
    return Tow(way_, force, energy, done, volume, ends, iterations, simulation)


def kept(run: Tow) -> Iterator[Comparison]:
    """No soil is lost, doubled, compressed or in the blade; where the work goes."""
    moving = run.after(0.0)
    points = run.end.state.points
    quantity = f"change of the soil's volume while the blade is drawn {run.way[-1]:.2g} m"
    change = run.volume[moving:] / run.volume[moving - 1] - 1.0
    yield vanishing(quantity, float(np.abs(change).max()), 1e-3, "none")
    quantity = "greatest change of volume of any point, by F-bar"
    jacobian = run.jacobian[moving:]
    yield vanishing(quantity, float(np.abs(jacobian - 1.0).max()), 0.02, "none")
    centre = np.array([run.way[-1], 0.0])
    inside = np.linalg.norm(points.position[:, :2] - centre, axis=1) < 0.5 * WIDTH - 0.1 * CELL
    share = float(points.initial_volume[inside].sum() / points.initial_volume.sum())
    quantity = "share of the material points deeper in the blade than a tenth of a cell"
    yield vanishing(quantity, share, 0.002, "none")
    quantity = "greatest filling of a cube of two cells"
    yield relative(quantity, filling(points), 1.0, 0.2, "1")
    done = run.work[-1] - run.work[moving - 1]
    taken = run.energy[-1] - run.energy[moving - 1]
    quantity = "energy stored and dissipated while the blade is drawn"
    yield relative(quantity, taken, done, 0.1, "work of blade and weight", "J")


def filling(points: MaterialPoints) -> float:
    """Returns the greatest volume of points' domains in a cube of two cells over the cube's [-]."""
    cube, parts = 2.0 * CELL, 5
    along = (2.0 * np.arange(parts) + 1.0) / parts - 1.0
    inside = np.stack(np.meshgrid(along, along, along), axis=-1).reshape(-1, 3)
    place = points.position[:, None] + points.half_length[:, None] * inside
    key = np.floor(place.reshape(-1, 3) / cube).astype(np.int64)
    _, number = np.unique(key, axis=0, return_inverse=True)
    volume = np.repeat(points.volume / len(inside), len(inside))
    return float(np.bincount(number.ravel(), weights=volume).max() / cube**3)


def steady(run: Tow) -> Iterator[Comparison]:
    """The force over the last width: its drift and its parts."""
    end = float(run.way[-1])
    start = end - WIDTH
    whole = run.mean_force(start, end)
    way = np.linspace(start, end, 201)  # for steps that were cut lie close together
    slope = np.polyfit(way, np.interp(way, run.way, run.force), 1)[0]
    yield vanishing("drift of the force over the last width", slope * WIDTH / whole, 0.03, "steady")
    starts = start + CELL * np.arange(round(WIDTH / CELL))
    parts = np.array([run.mean_force(a, a + CELL) for a in starts])
    far = float(np.abs(parts / whole - 1.0).max())
    yield vanishing("greatest deviation of its mean over a cell's length", far, 0.03, "steady")
