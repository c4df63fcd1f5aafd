# SPDX-License-Identifier: BSD-3-Clause
"""The self-weight column off the grid lines and turned against the grid, by implicit boundaries."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import BodyForce, Box, HenckyElastic, Model, VonMises
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.closed_forms import SelfWeightColumn
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.convergence import log_slope
from tilth_verification.reference import AMPLE_COLUMN_ERROR

PROBLEM = "inclined_column"
HEIGHT = 50.0
OFFSETS = ((0.3, 0.4), (0.05, 0.95), (0.6, 0.4), (0.95, 0.05))
"""Positions of the column's lower left corner in its cell; the first is that of the case files."""
SETTLING_STEPS = 100
"""Steps at constant weight before creep is measured, in which the last load step settles."""


@dataclass
class Outcome:
    """Errors of a column.

    Attributes:
        stress_error: of the axial stress, volume-weighted mean over the base stress [-].
        reaction_error: of the boundaries' total force, largest over the steps, over the weight [-].
        position: of the points after each step [length], shape (n, 2) each.
    """

    stress_error: float = 0.0
    reaction_error: float = 0.0
    position: list[Floats] = field(default_factory=list)


def comparisons(long: bool) -> Iterator[Comparison]:
    """Aligned off the lines, on a line, turned, turned with CPDI, and at constant weight."""
    yield from aligned_off_the_lines()
    yield from on_a_line()
    yield from turned(long)
    for basis in ("cpdi1", "cpdi2"):
        yield from turned_domains(basis, long)
    yield from at_constant_weight(long)


def aligned_off_the_lines() -> Iterator[Comparison]:
    """GIMP converges as it does on grid lines; 1.5 times AMPLE's error is allowed."""
    model = example(PROBLEM, "aligned.toml")
    for cells in (8, 16, 32, 64):
        errors = [solve(placed(model, cells, offset)).stress_error for offset in OFFSETS]
        quantity = f"axial stress error, aligned off the lines, worst of 4 positions, {cells} cells"
        bound = 1.5 * AMPLE_COLUMN_ERROR[cells]
        yield vanishing(quantity, max(errors), bound, "at most 1.5 times AMPLE, figure")


def on_a_line() -> Iterator[Comparison]:
    """Boundaries on grid lines agree with elimination there up to a slip of order delta.

    Where the soil at the base is compressed by the strain e, the surface penalty 4 E / (3 delta)
    allows a slip of about 3/4 delta e; e is near 1 here.
    """
    model = example(PROBLEM, "aligned.toml")
    cells = 16
    eliminated = solve(example("self_weight_column"), cells).position[-1]
    size = HEIGHT / cells
    differences = []
    for delta in (1e-3, 1e-4):
        implicit = solve(varied(placed(model, cells, (0.0, 0.0)), with_delta(delta * size)))
        differences.append(float(np.abs(implicit.position[-1] - eliminated).max()) / size)
    quantity = "largest distance from elimination on the same lines, in cells, delta 1e-4 cells"
    yield vanishing(quantity, differences[1], 3e-4, "at most 3 delta")
    quantity = "the same with delta 1e-3 cells over that with 1e-4"
    yield relative(quantity, differences[0] / differences[1], 10.0, 0.02, "in proportion to delta")


def turned(long: bool) -> Iterator[Comparison]:
    """Turned by 30 degrees GIMP stops converging (fixed axes of domains); the reaction is exact."""
    model = example(PROBLEM)
    for cells in (16, 32, 64) if long else (16, 32):
        outcome = solve(placed(model, cells, OFFSETS[0]))
        quantity = f"axial stress error, turned by 30 degrees, {cells} cells"
        yield vanishing(quantity, outcome.stress_error, 1e-2, "closed form")
        quantity = f"reaction vector, turned by 30 degrees, {cells} cells, worst step, over weight"
        yield vanishing(quantity, outcome.reaction_error, 1e-8, "the weight")
    angle = varied(model, {"bodies.0.domain_update": "fixed"})
    outcome = solve(placed(angle, 32, OFFSETS[0]))
    quantity = "axial stress error, turned by 30 degrees, 32 cells, domains of fixed size"
    yield vanishing(quantity, outcome.stress_error, 1e-2, "closed form")


def turned_domains(basis: str, long: bool) -> Iterator[Comparison]:
    """CPDI's domains rotate with the body: at most 3 times the aligned error, and first order.

    Short: at the position of the case files. Long: also the worst of the four positions, which
    differ by more when the column is turned: the remaining error is at the corners of the base.
    """
    aligned, turned_model = (
        with_basis(example(PROBLEM, file), basis) for file in ("aligned.toml", "case.toml")
    )
    grids = (16, 32, 64) if long else (16, 32)
    at_case = {}
    for cells in grids:
        offsets = OFFSETS if long else OFFSETS[:1]
        outcomes = [solve(placed(turned_model, cells, offset)) for offset in offsets]
        aligned_errors = [solve(placed(aligned, cells, offset)).stress_error for offset in offsets]
        at_case[cells] = outcomes[0].stress_error
        quantity = f"axial stress error, {basis}, turned by 30 degrees, {cells} cells"
        yield vanishing(
            quantity, at_case[cells], 3.0 * aligned_errors[0], "at most 3 times aligned"
        )
        if long:
            worst = max(outcome.stress_error for outcome in outcomes)
            quantity += ", worst of 4 positions"
            yield vanishing(
                quantity, worst, 3.0 * max(aligned_errors), "at most 3 times aligned, worst"
            )
        quantity = f"reaction vector, {basis}, turned by 30 degrees, {cells} cells, worst step"
        reaction = max(outcome.reaction_error for outcome in outcomes)
        yield vanishing(quantity, reaction, 1e-8, "the weight")
    first, last = grids[0], grids[-1]
    rate = log_slope(at_case[first], at_case[last], last / first)
    quantity = f"convergence rate, {basis}, turned by 30 degrees, {first} to {last} cells"
    yield at_least(quantity, rate, 1.0, 0.0, "first order at least")


def at_constant_weight(long: bool) -> Iterator[Comparison]:
    """At constant weight the column does not creep through its boundaries."""
    steps = 1000 if long else 200
    for name, file in (("aligned off the lines", "aligned.toml"), ("turned", "case.toml")):
        model = placed(example(PROBLEM, file), 8, OFFSETS[0])
        position = solve(at_constant_weight_for(model, steps)).position
        creep = float(np.abs(position[-1] - position[-1 - steps + SETTLING_STEPS]).max()) / HEIGHT
        counted = steps - SETTLING_STEPS
        quantity = f"creep over the last {counted} of {steps} steps at constant weight, {name}"
        yield vanishing(quantity, creep, 1e-10, "no motion, in heights")


def at_constant_weight_for(model: Model, steps: int) -> Model:
    """Returns the column under its full weight after further steps of the same size."""
    loading = model.schedule.number_of_steps
    end = 1.0 + steps / loading
    changes = {
        "analysis.tolerance": 1e-12,
        "schedule.steps": loading + steps,
        "schedule.end": end,
        "loads.0.factor": [[0.0, 0.0], [1.0, 1.0], [end, 1.0]],
    }
    return varied(model, changes)


def solve(model: Model, cells: int | None = None) -> Outcome:
    """Returns the outcome of a column; cells: over its height, for that of `self_weight_column`."""
    if cells is not None:
        size = HEIGHT / cells
        changes = {"grid.cell_size": size, "bodies.0.shape.upper": [size, HEIGHT]}
        model = varied(model, changes | {"boundaries.2.at": size})
    load, shape = model.loads[0], model.bodies[0].shape
    assert isinstance(load, BodyForce)
    assert isinstance(shape, Box)
    acceleration = np.array(load.acceleration)
    gravity = float(np.linalg.norm(acceleration))
    up = -acceleration / gravity
    soil = model.materials["soil"]
    assert isinstance(soil, HenckyElastic | VonMises)
    exact = SelfWeightColumn(HEIGHT, gravity, soil)
    width = shape.upper[0] - shape.lower[0]
    weight = exact.base_stress * width
    outcome = Outcome()

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        outcome.position.append(simulation.state.points.position.copy())
        total = result.reaction.sum(axis=0) / (model.load_curve(load).factor(time) * weight)
        error = float(np.linalg.norm(total - up))
        outcome.reaction_error = max(outcome.reaction_error, error)

    points = march(model, after_step).state.points
    xx, yy, xy = points.stress[:, [0, 1, 3]].T
    axial = up[0] ** 2 * xx + up[1] ** 2 * yy + 2.0 * up[0] * up[1] * xy
    elevation = (initial_position(points) - np.array(shape.lower)) @ up
    outcome.stress_error = exact.stress_error(axial, elevation, points.initial_volume)
    return outcome


def placed(model: Model, cells: int, offset: tuple[float, float]) -> Model:
    """Returns the column on this number of cells over its height, one wide.

    offset: of its lower left corner from a grid line, in cells.
    """
    size = HEIGHT / cells
    shape = model.bodies[0].shape
    assert isinstance(shape, Box)
    right = np.array(shape.axes[0])
    changes = {
        "grid.cell_size": size,
        "grid.origin": [-share * size for share in offset],
        "bodies.0.shape.upper": [size, HEIGHT],
        "bodies.0.points": [2, 2 * cells],
        "boundaries.2.geometry.point": (size * right).tolist(),
    }
    return varied(model, changes)


def with_delta(delta: float) -> dict[str, float]:
    """Returns the case-file changes for a band of this width [length] at all three boundaries."""
    return {f"boundaries.{i}.delta": delta for i in range(3)}
