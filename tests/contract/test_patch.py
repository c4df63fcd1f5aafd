# SPDX-License-Identifier: BSD-3-Clause
"""Patch tests: homogeneous states are exact for every kind and basis."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, logm
from small_problems import (
    AXES,
    BASES,
    KINDS,
    POINT_MATERIALS,
    SPACINGS,
    affine,
    block_entries,
    by_number,
    dimension,
    jittered_points,
    plane,
    principal_update,
    spaced,
    tensor,
)

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.grid.background import Grid, background_grid
from tilth.mpm.initial_points import initial_points

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
every_spacing = pytest.mark.parametrize("spacing", SPACINGS)
every_method = pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
every_material = pytest.mark.parametrize("material", POINT_MATERIALS)

CELLS = 3


def full(kind: str, gradient: Floats) -> Floats:
    """The 3x3 deformation gradient of an in-plane or 3D one."""
    whole = np.eye(3)
    whole[: len(gradient), : len(gradient)] = gradient
    if kind == "axisymmetric":
        whole[2, 2] = gradient[0, 0]
    return whole


def hencky_stress(gradient: Floats) -> Floats:
    """Cauchy stress [3, 3] of Hencky elasticity, E = 1000, nu = 0.3: tau / det F."""
    strain = 0.5 * logm(gradient @ gradient.T).real
    lame, shear = 1000.0 * 0.3 / (1.3 * 0.4), 1000.0 / 2.6
    return np.asarray(
        (lame * np.trace(strain) * np.eye(3) + 2 * shear * strain) / np.linalg.det(gradient)
    )


def outer_nodes(dim: int) -> list[tuple[int, ...]]:
    return [
        node
        for node in product(range(CELLS + 1), repeat=dim)
        if any(place in (0, CELLS) for place in node)
    ]


def held_on_the_outside(grid: Grid, gradient: Floats) -> list[dict[str, Any]]:
    """The affine motion prescribed node by node on the surface of the block."""
    shift = gradient - np.eye(len(gradient))
    conditions = []
    for node in outer_nodes(len(gradient)):
        place = grid.position(np.array(node, dtype=float))
        value = shift @ place
        conditions.append(
            {
                "type": "node",
                "name": f"node {node}",
                "at": place.tolist(),
                "condition": "prescribed",
                "displacement": dict(zip(AXES, value.tolist(), strict=False)),
            }
        )
    return conditions


def large_gradient(kind: str) -> Floats:
    """30 % stretch with shear; in axisymmetry the homogeneous one with F_rr = F_tt."""
    if kind == "axisymmetric":
        return np.diag([1.3, 0.8])
    whole = np.array([[1.3, 0.25, 0.1], [-0.05, 0.85, 0.2], [0.15, -0.1, 1.1]])
    return whole[: dimension(kind), : dimension(kind)]


@every_kind
@every_basis
@every_spacing
@every_method
def test_first_step_from_aligned_points(
    kind: str, basis: str, spacing: str, anti_locking: str
) -> None:
    """Surface nodes moved affinely, inner nodes free: the stress is the same everywhere."""
    gradient = large_gradient(kind)
    entries = spaced(block_entries(kind, basis, cells=CELLS), spacing)
    entries["bodies"][0]["anti_locking"] = anti_locking
    grid = background_grid(Model.from_dict(entries))
    entries["boundaries"] = held_on_the_outside(grid, gradient)
    entries["analysis"]["tolerance"] = 1e-13
    simulation = Simulation(Model.from_dict(entries))
    active = simulation.check()
    assert active.nodes == (CELLS + 1) ** dimension(kind)
    result = simulation.advance(0.0, 1.0)
    assert result.equilibrium.residuals[1] < 1e-10  # the first prediction is homogeneous already
    exact = active.position @ (gradient - np.eye(len(gradient))).T
    np.testing.assert_allclose(result.equilibrium.displacement, exact, rtol=0, atol=1e-12)
    stress = hencky_stress(full(kind, gradient))
    found = tensor(simulation.state.points.stress)
    scale = np.abs(stress).max()
    np.testing.assert_allclose(
        found, np.broadcast_to(stress, found.shape), rtol=0, atol=3e-12 * scale
    )


@every_kind
@every_basis
@every_material
@every_spacing
def test_first_step_between_moving_planes(
    kind: str, basis: str, material: str, spacing: str
) -> None:
    """Planes at a prescribed distance, free to slide along: a homogeneous stretch in one step."""
    dim = dimension(kind)
    stretch = np.array([1.3, 0.75, 1.1])[:dim]
    if kind == "axisymmetric":
        stretch = np.array([1.2, 0.75])
    boundaries = []
    for k in range(dim):
        boundaries.append(plane(f"low {AXES[k]}", AXES[k], 0.0))
        boundaries.append(
            plane(
                f"high {AXES[k]}", AXES[k], float(CELLS), condition="prescribed",
                displacement={AXES[k]: CELLS * (stretch[k] - 1.0)},
            )
        )  # fmt: skip
    entries = block_entries(kind, basis, material, cells=CELLS, boundaries=boundaries)
    entries["analysis"]["tolerance"] = 1e-13
    simulation = Simulation(Model.from_dict(spaced(entries, spacing)))
    result = simulation.advance(0.0, 1.0)
    exact = result.active.position * (stretch - 1.0)
    np.testing.assert_allclose(result.equilibrium.displacement, exact, rtol=0, atol=1e-12)
    stress = simulation.state.points.stress
    assert np.ptp(stress, axis=0).max() < 3e-12 * np.abs(stress).max()
    stretches = np.diag(full(kind, np.diag(stretch)))
    expected = principal_update(material, np.log(stretches))[0] / stretches.prod()
    np.testing.assert_allclose(tensor(stress[0]), np.diag(expected), rtol=0, atol=1e-9)
    # the plane's reaction is the Cauchy stress times the deformed area
    if kind != "axisymmetric":
        last = dim - 1
        area = np.prod(np.delete(stretch, last)) * CELLS ** (dim - 1)
        force = result.resultant(f"high {AXES[last]}")[last]
        assert force == pytest.approx(stress[0, last] * area, rel=1e-11)
    else:
        force = result.resultant("high y")[1]
        area = np.pi * (CELLS * stretch[0]) ** 2
        assert force == pytest.approx(stress[0, 1] * area, rel=1e-11)


@pytest.mark.slow
@every_kind
@every_basis
@every_spacing
@pytest.mark.parametrize("path", ["linear", "exponential"])
def test_affine_drive_over_many_steps(kind: str, basis: str, spacing: str, path: str) -> None:
    """Irregular points cross many cells: F, positions and stress stay those of the drive."""
    dim = dimension(kind)
    end = np.array([[1.8, 1.0, -0.4], [0.3, 1.4, 0.5], [-0.2, 0.2, 0.7]])[:dim, :dim]
    if kind == "axisymmetric":
        end = np.diag([2.0, 0.6])
    steps = 25
    entries = block_entries(kind, basis, boundaries=[affine(end, path)], schedule={"steps": steps})
    entries["grid"] = {"cell_size": [0.25, 0.2, 0.3][:dim], "origin": [0.0, -0.03, 0.1][:dim]}
    if spacing == "graded":
        fine_inside = {
            "x": [[0.0, 0.35], [1.0, 0.2], [1.4, 0.2], [3.5, 0.35]],
            "y": [[-1.5, 0.35], [-0.4, 0.24], [1.0, 0.3]],
            "z": [[-1.2, 0.25], [0.7, 0.4]],
        }
        entries["grid"] = {"cell_size": {axis: fine_inside[axis] for axis in AXES[:dim]}}
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["points"] = [5] * dim
    body["shape"] = {
        "type": "box",
        "lower": [0.4, -1.0, -1.0][:dim],
        "upper": [1.6, 0.5, 0.5][:dim],
    }
    model = Model.from_dict(entries)
    points = jittered_points(model, np.random.default_rng(0), 0.9)
    start = points.position.copy()
    grid = background_grid(model)
    cells_before = np.floor(grid.in_cells(start))
    simulation = Simulation(model, points)
    for k in range(steps):
        simulation.advance(k / steps, (k + 1) / steps)
        factor = (k + 1) / steps
        if path == "linear":
            gradient = np.eye(dim) + factor * (end - np.eye(dim))
        else:
            gradient = expm(factor * logm(end).real)
        whole = full(kind, gradient)
        found = by_number(simulation.state.points)
        assert np.abs(found["deformation_gradient"] - whole).max() < 1e-12
    np.testing.assert_allclose(found["position"], start @ gradient.T, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        found["displacement"], start @ (gradient - np.eye(dim)).T, rtol=0, atol=1e-12
    )
    stress = hencky_stress(whole)
    error = np.abs(tensor(found["stress"]) - stress).max() / np.abs(stress).max()
    assert error < 1e-10
    cells_after = np.floor(grid.in_cells(found["position"]))
    assert np.abs(cells_after - cells_before).max() >= 3


@pytest.mark.slow
@every_kind
@every_basis
@every_material
@every_spacing
def test_affine_drive_keeps_points_of_a_body_alike(
    kind: str, basis: str, material: str, spacing: str
) -> None:
    """Also plastic points go through one and the same history wherever they stand."""
    dim = dimension(kind)
    end = np.diag([1.5, 0.7, 1.2][:dim])
    if kind != "axisymmetric":
        end[0, 1] = 0.8
    entries = block_entries(kind, basis, material, boundaries=[affine(end)], schedule={"steps": 20})
    model = Model.from_dict(spaced(entries, spacing))
    points = jittered_points(model, np.random.default_rng(1), 0.8)
    simulation = Simulation(model, points)
    for k in range(20):
        simulation.advance(k / 20, (k + 1) / 20)
    for name in ("stress", "elastic_strain", "plastic", "deformation_gradient"):
        values = getattr(simulation.state.points, name)
        assert np.ptp(values, axis=0).max() < 1e-11 * max(1.0, np.abs(values).max())
    if material != "hencky_elastic":
        assert simulation.state.points.plastic[0, 0] > 0.2
    if material == "von_mises":
        volume = np.exp(simulation.state.points.elastic_strain[:, :3].sum(axis=1))
        whole = np.linalg.det(simulation.state.points.deformation_gradient)
        np.testing.assert_allclose(volume, whole, rtol=1e-12)  # flow keeps the volume


@every_kind
@every_spacing
def test_points_fill_the_block(kind: str, spacing: str) -> None:
    """The patch tests rest on this: volumes sum to the body's."""
    entries = spaced(block_entries(kind, "gimp", cells=CELLS), spacing)
    points = initial_points(Model.from_dict(entries))
    exact = CELLS ** dimension(kind) if kind != "axisymmetric" else np.pi * CELLS**3
    assert points.initial_volume.sum() == pytest.approx(exact, rel=1e-14)
