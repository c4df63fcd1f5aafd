# SPDX-License-Identifier: BSD-3-Clause
"""Rigid footing pressed deep into an elastic square, all boundaries implicit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.comparison import Comparison, relative, vanishing
from tilth_verification.reference import FootingCurve, rigid_footing_elastic

PROBLEM = "rigid_footing_elastic"
SOURCE = "body-fitted elements"
SIDE = 3.0
GRID_OFFSET = 0.4
"""Distance of base and surface from the next grid line below, in cells."""
TOLERANCE = 0.02
"""Largest error of the force up to 0.3 m [-]."""
LINEAR_POINTS = 6
"""Points per cell and direction of the linear basis; two are too few for cell crossing."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Against the finite elements up to 0.3 m, then on to 1 m, and the edge inside a cell."""
    yield from against_elements(long)
    for basis in BASES:
        if basis != "gimp":  # the one of all other rows
            yield from with_other(basis, long)
    yield from far_down(long)
    yield from edge_in_cell(long)


def against_elements(long: bool) -> Iterator[Comparison]:
    """Force up to 0.3 m, and extrapolated to h = 0, largest error over the curve."""
    model = example(PROBLEM, "narrowing.toml")
    settlement, coarse, _ = press(model, 0.1, 0.3)
    _, fine, _ = press(model, 0.05, 0.3)
    exact = rigid_footing_elastic()
    names = [
        ("h 0.05 m", fine, TOLERANCE),
        ("extrapolated from h 0.1 and 0.05 m", 2 * fine - coarse, 0.01),
    ]
    if long:
        _, finest, _ = press(model, 0.025, 0.3)
        names += [("h 0.025 m", finest, 0.015)]
    for name, force, tolerance in names:
        yield worst_of_curve(name, settlement, force, exact, tolerance)
    rigid = varied(model, {"boundaries.3.motion": None, "boundaries.3.displacement": {"y": -0.025}})
    settlement, force, _ = press(varied(rigid, {"schedule.steps": 1}), 0.05, 0.025)
    value = float(np.interp(settlement[-1], exact.settlement, exact.force))
    quantity = "force / E at 0.025 m, face of constant width, h 0.05 m"
    yield relative(quantity, force[-1], value, 0.02, SOURCE, "m")


def with_other(basis: str, long: bool) -> Iterator[Comparison]:
    """Force up to 0.3 m with another basis, largest error over the curve: h 0.1, long 0.05 m."""
    model = with_basis(example(PROBLEM, "narrowing.toml"), basis)
    points = LINEAR_POINTS if basis == "linear" else 2
    exact = rigid_footing_elastic()
    for h in (0.1, 0.05) if long else (0.1,):
        settlement, force, _ = press(model, h, 0.3, points=points)
        yield worst_of_curve(f"{basis}, h {h:g} m", settlement, force, exact, TOLERANCE)


def worst_of_curve(
    at: str, settlement: Floats, force: Floats, exact: FootingCurve, tolerance: float
) -> Comparison:
    """Returns a row: the force at its largest error."""
    reference = np.interp(settlement, exact.settlement, exact.force)
    worst = int(np.abs(force / reference - 1.0).argmax())
    quantity = f"force / E at {settlement[worst]:.3g} m, the worst of the curve, {at}"
    return relative(quantity, force[worst], reference[worst], tolerance, SOURCE, "m")


def far_down(long: bool) -> Iterator[Comparison]:
    """A block with a smooth side, pushed to 1 m: no reference, two grids, and no penetration."""
    model = example(PROBLEM)
    sizes = (0.1, 0.05) if long else (0.15, 0.1)
    (settlement, coarse, _), (_, fine, depth) = (press(model, h, 1.0) for h in sizes)
    worst = int(np.abs(coarse / fine - 1.0)[settlement > 0.3].argmax()) + int(
        (settlement <= 0.3).sum()
    )
    at = f"force / E at {settlement[worst]:.3g} m, h {sizes[0]:g} and {sizes[1]:g} m"
    yield relative(at, coarse[worst], fine[worst], 0.05, "the finer grid", "m")
    quantity = f"deepest point behind the block's face, h {sizes[1]:g} m, in cells"
    yield vanishing(quantity, depth / sizes[1], 0.03, "nothing passes through the face")


def edge_in_cell(long: bool) -> Iterator[Comparison]:
    """The face's edge at ten positions across a cell: a condition on a part acts on all its nodes.

    Its way is less than half a cell (decision 47). The spread is first order in the size of the
    cell; a grid that follows the edge has none.
    """
    model = varied(
        example(PROBLEM, "narrowing.toml"),
        {
            "boundaries.3.motion": None,
            "boundaries.3.displacement": {"y": -0.02},
            "schedule.steps": 1,
            "schedule.outputs": 1,
        },
    )
    fixed = varied(model, {"grid.follow": None})
    spread = {h: spread_over_a_cell(fixed, h) for h in ((0.1, 0.05) if long else (0.2, 0.1))}
    coarse, fine = spread
    quantity = f"spread of the force over ten edge positions, h {fine:g} m"
    yield vanishing(quantity, spread[fine], 0.5 * fine, "at most half a cell of width")
    quantity = f"spread at h {coarse:g} over that at {fine:g} m"
    yield relative(quantity, spread[coarse] / spread[fine], 2.0, 0.25, "first order")
    quantity = f"the same with a grid that follows the edge, h {coarse:g} m"
    # the declared origin also determines the other boundaries' quadrature points
    yield vanishing(quantity, spread_over_a_cell(model, coarse), 1e-6, "no edge inside a cell")


def spread_over_a_cell(model: Model, h: float) -> float:
    """Returns (greatest - least) / mean force of ten positions of the grid along x."""
    forces = []
    for share in np.arange(10) / 10.0:
        _, force, _ = press(model, h, 0.02, share)
        forces.append(force[-1])
    return float(np.ptp(forces) / np.mean(forces))


def press(
    model: Model, h: float, end: float, share: float = 0.0, points: int = 2
) -> tuple[Floats, Floats, float]:
    """Presses the footing to the settlement `end` on cells of about `h` [m].

    share: distance of its edge from the grid line below, in cells, unless the grid follows it.
    points: material points per cell and direction.

    Returns the settlements [m], the forces over Young's modulus [m], and the greatest depth of a
    material point in the footing at the end [m].
    """
    width = 1.024 * h  # neither 1 m nor 3 m is a multiple of it
    changes: dict[str, Any] = {
        "grid.cell_size": [width, h],
        "grid.origin": [1.0 - share * width, -GRID_OFFSET * h],
        "bodies.0.points": [points * round(SIDE / h)] * 2,
    }
    model = varied(model, changes)
    rows: list[tuple[float, float]] = []
    young_modulus = model.materials["soil"].parameter("young_modulus")

    schedule = model.schedule
    regular = {schedule.regular_time(k) for k in range(1, schedule.number_of_steps + 1)}

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        if time not in regular:  # of a step that was cut
            return
        rows.append((time * end, -result.resultant("footing")[1] / young_modulus))

    simulation = march(model, after_step)
    footing = next(b for b in simulation.state.implicit if b.name == "footing")
    depth = footing.penetration(simulation.state.points.position, model.schedule.end)
    settlement, force = np.array(rows).T
    return settlement, force, depth
