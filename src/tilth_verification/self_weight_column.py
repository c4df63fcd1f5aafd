# SPDX-License-Identifier: BSD-3-Clause
"""A column compressed to half its height by its own weight, against its closed form."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import get_args

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.model import BodyForce, HenckyElastic, Model, VonMises
from tilth.model.bodies import DomainUpdate
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import SelfWeightColumn
from tilth_verification.comparison import (
    Comparison,
    at_least,
    relative,
    vanishing,
    within_factor,
)
from tilth_verification.convergence import log_slope
from tilth_verification.reference import AMPLE_COLUMN_ERROR

PROBLEM = "self_weight_column"
HEIGHT = 50.0
WITHOUT_GHOST = {"analysis.ghost_stabilisation": 0.0}
AMPLE = "AMPLE, figure"
CLOSED_FORM = "closed form"
GIMP = "GIMP, right_stretch"
BASES: dict[str, dict[str, str | None]] = {
    "linear": {"bodies.0.basis": "linear", "bodies.0.domain_update": None},
    **{f"GIMP, {rule}": {"bodies.0.domain_update": rule} for rule in get_args(DomainUpdate)},
    "CPDI1": {"bodies.0.basis": "cpdi1", "bodies.0.domain_update": None},
    "CPDI2": {"bodies.0.basis": "cpdi2", "bodies.0.domain_update": None},
}
"""Name of a basis, with the rule for its domains where it has one -> changes of the case file."""


@dataclass(frozen=True)
class Outcome:
    """Results of a column: errors relative to the base stress [-], heights [length]."""

    stress_error: float
    lateral_error: float
    plastic_strain_error: float
    height: float
    exact_height: float


def comparisons(long: bool) -> Iterator[Comparison]:
    """Elastic (soft and stiff), von Mises, standard MPM, axisymmetric and 3D.

    AMPLE has no ghost stabilisation; where its numbers are the reference there is none.
    """
    plane_strain = varied(example(PROBLEM), WITHOUT_GHOST)
    grids = [4, 8, 16, 32, 64] + ([128, 256, 8192] if long else [])
    errors = {}
    for cells in grids:
        outcome = solve(plane_strain, cells)
        errors[cells] = outcome.stress_error
        quantity = f"vertical stress error, {cells} cells"
        yield within_factor(quantity, errors[cells], AMPLE_COLUMN_ERROR[cells], 1.5, AMPLE)
        if cells == 64:
            quantity = "vertical stress error, 64 cells, as run"
            yield relative(quantity, errors[64], 4.357e-4, 0.01, "AMPLE 1.1, run")
            yield height("final height, 64 cells", outcome)
            yield from stabilised(outcome)
    for coarse, fine in ((4, 32), (256, 8192)) if long else ((4, 32),):
        rate, published = (
            log_slope(e[coarse], e[fine], fine / coarse) for e in (errors, AMPLE_COLUMN_ERROR)
        )
        quantity = f"convergence rate, {coarse} to {fine} cells"
        yield relative(quantity, rate, published, 0.05, AMPLE)
    yield from stiff(plane_strain)
    yield from standard(plane_strain, long)
    yield from other_kinds(solve(plane_strain, 16).stress_error)
    yield from von_mises(long)
    yield from assumed_strain(long)
    yield from every_basis(long)
    yield from graded()


def graded() -> Iterator[Comparison]:
    """Cells twice as large at one end as at the other: errors and rate as on a uniform grid."""
    for name in (GIMP, "CPDI1", "CPDI2"):
        model = varied(example(PROBLEM), BASES[name])
        uniform = {cells: solve(model, cells).stress_error for cells in (8, 64)}
        for end, (low, high) in (("base", (0.7, 1.4)), ("top", (1.4, 0.7))):
            errors = {}
            for cells in (8, 64):
                size = HEIGHT / cells
                sizes = {"x": size, "y": [[0.0, low * size], [HEIGHT, high * size]]}
                on_grid = varied(with_cells(model, cells), {"grid.cell_size": sizes})
                errors[cells] = outcome_of(on_grid).stress_error
            quantity = f"vertical stress error, {name}, 64 cells, small at the {end}"
            yield within_factor(quantity, errors[64], uniform[64], 1.7, "equal cells")
            rate, expected = (log_slope(e[8], e[64], 8.0) for e in (errors, uniform))
            quantity = f"convergence rate, {name}, 8 to 64 cells, small at the {end}"
            yield relative(quantity, rate, expected, 0.15, "equal cells")


def stabilised(without: Outcome) -> Iterator[Comparison]:
    """Ghost stabilisation, on by default, changes less than the grid's own error."""
    outcome = solve(example(PROBLEM), 64)
    quantity = "vertical stress error, 64 cells, ghost stabilisation"
    yield within_factor(quantity, outcome.stress_error, without.stress_error, 1.5, "without")
    yield height("final height, 64 cells, ghost stabilisation", outcome)


def stiff(model: Model) -> Iterator[Comparison]:
    """The column of AMPLE's web page, a hundred times stiffer."""
    outcome = solve(varied(model, {"materials.soil.young_modulus": 1e6}), 64)
    yield height("final height, E 1 MPa, 64 cells", outcome)


def standard(model: Model, long: bool) -> Iterator[Comparison]:
    """Standard MPM: its error remains between 6e-2 and 1e-1 on all grids."""
    linear = varied(model, {"bodies.0.basis": "linear", "bodies.0.domain_update": None})
    for cells in (8, 64, 256) if long else (8, 64):
        error = solve(linear, cells).stress_error
        quantity = f"vertical stress error, standard MPM, {cells} cells"
        band = math.sqrt(0.06 * 0.1), math.sqrt(0.1 / 0.06)
        yield within_factor(quantity, error, *band, "AMPLE: 0.06 to 0.1")


def other_kinds(plane_strain_error: float) -> Iterator[Comparison]:
    """The same column as a cylinder and as a prism."""
    for file, kind in (("axisymmetric.toml", "axisymmetric"), ("three_dimensional.toml", "3d")):
        outcome = solve(varied(example(PROBLEM, file), WITHOUT_GHOST), 16)
        quantity = f"vertical stress error, {kind}, 16 cells"
        yield relative(quantity, outcome.stress_error, plane_strain_error, 0.005, "plane strain")


def von_mises(long: bool) -> Iterator[Comparison]:
    """The column that yields under its weight."""
    model = example(PROBLEM, "von_mises.toml")
    coarse, fine = solve(model, 16), solve(model, 256 if long else 64)
    cells = "256 cells" if long else "64 cells"
    yield height(f"final height, von Mises, {cells}", fine)
    for name, value in (
        ("vertical stress", fine.stress_error),
        ("lateral stress", fine.lateral_error),
        ("plastic strain", fine.plastic_strain_error),
    ):
        yield vanishing(f"{name} error, von Mises, {cells}", value, 2e-3, CLOSED_FORM)
    rate = log_slope(coarse.stress_error, fine.stress_error, 16.0 if long else 4.0)
    quantity = f"convergence rate, von Mises, 16 to {cells}"
    yield at_least(quantity, rate, 1.0, 0.0, "first order at least")


def assumed_strain(long: bool) -> Iterator[Comparison]:
    """F-bar, not needed here, changes less than the grid's own error.

    In the column that yields both have errors of similar size at different points; there the
    errors are compared.
    """
    for file, kind in (("case.toml", "elastic"), ("von_mises.toml", "von Mises")):
        for cells in (16, 64, 256) if long else (16, 64):
            model = with_cells(example(PROBLEM, file), cells)
            without, with_it = (
                march(varied(model, {"bodies.0.anti_locking": method})).state.points
                for method in ("none", "f_bar")
            )
            volume, exact = without.initial_volume, closed_form(model)
            elevation = initial_position(without)[:, 1]
            of_grid = exact.stress_error(without.stress[:, 1], elevation, volume)
            stress = with_it.stress[with_it.index_of(without.point_id), 1]
            apart = np.abs(stress - without.stress[:, 1]) @ volume
            change = float(apart / (exact.base_stress * volume.sum()))
            if kind == "elastic":
                quantity = f"vertical stress, {kind}, {cells} cells, change by F-bar"
                yield vanishing(quantity, change, of_grid, "the error without")
            else:
                error = exact.stress_error(stress, elevation, volume)
                quantity = f"vertical stress error, {kind}, {cells} cells, F-bar"
                yield vanishing(quantity, error, 1.1 * of_grid, "1.1 times that without")


def every_basis(long: bool) -> Iterator[Comparison]:
    """Other bases: those whose domains fill the material converge, the errors of others stagnate.

    In a compression along the grid's axes four of GIMP's rules are exact, and CPDI's domains are
    the same boxes. Domains of fixed size overlap, those of the determinant overlap and leave gaps.
    """
    grids = [8, 16, 32] + ([64, 128, 256] if long else [])
    errors = {
        name: {64: solve(varied(example(PROBLEM), BASES[name]), 64).stress_error}
        for name in ("linear", "GIMP, fixed", "GIMP, determinant")
    }
    for name in (GIMP, "GIMP, deformation_gradient", "GIMP, left_stretch", "GIMP, corners"):
        model = varied(example(PROBLEM), BASES[name])
        errors[name] = {cells: solve(model, cells).stress_error for cells in grids}
        if name != GIMP:
            for cells in (grids[0], grids[-1]):
                quantity = f"vertical stress error, {name}, {cells} cells"
                yield relative(quantity, errors[name][cells], errors[GIMP][cells], 1e-4, GIMP)
    for name in ("GIMP, fixed", "GIMP, determinant"):
        quantity = f"vertical stress error, {name}, 64 cells"
        bound = 0.25 * errors["linear"][64]
        yield vanishing(quantity, errors[name][64], bound, "a quarter of standard MPM's")
    first, last = grids[0], grids[-1]
    for name in ("CPDI1", "CPDI2"):
        model = varied(example(PROBLEM), BASES[name])
        found = errors[name] = {cells: solve(model, cells).stress_error for cells in grids}
        for cells in grids:
            quantity = f"vertical stress error, {name}, {cells} cells"
            yield vanishing(quantity, found[cells], errors[GIMP][cells], f"at most that of {GIMP}")
        rate, of_gimp = (log_slope(e[first], e[last], last / first) for e in (found, errors[GIMP]))
        quantity = f"convergence rate, {name}, {first} to {last} cells"
        yield relative(quantity, rate, of_gimp, 0.05, GIMP)
        changes = BASES[name] | WITHOUT_GHOST
        plane_strain = solve(varied(example(PROBLEM), changes), 16).stress_error
        for file, kind in (("axisymmetric.toml", "axisymmetric"), ("three_dimensional.toml", "3d")):
            outcome = solve(varied(example(PROBLEM, file), changes), 16)
            quantity = f"vertical stress error, {name}, {kind}, no ghost stabilisation, 16 cells"
            yield relative(quantity, outcome.stress_error, plane_strain, 1e-4, "plane strain")


def height(quantity: str, outcome: Outcome) -> Comparison:
    """Returns a row: the upper edge of the uppermost domain against the closed form."""
    return relative(quantity, outcome.height, outcome.exact_height, 1e-3, CLOSED_FORM, "m")


def solve(model: Model, cells: int) -> Outcome:
    """Returns the outcome of a column on this number of cells over its height, one wide."""
    return outcome_of(with_cells(model, cells))


def outcome_of(model: Model) -> Outcome:
    """Returns the outcome of a column as it is."""
    simulation = march(model)
    points = simulation.state.points
    exact = closed_form(model)
    up = model.dimension - 1
    elevation, volume = initial_position(points)[:, up], points.initial_volume
    lateral = points.stress[:, 0] - exact.lateral_stress(elevation)
    plastic = points.plastic[:, 0] - exact.plastic_strain(elevation)
    return Outcome(
        stress_error=exact.stress_error(points.stress[:, up], elevation, volume),
        lateral_error=float(np.abs(lateral) @ volume / (exact.base_stress * volume.sum())),
        plastic_strain_error=float(np.abs(plastic) @ volume / volume.sum()),
        height=float((points.position[:, up] + points.half_length[:, up]).max()),
        exact_height=exact.final_height,
    )


def closed_form(model: Model) -> SelfWeightColumn:
    """Returns the closed form of a model's column."""
    load = model.loads[0]
    assert isinstance(load, BodyForce)
    soil = model.materials["soil"]
    assert isinstance(soil, HenckyElastic | VonMises)
    return SelfWeightColumn(HEIGHT, -load.acceleration[-1], soil)


def with_cells(model: Model, cells: int) -> Model:
    """Returns the column with cubic cells, and one of them over its width."""
    size = HEIGHT / cells
    width = [size] * (model.dimension - 1)
    changes = {"grid.cell_size": size, "bodies.0.shape.upper": [*width, HEIGHT]}
    for i, boundary in enumerate(model.boundaries):
        if getattr(boundary, "at", 0.0) != 0.0:  # the walls away from the origin
            changes[f"boundaries.{i}.at"] = size
    return varied(model, changes)
