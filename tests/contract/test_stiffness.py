# SPDX-License-Identifier: BSD-3-Clause
"""Stiffness = derivative of the internal force, for every kind, basis and material."""

from __future__ import annotations

import numpy as np
import pytest
from small_problems import (
    BASES,
    KINDS,
    POINT_MATERIALS,
    STEP_MATERIALS,
    Laboratory,
    deformed_laboratory,
)

from tilth.arrays import Floats
from tilth.model.laws import laws

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
every_material = pytest.mark.parametrize("material", POINT_MATERIALS)


def derivative_error(
    laboratory: Laboratory, centre: Floats, direction: Floats, steps: tuple[float, ...]
) -> float:
    """Smallest relative difference of K v and the central difference of the force along v."""
    product = (laboratory.stiffness(centre) @ direction.ravel()).reshape(direction.shape)
    errors = []
    for step in steps:
        above = laboratory.internal_force(centre + step * direction)
        below = laboratory.internal_force(centre - step * direction)
        difference = (above - below) / (2 * step)
        errors.append(np.linalg.norm(difference - product) / np.linalg.norm(product))
    return float(min(errors))


STEPS = (1e-4, 1e-5, 1e-6)


@pytest.mark.slow
@every_kind
@every_basis
@every_material
@pytest.mark.parametrize(("seed", "spacing"), [(0, "uniform"), (1, "uniform"), (2, "graded")])
def test_stiffness_is_the_derivative_of_the_internal_force(
    kind: str, basis: str, material: str, seed: int, spacing: str
) -> None:
    random = np.random.default_rng(seed)
    laboratory = deformed_laboratory(kind, basis, material, random, spacing=spacing)
    if material != "hencky_elastic":
        flowed = laboratory.points.plastic[:, 0]
        assert np.count_nonzero(flowed) > 0
    assert np.abs(laboratory.points.elastic_strain).max() > 0.02
    centre = laboratory.random_displacement(random, 0.06)
    for _ in range(3):
        direction = laboratory.random_displacement(random, 1.0)
        assert derivative_error(laboratory, centre, direction, STEPS) < 1e-7


@every_kind
@every_basis
@every_material
def test_every_column_of_the_stiffness(kind: str, basis: str, material: str) -> None:
    """No entry hides behind larger ones: each column by itself, on one cell."""
    random = np.random.default_rng(7)
    laboratory = Laboratory.of(kind, basis, material, random, cells=1)
    for _ in range(2):
        laboratory.step(laboratory.random_displacement(random, 0.06))
    centre = laboratory.random_displacement(random, 0.05)
    matrix = laboratory.stiffness(centre).toarray()
    scale = np.abs(matrix).max()
    step = 1e-6
    for column in range(matrix.shape[1]):
        direction = np.zeros(matrix.shape[1])
        direction[column] = step
        shift = direction.reshape(centre.shape)
        above = laboratory.internal_force(centre + shift).ravel()
        below = laboratory.internal_force(centre - shift).ravel()
        np.testing.assert_allclose(
            (above - below) / (2 * step), matrix[:, column], rtol=0, atol=2e-7 * scale
        )


@every_kind
@every_basis
@pytest.mark.parametrize("material", [m for m in POINT_MATERIALS if laws()[m].symmetric_tangent])
def test_stiffness_is_symmetric_where_the_law_says_so(kind: str, basis: str, material: str) -> None:
    """Elasticity has a potential, and so has each step of associated flow."""
    random = np.random.default_rng(3)
    laboratory = deformed_laboratory(kind, basis, material, random)
    matrix = laboratory.stiffness(laboratory.random_displacement(random, 0.06))
    scale = np.abs(matrix.data).max()
    assert np.abs((matrix - matrix.T).toarray()).max() < 1e-12 * scale


@every_basis
@every_material
@pytest.mark.parametrize("radius", [0.25, 1e-3, 1e-7])
def test_stiffness_near_the_axis(basis: str, material: str, radius: float) -> None:
    """The hoop terms 1/r stay consistent for points that almost sit on the axis."""
    random = np.random.default_rng(4)
    laboratory = Laboratory.of("axisymmetric", basis, material, random)
    points = laboratory.points
    inner = points.position[:, 0] < 0.3
    points.position[inner, 0] = radius
    shorter = min(0.5 * radius, 0.25) / 0.25
    for lengths in (points.initial_half_length, points.half_length):
        lengths[inner, 0] *= shorter
    for edges in (points.initial_half_edge, points.corner):
        edges[inner, :, 0] *= shorter
    laboratory.locate()
    laboratory.step(laboratory.random_displacement(random, 0.05))
    assert laboratory.active.position[:, 0].min() == 0.0  # no node beyond the axis
    centre = laboratory.random_displacement(random, 0.05)
    direction = laboratory.random_displacement(random, 1.0)
    assert derivative_error(laboratory, centre, direction, STEPS) < 1e-7


@pytest.mark.slow
@every_kind
@every_basis
@every_material
@pytest.mark.parametrize("gap", [0.0, 1e-14, 1e-11, 1e-8, 1e-6, 1e-5, 1e-4, 1e-2])
def test_stiffness_with_nearly_equal_principal_stretches(
    kind: str, basis: str, material: str, gap: float
) -> None:
    """Formulas that divide by the gap of two principal values lose digits here."""
    random = np.random.default_rng(5)
    laboratory = Laboratory.of(kind, basis, material, random, cells=1)
    strain = laboratory.points.elastic_strain
    strain[:, 0] = 0.02
    strain[:, 1] = 0.02 + gap
    strain[:, 2] = -0.03 if material != "hencky_elastic" else 0.02 - gap
    strain[:, 3] = 0.3 * gap
    laboratory.points.elastic_strain = strain
    still = np.zeros(laboratory.active.position.shape)
    for _ in range(2):
        direction = laboratory.random_displacement(random, 1.0)
        assert derivative_error(laboratory, still, direction, STEPS) < 1e-7


@every_kind
@every_basis
@pytest.mark.parametrize("material", STEP_MATERIALS)
def test_stiffness_at_rest_is_that_of_linear_elasticity(
    kind: str, basis: str, material: str
) -> None:
    """Without stress the energy of a small displacement is that of Hooke's law."""
    random = np.random.default_rng(6)
    laboratory = Laboratory.of(kind, basis, material, random)
    u = laboratory.random_displacement(random, 1.0)
    matrix = laboratory.stiffness(np.zeros_like(u))
    energy = 0.5 * u.ravel() @ (matrix @ u.ravel())
    # the strain of each point from a tiny step through the kinematics alone
    tiny = 1e-9
    other = laboratory.copy()
    other.step(tiny * u)
    strain = other.points.elastic_strain / tiny
    trace = strain[:, :3].sum(axis=1)
    squared = (strain[:, :3] ** 2).sum(axis=1) + 2 * (strain[:, 3:] ** 2).sum(axis=1)
    shear, bulk = 1000.0 / 2.6, 1000.0 / 1.2
    density = 0.5 * bulk * trace**2 + shear * (squared - trace**2 / 3)
    assert energy == pytest.approx(density @ other.points.initial_volume, rel=1e-6)
