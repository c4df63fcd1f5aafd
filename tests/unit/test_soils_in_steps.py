# SPDX-License-Identifier: BSD-3-Clause
"""Frictional and critical-state soils in whole steps: bases, F-bar, boundaries, softening."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import BASES, KINDS, block_entries, dimension, material_entries, plane

from tilth import Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats

SOILS: dict[str, dict[str, Any]] = {
    "mohr_coulomb": {"dilation_angle": 20.0},
    "modified_cam_clay": {"overconsolidation_ratio": 1.5, "preconsolidation_pressure": None},
}


def between_plates(kind: str, basis: str, law: str) -> Model:
    """A block with F-bar between rough plates off the grid's lines, with the stress of the law."""
    dim = dimension(kind)
    up = np.eye(dim)[dim - 1]
    entries = block_entries(kind, basis, law)
    entries["materials"]["soil"] = material_entries(law, **SOILS[law])
    entries["bodies"][0]["anti_locking"] = "f_bar"
    entries["grid"] = {"cell_size": 0.5, "origin": [-0.5 * 0.37] * dim}
    if kind == "axisymmetric":
        entries["grid"]["origin"][0] = 0.0
    side = [
        implicit(f"side {k}", flat(2.0 * np.eye(dim)[k], -np.eye(dim)[k])) for k in range(dim - 1)
    ]
    inner = [implicit(f"inner {k}", flat(np.zeros(dim), np.eye(dim)[k])) for k in range(dim - 1)]
    entries["boundaries"] = [
        implicit("base", flat(np.zeros(dim), up), "fixed"),
        implicit("top", flat(2.0 * up, -up), "fixed", displacement={"xyz"[dim - 1]: -0.3}),
        *(inner if kind != "axisymmetric" else []),
        *(side if law == "modified_cam_clay" else side[1:]),
    ]
    entries["schedule"] = {"steps": 4, "outputs": 1, "adaptive": False}
    return Model.from_dict(entries)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("law", list(SOILS))
def test_soils_between_implicit_boundaries_with_f_bar(kind: str, basis: str, law: str) -> None:
    """Four steps without a cut; both plates carry the same force."""
    counts, forces = [], []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        counts.append(result.equilibrium.iterations)
        up = dimension(kind) - 1
        forces.append([result.resultant(name)[up] for name in ("base", "top")])

    simulation = march(between_plates(kind, basis, law), after_step)
    assert max(counts) <= 20
    base, top = np.array(forces).T
    np.testing.assert_allclose(base, -top, rtol=1e-6)
    assert (simulation.state.points.plastic[:, 0] > 1e-4).any()
    assert np.isfinite(simulation.state.points.stress).all()


@pytest.mark.slow
@pytest.mark.parametrize("law", list(SOILS))
def test_soils_with_multigrid(law: str) -> None:
    """The unsymmetric systems of soils: the same displacements as with a direct solver."""
    shifts = []
    for solver in ("multigrid", "superlu"):
        entries = between_plates("3d", "linear", law).to_dict()
        entries["analysis"]["solver"] = solver
        simulation = march(Model.from_dict(entries))
        assert solver in simulation.services.solver.summary.lower() or solver == "superlu"
        points = simulation.state.points
        shifts.append(points.displacement[points.index_of(np.arange(len(points)))])
    np.testing.assert_allclose(*shifts, rtol=0, atol=1e-7)


# --- softening --------------------------------------------------------------------------------


def sheared_column(cells: int, length: float) -> tuple[Floats, Floats]:
    """Displacement and force of a column sheared at its top, weaker in one cell; height 1."""
    size = 1.0 / cells
    strong = material_entries(
        "mohr_coulomb", young_modulus=5e5, friction_angle=0.0, dilation_angle=0.0, cohesion=20.0,
        residual_cohesion=10.0, softening_strain=1e-3, softening_length=length,
    )  # fmt: skip
    entries = block_entries("plane_strain", "linear", cells=1)
    entries["grid"]["cell_size"] = size
    entries["materials"] = {"strong": strong, "weak": {**strong, "cohesion": 19.0}}
    body = entries["bodies"][0]
    del body["material"]
    body["shape"]["upper"] = [size, 1.0]
    middle = (cells // 2) * size
    body["layers"] = [
        {"material": "strong", "bottom": middle + size},
        {"material": "weak", "bottom": middle},
        {"material": "strong"},
    ]
    # no vertical motion anywhere: each row of cells shears by itself
    entries["boundaries"] = [
        plane("base", "y", 0.0, condition="fixed"),
        plane("top", "y", 1.0, condition="prescribed", displacement={"x": 3e-4, "y": 0.0}),
        *(
            plane(f"side {at}", "x", at, condition="prescribed", displacement={"y": 0.0})
            for at in (0.0, size)
        ),
    ]
    entries["schedule"] = {"steps": 60, "outputs": 1}
    rows = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        rows.append((3e-4 * time, result.resultant("top")[0] / size))

    march(Model.from_dict(entries), after_step)
    displacement, force = np.array(rows).T
    return displacement, force


def test_softening_is_the_same_on_two_grids() -> None:
    """Force over displacement of a shear band of one cell, on cells of 1/5 and 1/15.

    Without the length the finer column would lose its strength three times as fast.
    """
    length = 0.2
    displacement, coarse = sheared_column(5, length)
    fine = np.interp(displacement, *sheared_column(15, length))
    assert coarse.max() == pytest.approx(19.0, rel=0.02)
    assert coarse[-1] < 0.8 * coarse.max()
    np.testing.assert_allclose(fine, coarse, rtol=0, atol=0.03 * coarse.max())
