# SPDX-License-Identifier: BSD-3-Clause
"""A thick cylinder widened from inside by little, against Lame's solution, and its core."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import Box, HenckyElastic, Model, PlaneBoundary
from tilth_verification import widened_cylinder
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.closed_forms import ThickCylinder, hencky_cauchy_stress
from tilth_verification.comparison import Comparison, absolute, relative, vanishing

SOURCE = "Lame's closed form"
UNIFORM = "uniform strain"


@dataclass(frozen=True)
class Outcome:
    """Results of a cylinder.

    Attributes:
        displacement_error, stress_error: relative, in the mean square of the points [-].
        pressure, exact_pressure: on the inner wall [stress].
        displacement, stress: of the points in the order of their numbers, radial (n,) and the
            normal components (n, 3), times the square root of the initial volume.
    """

    displacement_error: float
    stress_error: float
    pressure: float
    exact_pressure: float
    displacement: Floats
    stress: Floats

    @property
    def pressure_error(self) -> float:
        """Relative error of the pressure."""
        return abs(self.pressure / self.exact_pressure - 1.0)


def comparisons(long: bool) -> Iterator[Comparison]:
    """Errors and their rates with every basis; a solid cylinder; then a large widening.

    Two points per cell whose domains end at the grid lines make all bases equal to the linear one;
    with five on two cells every other grid line cuts the domain of a point.
    """
    grids = (8, 16, 32, 64) if long else (16, 32)
    for basis in BASES:
        model = with_basis(example("thick_cylinder"), basis)
        straddling = basis != "linear"
        outcomes = [solve(model, cells, straddling) for cells in grids]
        for cells, outcome in zip(grids, outcomes, strict=True):
            at = f"{basis}, {cells} cells"
            pair = (outcome.pressure, outcome.exact_pressure)
            yield relative(f"inner pressure, {at}", *pair, 0.14 / cells**2, SOURCE, "Pa")
            error = outcome.displacement_error
            yield vanishing(f"displacement error, {at}", error, 0.12 / cells**2, SOURCE)
            yield vanishing(f"stress error, {at}", outcome.stress_error, 0.64 / cells, SOURCE)
        for name, order in (("displacement", 2.0), ("stress", 1.0), ("pressure", 2.0)):
            errors = [getattr(outcome, f"{name}_error") for outcome in outcomes]
            rate = math.log2(errors[0] / errors[-1]) / math.log2(grids[-1] / grids[0])
            quantity = f"convergence rate of the {name}, {basis}, {grids[0]} to {grids[-1]} cells"
            yield absolute(quantity, rate, order, 0.15, "bilinear elements")
        if basis in ("linear", "gimp"):
            yield from assumed_strain(basis, model, grids[-2:] if long else grids[-1:])
        else:
            yield rate_with_assumed_strain(basis, model, grids[-2:])
        if straddling:
            for cells in (8, 32):
                yield from solid_cylinder(basis, cells)
        yield from on_a_graded_grid(basis, model)
    yield from widened_cylinder.comparisons(long)


def on_a_graded_grid(basis: str, model: Model) -> Iterator[Comparison]:
    """Cells twice as large outside as inside: no larger errors, and the same rates."""
    grids, straddling = (16, 32), basis != "linear"
    outcomes = [outcome_of(graded(model, n, straddling), straddling) for n in grids]
    for cells, outcome in zip(grids, outcomes, strict=True):
        at, error = f"{basis}, {cells} graded cells", outcome.displacement_error
        pair = (outcome.pressure, outcome.exact_pressure)
        yield relative(f"inner pressure, {at}", *pair, 0.14 / cells**2, SOURCE, "Pa")
        yield vanishing(f"displacement error, {at}", error, 0.12 / cells**2, SOURCE)
        yield vanishing(f"stress error, {at}", outcome.stress_error, 0.64 / cells, SOURCE)
    for name, order in (("displacement", 2.0), ("stress", 1.0)):
        coarse, fine = (getattr(outcome, f"{name}_error") for outcome in outcomes)
        quantity = f"convergence rate of the {name}, {basis}, 16 to 32 graded cells"
        yield absolute(quantity, math.log2(coarse / fine), order, 0.15, "bilinear elements")


def solid_cylinder(basis: str, cells: int) -> Iterator[Comparison]:
    """The core that the wall encloses, moved by the same face: u = u_a r / a, up to the axis.

    With r_p the middle of a domain from r_1 to r_2, CPDI's force of a uniform stress on a node is
    r_p (N_2 - N_1) + (r_2 - r_1) (N_1 + N_2) / 2 = r_2 N_2 - r_1 N_1, and these differences cancel
    from domain to domain. GIMP has the mean of N for (N_1 + N_2) / 2, which differs where a grid
    line cuts the domain.
    """
    model = with_basis(example("thick_cylinder"), basis)
    displacement_error, stress_error = solve_solid(model, cells)
    at = f"solid cylinder, {basis}, {cells} cells"
    displacement, stress = (0.12 / cells**2, 0.03) if basis == "gimp" else (1e-8, 1e-8)
    yield vanishing(f"displacement error, {at}", displacement_error, displacement, UNIFORM)
    yield vanishing(f"largest stress error, {at}", stress_error, stress, UNIFORM)


def assumed_strain(basis: str, model: Model, grids: Sequence[int]) -> Iterator[Comparison]:
    """F-bar, not needed at nu 0.3, changes less than the grid's own error.

    The inner pressure with GIMP is left out: its error is six times smaller with F-bar and of the
    other sign, so that their difference is larger than either error.
    """
    for cells in grids:
        without, with_it = (
            solve(varied(model, {"bodies.0.anti_locking": method}), cells, basis == "gimp")
            for method in ("none", "f_bar")
        )
        source = "the error without"
        for name in ("displacement", "stress"):
            one, other = getattr(without, name), getattr(with_it, name)
            change = math.sqrt(((other - one) ** 2).sum() / (one**2).sum())
            quantity = f"{name}, {basis}, {cells} cells, change by F-bar"
            yield vanishing(quantity, change, getattr(without, f"{name}_error"), source)
        if basis == "linear":
            change = abs(with_it.pressure - without.pressure) / without.exact_pressure
            quantity = f"inner pressure, {basis}, {cells} cells, change by F-bar"
            yield vanishing(quantity, change, without.pressure_error, source)


def rate_with_assumed_strain(basis: str, model: Model, grids: Sequence[int]) -> Comparison:
    """Returns a row: the rate of the displacement with F-bar and domains with corners."""
    assumed = varied(model, {"bodies.0.anti_locking": "f_bar"})
    coarse, fine = (solve(assumed, cells, True).displacement_error for cells in grids)
    at = f"{basis}, F-bar, {grids[0]} to {grids[1]} cells"
    quantity = f"convergence rate of the displacement, {at}"
    return absolute(quantity, math.log2(coarse / fine), 2.0, 0.15, "bilinear elements")


def solve(model: Model, cells: int, straddling: bool = False) -> Outcome:
    """Returns the outcome of the cylinder on this number of cells over its wall, one high.

    straddling: two cells high, with five points on two cells in both directions.
    """
    box = model.bodies[0].shape
    assert isinstance(box, Box)
    return outcome_of(divided(model, box.lower[0], box.upper[0], cells, straddling), straddling)


def outcome_of(model: Model, straddling: bool = False) -> Outcome:
    """Returns the outcome of the cylinder as it is; straddling: two cells high, not one."""
    box, inner, material = model.bodies[0].shape, model.boundaries[0], model.materials["steel"]
    assert isinstance(box, Box)
    assert isinstance(inner, PlaneBoundary)
    assert inner.displacement is not None
    assert isinstance(material, HenckyElastic)
    a, b = box.lower[0], box.upper[0]
    pressure = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        height = simulation.state.grid.cell_size[1] * (2.0 if straddling else 1.0)
        pressure.append(result.resultant(inner.name)[0] / (2.0 * math.pi * a * height))

    points = march(model, after_step).state.points
    exact = ThickCylinder(a, b, inner.displacement["x"], material)
    radius, volume = initial_position(points)[:, 0], points.initial_volume
    displacement, stress = exact.radial_displacement(radius), exact.stress(radius)
    squared_error = (
        (points.displacement[:, 0] - displacement) ** 2 @ volume / (displacement**2 @ volume)
    )
    squared_stress_error = ((points.stress[:, :3] - stress) ** 2).sum(axis=1) @ volume
    order = np.argsort(points.point_id)
    return Outcome(
        displacement_error=math.sqrt(squared_error),
        stress_error=math.sqrt(squared_stress_error / ((stress**2).sum(axis=1) @ volume)),
        pressure=float(pressure[-1]),
        exact_pressure=exact.pressure,
        displacement=points.displacement[order, 0] * np.sqrt(volume[order]),
        stress=points.stress[order, :3] * np.sqrt(volume[order])[:, None],
    )


def solve_solid(model: Model, cells: int) -> tuple[float, float]:
    """Solves the core of the cylinder with its axis constrained, on so many cells over its radius.

    Returns:
        Relative errors of the displacement, in the mean square of the points, and of the stress,
        the largest [-].
    """
    inner, material = model.boundaries[0], model.materials["steel"]
    assert isinstance(inner, PlaneBoundary)
    assert inner.displacement is not None
    assert isinstance(material, HenckyElastic)
    entries = divided(model, 0.0, inner.at, cells, straddling=True).to_dict()
    entries["boundaries"].append(
        {"name": "centre", "type": "plane", "axis": "x", "at": 0.0, "condition": "roller"}
    )
    points = march(Model.from_dict(entries), lambda *_: None).state.points
    strain = inner.displacement["x"] / inner.at
    displacement = strain * initial_position(points)[:, 0]
    stretch = np.diag([1.0 + strain, 1.0, 1.0 + strain])
    stress = np.diag(hencky_cauchy_stress(stretch, material))
    squared_error = (points.displacement[:, 0] - displacement) ** 2 @ points.initial_volume
    stress_error = np.abs(points.stress[:, :3] - stress).max()
    return (
        math.sqrt(squared_error / (displacement**2 @ points.initial_volume)),
        float(stress_error / np.abs(stress).max()),
    )


def divided(model: Model, inner: float, outer: float, cells: int, straddling: bool) -> Model:
    """Returns the model between two radii, this many cells between them, one or two high."""
    size = (outer - inner) / cells
    height = 2.0 * size if straddling else size
    changes: dict[str, Any] = {
        "grid.cell_size": size,
        "bodies.0.shape.lower": [inner, 0.0],
        "bodies.0.shape.upper": [outer, height],
        "boundaries.2.at": height,
    }
    if straddling:
        changes |= {"bodies.0.points_per_cell": None, "bodies.0.points": [5 * cells // 2, 5]}
    return varied(model, changes)


def graded(model: Model, cells: int, straddling: bool) -> Model:
    """Returns the wall on this number of cells whose sizes grow from 0.7 to 1.4 of their mean."""
    uniform = divided(model, 1.0, 2.0, cells, straddling)
    size = 1.0 / cells
    sizes = {"x": [[1.0, 0.7 * size], [2.0, 1.4 * size]], "y": size}
    return varied(uniform, {"grid.cell_size": sizes})
