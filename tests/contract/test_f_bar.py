# SPDX-License-Identifier: BSD-3-Clause
"""F-bar: tangent, limits in which it is the standard method, equilibrium of uniform stress."""

from __future__ import annotations

import numpy as np
import pytest
from small_problems import (
    BASES,
    CORNER_BASES,
    ELASTIC,
    KINDS,
    POINT_MATERIALS,
    SPACINGS,
    Laboratory,
    block_entries,
    by_number,
    dimension,
    jittered_points,
    principal_update,
    spaced,
    start_strain,
)

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model.laws import laws

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
every_material = pytest.mark.parametrize("material", POINT_MATERIALS)


def laboratory_of(
    kind: str,
    basis: str,
    material: str,
    seed: int,
    method: str = "f_bar",
    per_cell: int = 2,
    spacing: str = "uniform",
) -> Laboratory:
    """A block of jittered points; the same ones for the same seed, whatever the method."""
    entries = spaced(block_entries(kind, basis, material), spacing)
    entries["bodies"][0] |= {"anti_locking": method, "points_per_cell": per_cell}
    model = Model.from_dict(entries)
    points = jittered_points(model, np.random.default_rng(seed), 0.4)
    return Laboratory(kind, points, Simulation(model, points).state.grid)


def deform(laboratory: Laboratory, random: np.random.Generator, steps: int) -> None:
    for _ in range(steps):
        laboratory.step(laboratory.random_displacement(random, 0.06))


def assert_close(one: Floats, other: Floats, tolerance: float) -> None:
    """Compares relative to the largest entry."""
    np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * np.abs(other).max())


# --- the tangent -----------------------------------------------------------------------------


@pytest.mark.slow
@every_kind
@every_basis
@every_material
@pytest.mark.parametrize(("seed", "spacing"), [(0, "uniform"), (1, "uniform"), (2, "graded")])
def test_stiffness_is_the_derivative_of_the_internal_force(
    kind: str, basis: str, material: str, seed: int, spacing: str
) -> None:
    random = np.random.default_rng(seed)
    laboratory = laboratory_of(kind, basis, material, seed, spacing=spacing)
    deform(laboratory, random, 3)
    if material != "hencky_elastic":
        assert np.count_nonzero(laboratory.points.plastic[:, 0]) > 0
    assert np.abs(laboratory.points.elastic_strain).max() > 0.02
    assert np.ptp(laboratory.points.volume / laboratory.points.initial_volume) > 0.05
    centre = laboratory.random_displacement(random, 0.06)
    matrix = laboratory.stiffness(centre)
    step = 1e-6
    for _ in range(3):
        direction = laboratory.random_displacement(random, 1.0)
        above = laboratory.internal_force(centre + step * direction)
        below = laboratory.internal_force(centre - step * direction)
        expected = (above - below).ravel() / (2 * step)
        error = np.linalg.norm(matrix @ direction.ravel() - expected)
        assert error < 1e-7 * np.linalg.norm(expected)


@every_kind
@every_basis
@every_material
def test_every_column_of_the_stiffness(kind: str, basis: str, material: str) -> None:
    """No entry hides behind larger ones."""
    random = np.random.default_rng(7)
    laboratory = laboratory_of(kind, basis, material, 7)
    deform(laboratory, random, 2)
    centre = laboratory.random_displacement(random, 0.05)
    matrix = laboratory.stiffness(centre).toarray()
    step = 1e-6
    for column in random.permutation(matrix.shape[1])[:30]:
        direction = np.zeros(matrix.shape[1])
        direction[column] = step
        shift = direction.reshape(centre.shape)
        above = laboratory.internal_force(centre + shift).ravel()
        below = laboratory.internal_force(centre - shift).ravel()
        difference = (above - below) / (2 * step)
        scale = np.abs(matrix).max()
        np.testing.assert_allclose(difference, matrix[:, column], rtol=0, atol=2e-7 * scale)


@every_kind
@every_basis
@every_material
def test_stiffness_is_symmetric_where_the_law_is(kind: str, basis: str, material: str) -> None:
    """The force has a potential, as the stress of these laws has in a step."""
    if not laws()[material].symmetric_tangent:
        pytest.skip("the stress of this law has no potential")
    random = np.random.default_rng(3)
    laboratory = laboratory_of(kind, basis, material, 3)
    deform(laboratory, random, 2)
    matrix = laboratory.stiffness(laboratory.random_displacement(random, 0.06)).toarray()
    assert np.abs(matrix - matrix.T).max() < 1e-12 * np.abs(matrix).max()


# --- where it is the standard method ---------------------------------------------------------


@every_kind
@every_material
def test_one_point_per_cell_is_the_standard_method(kind: str, material: str) -> None:
    answers = []
    for method in ("none", "f_bar"):
        random = np.random.default_rng(5)
        laboratory = laboratory_of(kind, "linear", material, 5, method, per_cell=1)
        deform(laboratory, random, 3)
        assert len(laboratory.active.occupied) == len(laboratory.points)
        u = laboratory.random_displacement(random, 0.06)
        force = laboratory.internal_force(u)
        stiffness = laboratory.stiffness(u).toarray()
        stress = by_number(laboratory.points)["stress"]
        answers.append((force, stiffness, stress))
    for standard, f_bar in zip(*answers, strict=True):
        assert_close(f_bar, standard, 1e-13)


@pytest.mark.slow
@every_kind
@every_basis
@every_material
@pytest.mark.parametrize("spacing", SPACINGS)
def test_homogeneous_deformation_is_that_of_the_standard_method(
    kind: str, basis: str, material: str, spacing: str
) -> None:
    """The cells stretch as their points do, wherever these are.

    The forces are the same, too, where a point's gradients are the means over its domain.
    """
    dim = dimension(kind)
    h = 0.06 * np.random.default_rng(2).uniform(-1, 1, (dim, dim))
    if kind == "axisymmetric":
        h[0, 1] = 0.0  # u_r of order r
    answers = []
    for method in ("none", "f_bar"):
        laboratory = laboratory_of(kind, basis, material, 2, method, spacing=spacing)
        for _ in range(3):
            laboratory.step(laboratory.active.position @ h.T)
        points = by_number(laboratory.points)
        force = laboratory.internal_force(laboratory.active.position @ h.T)
        answers.append([points["elastic_strain"], points["stress"], points["plastic"], force])
        np.testing.assert_allclose(np.ptp(points["elastic_strain"], axis=0), 0.0, atol=1e-13)
    if basis in CORNER_BASES:
        for own in answers:
            own.pop()
    for standard, f_bar in zip(*answers, strict=True):
        np.testing.assert_allclose(f_bar, standard, rtol=0, atol=1e-12 * np.abs(standard).max())


# --- equilibrium of uniform stress -----------------------------------------------------------


@every_kind
@every_basis
@pytest.mark.parametrize("seed", [0, 1])
def test_uniform_stress_is_that_of_the_standard_method(kind: str, basis: str, seed: int) -> None:
    """Before the step moves, wherever the points are, and whatever their assumed volumes."""
    cauchy = np.array([-30.0, -12.0, -20.0, 4.0, 0.0, 0.0])
    young, poisson = ELASTIC["young_modulus"], ELASTIC["poisson_ratio"]
    forces = []
    for method in ("none", "f_bar"):
        random = np.random.default_rng(seed)
        laboratory = laboratory_of(kind, basis, "hencky_elastic", seed, method)
        deform(laboratory, random, 3)
        points = laboratory.points
        assumed = points.assumed_jacobian if method == "f_bar" else np.ones(len(points))
        if method == "f_bar":
            assert np.ptp(assumed) > 0.01
            volume = assumed
        else:
            volume = points.volume / points.initial_volume
        kirchhoff = volume[:, None] * cauchy
        strain = (1.0 + poisson) / young * kirchhoff
        strain[:, :3] -= poisson / young * kirchhoff[:, :3].sum(axis=1)[:, None]
        _core.elastic_deformation(kind, strain, points.elastic_deformation)
        points.stress[:] = cauchy
        laboratory.locate()
        forces.append(laboratory.internal_force(np.zeros_like(laboratory.active.position)))
    assert_close(forces[1], forces[0], 1e-13)


@every_kind
@every_basis
def test_uniform_stress_that_changes_is_that_of_the_standard_method(kind: str, basis: str) -> None:
    """In the inner nodes of a block that is stretched, on and off the grid's lines.

    There the standard method has no force, but for that of the points' places with the linear basis
    and off the lines in axisymmetry. Domains with corners that are cut across the axis differ.
    """
    stretch = np.array([0.04, -0.03, 0.02])[: dimension(kind)]
    if kind == "axisymmetric" and basis in CORNER_BASES:
        stretch[1] = 0.0
    laboratories = []
    for method in ("none", "f_bar"):
        entries = block_entries(kind, basis, cells=4)
        entries["bodies"][0]["anti_locking"] = method
        simulation = Simulation(Model.from_dict(entries))
        laboratories.append(Laboratory(kind, simulation.state.points, simulation.state.grid))
    for step in range(3):
        standard, f_bar = (
            laboratory.internal_force(laboratory.active.position * stretch)
            for laboratory in laboratories
        )
        position = laboratories[0].active.position
        edge = laboratories[0].points.position.max(axis=0)
        inner = (position > 1.0 - 1e-9).all(axis=1) & (position < edge - 0.99).all(axis=1)
        assert inner.any()
        scale = np.abs(standard).max()
        if kind != "axisymmetric" and (basis != "linear" or step == 0):
            assert np.abs(standard[inner]).max() < 1e-12 * scale
        assert np.abs(f_bar[inner] - standard[inner]).max() < 1e-12 * scale
        for laboratory in laboratories:
            laboratory.step(laboratory.active.position * stretch)


# --- the assumed volume and the true one -----------------------------------------------------


@every_kind
@every_basis
@every_material
def test_elastic_strain_has_the_assumed_volume_and_points_the_true_one(
    kind: str, basis: str, material: str
) -> None:
    """Without plastic volume the elastic strain holds all of the assumed one."""
    sheared = np.array([0.3, 0.0, -0.3])
    plastic = start_strain(material) + sheared - principal_update(material, sheared)[1]
    keeps_volume = abs(plastic.sum()) < 1e-12
    states = []
    for method in ("none", "f_bar"):
        random = np.random.default_rng(8)
        laboratory = laboratory_of(kind, basis, material, 8, method)
        deform(laboratory, random, 4)
        points = laboratory.points
        volume = points.initial_volume * np.linalg.det(points.deformation_gradient)
        np.testing.assert_allclose(points.volume, volume, rtol=1e-14)
        strained = np.exp(points.elastic_strain[:, :3].sum(axis=1))
        if method == "f_bar":
            if keeps_volume:
                np.testing.assert_allclose(strained, points.assumed_jacobian, rtol=1e-12)
            assert np.abs(points.assumed_jacobian - volume / points.initial_volume).max() > 0.01
        else:
            assert (points.assumed_jacobian == 1.0).all()
        states.append(by_number(points))
    for name in ("position", "deformation_gradient", "half_length"):
        np.testing.assert_array_equal(states[0][name], states[1][name])


@every_kind
def test_points_of_a_cell_have_the_same_stretch(kind: str) -> None:
    laboratory = laboratory_of(kind, "linear", "hencky_elastic", 9)
    points = laboratory.points
    cell = np.floor(by_number(points)["position"]).astype(int)
    deform(laboratory, np.random.default_rng(9), 1)
    jacobian = by_number(points)["assumed_jacobian"]
    different = []
    for place in np.unique(cell, axis=0):
        of_cell = jacobian[(cell == place).all(axis=1)]
        assert len(of_cell) == 2 ** dimension(kind)
        assert np.ptp(of_cell) < 1e-15
        different.append(of_cell[0])
    assert np.ptp(different) > 1e-3
