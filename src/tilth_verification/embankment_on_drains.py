# SPDX-License-Identifier: BSD-3-Clause
"""Drained ground in plane strain with an equivalent conductivity, against one round drain.

Hird, Pyrah & Russell (1992) give lines of drains in plane strain the conductivity with which their
clay consolidates as that around round drains. The unit cell, one round drain with its clay, is
computed in axisymmetry.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import HenckyElastic, Model
from tilth.mpm.pore_water import PRESSURE
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import Moduli
from tilth_verification.closed_forms.radial_drain import RadialDrain
from tilth_verification.comparison import Comparison, absolute, relative
from tilth_verification.consolidating import number

PROBLEM = "embankment_on_drains"
HEIGHT, LOAD = 3.0, 20.0
"""Of the clay [m], and of the embankment on it [kPa]."""
SPACING = 1.0
"""Between lines of drains, and diameter of the unit cell [m]."""
RATIO = 5.0
"""Diameter of the unit cell over that of its drain [-]."""
DAYS = (5, 10, 15, 20, 30, 40)
"""At which is compared; the embankment is built in ten."""
TOLERANCE = 0.05
CELL = "the unit cell"


@dataclass
class Cell:
    """What a run has found of the clay of one drain, after each step.

    Attributes:
        time: [day].
        settlement: mean of the topmost points [m].
        pressure: mean excess [kPa].
    """

    time: list[float] = field(default_factory=list)
    settlement: list[float] = field(default_factory=list)
    pressure: list[float] = field(default_factory=list)

    def at(self, day: float) -> tuple[float, float]:
        """Returns settlement and pressure at a day at which a step ends."""
        step = int(np.abs(np.array(self.time) - day).argmin())
        return self.settlement[step], self.pressure[step]


def comparisons(long: bool) -> Iterator[Comparison]:
    """Conductivity; clay between smooth walls around one line; the middle of the embankment."""
    lines, round_ = example(PROBLEM), example(PROBLEM, "unit_cell.toml")
    ratio = conductivity(lines) / conductivity(round_)
    quantity = "equivalent conductivity of lines of drains over that of the clay"
    yield relative(quantity, ratio, equivalent(RATIO), 1e-3, "the same mean pressure")
    reference = run(round_)
    yield from compared("clay between walls, h = B/4", run(between_walls(4)), reference)
    if long:
        yield from compared("clay between walls, h = B/8", run(between_walls(8)), reference)
    yield from compared("middle of the embankment, h = B/4", run(lines), reference)


def conductivity(model: Model) -> float:
    """Returns that of the clay [m/day]."""
    return number(model, "clay", "hydraulic_conductivity")


def equivalent(ratio: float) -> float:
    """Returns the conductivity of lines of drains over that around round ones [-].

    Around a round drain 1 - U = exp(-8 T / mu) with Barron's mu (equal strain), beside lines as far
    apart as the diameter of its clay mu is 2/3. Hird, Pyrah & Russell take ln n - 3/4 for mu, which
    it is for large n.

    ratio: n, diameter of the clay over that of its round drain.
    """
    return 2.0 / (3.0 * RadialDrain(ratio).resistance)


def between_walls(cells: int) -> Model:
    """Returns the clay of one line of drains between smooth walls.

    cells: number from a line to half way to the next one.
    """
    model = example(PROBLEM)
    assert model.flow is not None
    changes: dict[str, Any] = {
        "grid.cell_size": [0.5 * SPACING / cells, HEIGHT / 8],
        "flow.boundaries": model.to_dict()["flow"]["boundaries"][:2],
        "bodies.0.shape.upper": [SPACING, HEIGHT],
        "boundaries.1.at": SPACING,
        "loads.0.start": [SPACING, HEIGHT],
    }
    return varied(model, changes)


def run(model: Model) -> Cell:
    """Returns what is found of the clay up to `SPACING` from the axis or the middle."""
    found = Cell()

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        points = simulation.state.points
        start = points.position - points.displacement
        inside = start[:, 0] < SPACING
        volume = np.where(inside, points.initial_volume, 0.0)
        top = np.where(start[:, 1] > start[:, 1].max() - 1e-6, volume, 0.0)
        found.time.append(time)
        found.settlement.append(-float(top @ points.displacement[:, 1] / top.sum()))
        found.pressure.append(float(volume @ points.water[:, PRESSURE] / volume.sum()))

    march(varied(model, {"track": []}), after_step)
    return found


def final(model: Model) -> float:
    """Returns the settlement under the load without any excess pressure at small strain [m]."""
    clay = model.materials["clay"]
    assert isinstance(clay, HenckyElastic)
    return HEIGHT * LOAD / Moduli.of(clay).constrained


def compared(of: str, found: Cell, reference: Cell) -> Iterator[Comparison]:
    """Settlement over the final one, and mean excess pressure over the load, at `DAYS`."""
    end = final(example(PROBLEM))
    for day in DAYS:
        (settlement, pressure), (settled, left) = found.at(day), reference.at(day)
        quantity = f"settlement over the final one, {day} days, {of}"
        yield absolute(quantity, settlement / end, settled / end, TOLERANCE, CELL)
        quantity = f"mean excess pressure over the load, {day} days, {of}"
        yield absolute(quantity, pressure / LOAD, left / LOAD, TOLERANCE, CELL)
