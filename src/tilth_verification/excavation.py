# SPDX-License-Identifier: BSD-3-Clause
"""A stepped pit beside a loaded footing: the forces that are released, and the heave."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from tilth.analysis.gathering import whole_simulation
from tilth.analysis.march import march_stages
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.arrays import Floats
from tilth.model import BodyForce, Model
from tilth.mpm.active_grid import Buffers, locate
from tilth.mpm.points import MaterialPoints
from tilth_verification.carried import carried
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import Heave
from tilth_verification.comparison import Comparison, relative, vanishing

PROBLEM = "excavation"
BODIES = 4
"""Number of bodies of the case."""
CARRIED = "stress and weight of the removed soil"
K0 = 0.5
"""Earth pressure at rest of the case [-]."""
FIRST_STEP = (5.0, 1.5)
"""Width and height of what is dug first [m]."""
UNIT_WEIGHT = 18.0
"""Of the soil of the case [kN/m^3]."""
STRAINLESS = 1e11
"""Young's modulus with which nothing but the released forces can be seen [kPa]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Released forces by node and in all, equilibrium, rebound, order, heave of a wide pit."""
    for basis in ("gimp", "linear"):
        yield from released_by_node(basis)
    yield from resultants()
    for basis in ("linear", "gimp", "cpdi2"):
        yield from forth_and_back(basis)
    yield from order_of_digging()
    yield from wide_pit((0.25, 0.125, 0.0625) if long else (0.25, 0.125))


def with_soil(model: Model, basis: str, anti_locking: str = "none", **changes: Any) -> Model:
    """Returns the case with a basis of all bodies."""
    of_bodies: dict[str, Any] = {
        f"bodies.{i}.{key}": value
        for i in range(BODIES)
        for key, value in (
            ("basis", basis), ("domain_update", None), ("anti_locking", anti_locking),
        )
    }  # fmt: skip
    return varied(model, {**of_bodies, **changes})


def elastic(model: Model, young_modulus: float) -> Model:
    """Returns the case with elastic soil, whose footing carries nothing."""
    soil: dict[str, Any] = {"model": "hencky_elastic", "young_modulus": young_modulus}
    soil |= {"poisson_ratio": 0.3, "density": UNIT_WEIGHT / 10.0}
    return varied(model, {"materials.soil": soil, "loads.1.pressure": 1e-6})


def released_by_node(basis: str) -> Iterator[Comparison]:
    """In each of the three stages of the case, without F-bar, whose force is another sum.

    What is out of balance before anything is removed, since the soil moved against the grid, is
    released too.
    """
    before: dict[str, MaterialPoints] = {}
    rows: list[Comparison] = []

    def at_end(analysis: StagedAnalysis) -> None:
        points = analysis.simulation.state.points
        before["points"] = points.selected(np.ones(len(points), dtype=bool))

    def at_start(analysis: StagedAnalysis) -> None:
        simulation = analysis.simulation
        if simulation.setup.model.stage.number < 2:
            return
        error, residual = _errors_at_start(simulation, before["points"])
        at = f"{simulation.setup.model.stage.name}, {basis}"
        quantity = f"released less carried force of a node over the largest, {at}"
        rows.append(vanishing(quantity, error, 1e-8, CARRIED))
        quantity = f"residual over the largest force while nothing is released, {at}"
        rows.append(vanishing(quantity, residual, 1e-10, "equilibrium"))

    plain: dict[str, Any] = {"analysis.ghost_stabilisation": 0.0}  # its forces are no stress
    march_stages(with_soil(example(PROBLEM), basis, **plain), at_start=at_start, at_end=at_end)
    yield from rows


def _errors_at_start(simulation: Simulation, before: MaterialPoints) -> tuple[float, float]:
    """Returns the largest error of the released forces, and the residual at a stage's start [-].

    At the nodes that the removed soil reaches, which the footing does not load.

    before: the points at the end of the last stage.
    """
    step = simulation.prepare(0.0, 0.0)
    balance = simulation.balance(step, simulation.soil_on(step.active))
    residual = balance.evaluate(balance.at(np.zeros(step.active.position.shape))).u
    free = ~step.conditions.constrained
    released = np.zeros(free.shape)
    place = simulation.state.released.position
    node = np.abs(step.active.position[None] - place[:, None]).max(axis=2).argmin(axis=1)
    released[node] = simulation.state.released.force
    whole = locate(before, simulation.state.grid, Buffers())
    gravity = simulation.setup.model.loads[0]
    assert isinstance(gravity, BodyForce)
    acceleration = np.array(gravity.acceleration)
    number = np.flatnonzero(np.isin(whole.key, step.active.key))
    gone = before.selected(~np.isin(before.point_id, simulation.state.points.point_id))
    removed = carried(gone, whole, acceleration)[number]
    out_of_balance = carried(before, whole, acceleration)[number]
    reached = free & (removed != 0.0).any(axis=1)[:, None]
    error = np.abs(released - out_of_balance + removed)[reached].max()
    scale = np.abs(removed[reached]).max()
    return float(error / scale), float(np.abs(residual[free]).max() / scale)


def resultants() -> Iterator[Comparison]:
    """Dug from the state at rest: gamma B H upwards, K0 gamma H^2 / 2 towards the bank."""
    model = elastic(example(PROBLEM), STRAINLESS)
    first, _, dig, *_ = model.to_dict()["stages"]
    entries = {**model.to_dict(), "loads": model.to_dict()["loads"][:1], "stages": [first, dig]}
    width, height = FIRST_STEP
    for basis in ("linear", "gimp", "cpdi2"):
        case = with_soil(Model.from_dict(entries), basis, "f_bar")
        thrust, weight = march_stages(case).out_of_balance * [1.0, -1.0]
        exact = UNIT_WEIGHT * width * height
        quantity = f"vertical force released by the first step from rest, {basis}"
        yield relative(quantity, float(weight), exact, 1e-8, "its weight", "kN/m")
        exact = 0.5 * K0 * UNIT_WEIGHT * height**2
        quantity = f"horizontal force released by the first step from rest, {basis}"
        yield relative(quantity, float(thrust), exact, 1e-8, "K0 gamma H^2 / 2", "kN/m")


def positions(analysis: StagedAnalysis) -> Floats:
    """Returns all points' positions in the order of their numbers [length], shape (n, 2)."""
    points = whole_simulation(analysis.simulation).state.points
    return np.asarray(points.position[points.in_order])


def forth_and_back(basis: str) -> Iterator[Comparison]:
    """The first step dug in elastic soil, and time turned back: the released forces act again.

    No face of a domain lies on a grid line, where it would reach other nodes as soon as it moves.
    """
    changes: dict[str, Any] = {
        f"bodies.{i}.{key}": value
        for i in range(BODIES)
        for key, value in (("points_per_cell", None), ("spacing", 0.25))
    }
    changes["grid.cell_size"] = [20.0 / 43.0, 0.47]
    model = with_soil(elastic(example(PROBLEM), 1e7), basis, **changes)
    found: list[float] = []

    def drive(analysis: StagedAnalysis) -> None:
        if analysis.number < 2:
            return
        start, rebound = positions(analysis), 0.0
        times = np.concatenate([np.linspace(0.0, 1.0, 6), np.linspace(0.8, 0.0, 5)])
        for before, after in pairwise(times):
            analysis.simulation.advance(float(before), float(after))
            rebound = max(rebound, float(np.abs(positions(analysis) - start).max()))
        left = float(np.abs(positions(analysis) - start).max())
        found[:] = [left / rebound]

    march_stages(with_stages(model, model.to_dict()["stages"][:3]), drive=drive)
    quantity = f"rebound that is left when the forces act again, over the rebound, {basis}"
    yield vanishing(quantity, found[0], 1e-4, "elasticity")


def with_stages(model: Model, stages: list[dict[str, Any]]) -> Model:
    """Returns the model with other stages."""
    return Model.from_dict({**model.to_dict(), "stages": stages})


def order_of_digging() -> Iterator[Comparison]:
    """Two steps dug one after the other, in the other order and at once; elastic, small strain."""
    model = with_soil(elastic(example(PROBLEM), 1e9), "linear", "f_bar")
    rest = model.to_dict()["stages"][:2]
    found = []
    for order in (("first", "second"), ("second", "first"), ("both",)):
        dug = [["first step", "second step"] if n == "both" else [f"{n} step"] for n in order]
        dig = [
            {"name": f"dig {i}", "schedule": {"steps": 1}, "deactivate": names}
            for i, names in enumerate(dug)
        ]
        dig[0]["reset"] = ["displacement"]
        points = march_stages(with_stages(model, [*rest, *dig])).simulation.state.points
        found.append(points.displacement[points.in_order])
    size = np.abs(found[2]).max()
    for moved, what in ((found[0], "one after the other"), (found[1], "in the other order")):
        quantity = f"motion by two steps dug {what} less that of both at once, relative"
        error = float(np.abs(moved - found[2]).max() / size)
        yield vanishing(quantity, error, 1e-6, "linear elasticity")


def wide_pit(sizes: tuple[float, ...]) -> Iterator[Comparison]:
    """The heave of `wide.toml` in closed form; the tolerance falls with the cell."""
    model = example(PROBLEM, "wide.toml")
    soil = model.materials["soil"]
    young, poisson = soil.parameter("young_modulus"), soil.parameter("poisson_ratio")
    modulus = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    exact = Heave(height=5.0, removed=5.0, unit_weight=20.0, modulus=modulus).total()
    for size in sizes:
        analysis = march_stages(varied(model, {"grid.cell_size": size}))
        points = analysis.simulation.state.points
        heave = float((points.position + points.half_length)[:, 1].max()) - 5.0
        quantity = f"heave of 5 m under a wide pit of 5 m, h {size:g} m"
        yield relative(quantity, heave, exact, 0.02 * size, "one dimension", "m")
