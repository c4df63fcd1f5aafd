# SPDX-License-Identifier: BSD-3-Clause
"""An embankment built in lifts on soft clay, and a strip surcharge on uniform clay."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.analysis.march import march_stages
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.errors import AnalysisFailed
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative, vanishing

PROBLEM = "embankment"
LIFT_AREAS = (4.25, 3.75, 3.25, 2.75, 2.25)
"""Of half of each lift [m^2]."""
FILL_WEIGHT = 20.0
"""Unit weight of the fill [kN/m^3]."""
CELL = 0.5
"""Of the case [m]."""
LIMIT = 2.0 + np.pi
"""Pressure of a smooth strip on weightless clay over its shear strength (Prandtl) [-]."""
BEYOND = 6.5
"""Pressure over the strength to which the surcharge would increase [-]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Weight and place of each lift; the surcharge at failure."""
    for basis in ("gimp", "linear", "cpdi2") if long else ("gimp",):
        yield from lifts(basis)
    for cell_size in (0.25, 0.125):
        yield from limit("linear", cell_size)
    if long:
        for basis in ("gimp", "cpdi2"):
            yield from limit(basis, 0.25)


def lifts(basis: str) -> Iterator[Comparison]:
    """The force on the base at the end of each stage, and the gap below each lift at its start."""
    model = example(PROBLEM)
    of_bodies: dict[str, Any] = {f"bodies.{i}.basis": basis for i in range(len(model.bodies))}
    of_bodies |= {f"bodies.{i}.domain_update": None for i in range(len(model.bodies))}
    of_bodies |= {f"bodies.{i}.surface": {} for i in range(len(model.bodies) - 1)}
    carried: dict[str, float] = {}
    gaps: dict[str, float] = {}

    def after_step(analysis: StagedAnalysis, result: StepResult) -> None:
        carried[analysis.simulation.setup.model.stage.name] = float(result.resultant("base")[1])

    def at_start(analysis: StagedAnalysis) -> None:
        number = analysis.number
        if number > 0:
            below = "ground" if number == 1 else f"lift {number - 1}"
            gap = gaps_below(analysis.simulation, f"lift {number}", below)
            gaps[f"lift {number}"] = float(np.abs(gap).max()) / CELL

    march_stages(varied(model, of_bodies), after_step, at_start)
    added = np.diff(list(carried.values()))
    for number, (force, area) in enumerate(zip(added, LIFT_AREAS, strict=True), start=1):
        quantity = f"force on the base that lift {number} adds, {basis}"
        yield relative(quantity, float(force), FILL_WEIGHT * area, 1e-8, "its weight", "kN/m")
    for name, gap in gaps.items():
        quantity = f"largest gap or overlap of {name} and the soil below, in cells, {basis}"
        yield vanishing(quantity, gap, 0.02, "it rests on the settled ground")


def gaps_below(simulation: Simulation, name: str, ground: str) -> Floats:
    """Returns the heights of the lower faces of a body above the surface of the ground [length].

    name: of the body. ground: name of the body below, which has a tracked surface.
    """
    points = simulation.state.points
    own = points.of_body(name)
    position, half = points.position[own], points.half_length[own]
    shape = simulation.state.surfaces[ground].shape()
    start, end = shape.position[shape.cells].transpose(1, 0, 2)
    found = []
    for x in np.unique(np.round(position[:, 0], 9)):
        column = np.abs(position[:, 0] - x) < 1e-6
        bottom = (position - half)[column, 1].min()
        crossed = (start[:, 0] - x) * (end[:, 0] - x) < 0.0
        part = (x - start[crossed, 0]) / (end - start)[crossed, 0]
        height = start[crossed, 1] + part * (end - start)[crossed, 1]
        if len(height):  # the outermost column may be beside the ground
            found.append(bottom - height.max())
    return np.array(found)


def limit(basis: str, cell_size: float) -> Iterator[Comparison]:
    """The last pressure in equilibrium, over the strength; the strip is 2 m wide."""
    changes = {
        "bodies.0.basis": basis,
        "bodies.0.domain_update": None,
        "grid.cell_size": cell_size,
        "stages.1.schedule": {"steps": 60, "minimum_step": 0.001},
        "stages.1.factors": {"surcharge": [[0.0, 4.0], [1.0, BEYOND]]},
    }
    model = varied(example(PROBLEM, "strip.toml"), changes)
    reached = [0.0]

    def after_step(analysis: StagedAnalysis, result: StepResult) -> None:
        stage = analysis.simulation.setup.model
        reached[0] = stage.load_curve(stage.loads[0]).factor(result.time)

    at = f"{basis}, h B/{2.0 / cell_size:g}"
    try:
        march_stages(model, after_step)
        failed = 0.0
    except AnalysisFailed:
        failed = 1.0
    yield at_least(f"a strip surcharge fails, {at}", failed, 1.0, 0.0, "it has a limit")
    yield relative(
        f"q / s_u of a strip surcharge at failure, {at}", reached[0], LIMIT, 0.05, "2 + pi"
    )
