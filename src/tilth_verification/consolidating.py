# SPDX-License-Identifier: BSD-3-Clause
"""Runs of soil that consolidates: its excess pore pressure and volume after each step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.grid.keys import find_keys
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import PRESSURE


@dataclass
class Consolidation:
    """What a run of n steps has found.

    Attributes:
        time: at the ends of the steps.
        pressure: excess at the nodes nearest to some places [stress], (k,) after each step.
        top: pressure of the topmost points [stress].
        least, greatest: of the nodes with soil [stress].
        volume: of the soil [length^dim].
        force: on the soil, of the boundary that is asked for, (dim,) after each step.
        points: at the end.
    """

    time: list[float] = field(default_factory=list)
    pressure: list[Floats] = field(default_factory=list)
    top: list[float] = field(default_factory=list)
    least: list[float] = field(default_factory=list)
    greatest: list[float] = field(default_factory=list)
    volume: list[float] = field(default_factory=list)
    force: list[Floats] = field(default_factory=list)
    points: MaterialPoints | None = None

    @property
    def steps(self) -> list[float]:
        """Sizes of the steps [time]."""
        return [float(size) for size in np.diff([0.0, *self.time])]

    def settlement(self, area: float) -> Floats:
        """Returns the lost volume over an area [length], shape (n,)."""
        assert self.points is not None
        lost = float(self.points.initial_volume.sum()) - np.array(self.volume)
        return np.asarray(lost / area)


def conductivity(model: Model, material: str) -> float:
    """Returns kappa = k / gamma_w of a material [length^4 / (force time)]."""
    assert model.flow is not None
    return number(model, material, "hydraulic_conductivity") / model.flow.unit_weight


def number(model: Model, material: str, key: str) -> float:
    """Returns a number of a material that is the same everywhere."""
    return float(getattr(model.materials[material], key))


def consolidate(
    model: Model, places: Sequence[Sequence[float]], boundary: str = ""
) -> Consolidation:
    """Takes all steps of a model with flowing water.

    Args:
        model: with a section [flow].
        places: on lines of the grid, where the pressure is that of a node, (k, dim).
        boundary: whose force is asked for; none if empty.

    Raises:
        AnalysisFailed: no equilibrium with the least step.
    """
    found = Consolidation()

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        water, active = simulation.state.pore_pressure, result.active
        assert water is not None
        node = [int(np.abs(active.position - place).max(axis=1).argmin()) for place in places]
        value = water.value[find_keys(water.key, active.key), 0]
        points = simulation.state.points
        found.time.append(time)
        found.top.append(float(points.water[points.position[:, -1].argmax(), PRESSURE]))
        found.pressure.append(value[node])
        found.least.append(float(value.min()))
        found.greatest.append(float(value.max()))
        found.volume.append(float(points.volume.sum()))
        if boundary:
            found.force.append(np.asarray(result.resultant(boundary)))

    found.points = march(model, after_step).state.points
    return found
