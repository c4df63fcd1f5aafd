# SPDX-License-Identifier: BSD-3-Clause
"""The internal force: energy, work, objectivity, and the transfer between points and nodes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_problems import (
    BASES,
    KINDS,
    POINT_MATERIALS,
    Laboratory,
    by_number,
    deformed_laboratory,
    dimension,
    tensor,
    yields,
)

from tilth.arrays import Floats

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
every_material = pytest.mark.parametrize("material", POINT_MATERIALS)
plane_or_solid = pytest.mark.parametrize("kind", ["plane_strain", "3d"])


def rotation(kind: str, degrees: float) -> Floats:
    """A rotation in the plane, or about an oblique axis."""
    axis = np.array([0.0, 0.0, 1.0]) if kind == "plane_strain" else np.array([1.0, 2.0, -1.5])
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * axis / np.linalg.norm(axis)).as_matrix()
    return np.asarray(turn)


def stored_energy(laboratory: Laboratory, displacement: Floats) -> float:
    other = laboratory.copy()
    other.step(displacement)
    return other.points.stored_energy()


@every_kind
@every_basis
def test_elastic_force_is_the_derivative_of_the_energy(kind: str, basis: str) -> None:
    random = np.random.default_rng(0)
    laboratory = deformed_laboratory(kind, basis, "hencky_elastic", random)
    centre = laboratory.random_displacement(random, 0.06)
    direction = laboratory.random_displacement(random, 1.0)
    power = (laboratory.internal_force(centre) * direction).sum()
    errors = []
    for step in (1e-3, 1e-4, 1e-5):
        above = stored_energy(laboratory, centre + step * direction)
        below = stored_energy(laboratory, centre - step * direction)
        errors.append(abs((above - below) / (2 * step) - power) / abs(power))
    assert min(errors) < 1e-7


@every_kind
@every_basis
def test_elastic_body_gives_back_all_energy(kind: str, basis: str) -> None:
    """Out along a path of displacements and back: every bit of stress is gone."""
    random = np.random.default_rng(1)
    laboratory = Laboratory.of(kind, basis, "hencky_elastic", random)
    start = laboratory.active.position.copy()
    laboratory.step(0.1 * start * np.array([1.0, -1.0, 0.5])[: dimension(kind)])
    assert laboratory.points.stored_energy() > 1.0
    moved = laboratory.active.position
    back = np.array([1 / 1.1, 1 / 0.9, 1 / 1.05])[: dimension(kind)]
    laboratory.step(moved * (back - 1.0))
    assert np.abs(laboratory.points.stress).max() < 1e-10
    assert laboratory.points.stored_energy() < 1e-20


def energy_balance(kind: str, basis: str, material: str, steps: int) -> tuple[float, float, float]:
    """Work of the internal force along an affine path (trapezoidal), and where it went."""
    laboratory = Laboratory.of(kind, basis, material, np.random.default_rng(2))
    dim = dimension(kind)
    rate = np.array([[0.3, 0.2, 0.1], [0.0, -0.2, 0.1], [0.2, 0.0, -0.1]])[:dim, :dim]
    if kind == "axisymmetric":
        rate = np.diag([0.25, -0.3])
    work, at_start = 0.0, laboratory.points.stored_energy()
    for _ in range(steps):
        u = laboratory.active.position @ rate.T / steps
        before = laboratory.internal_force(np.zeros_like(u))
        work += 0.5 * ((before + laboratory.internal_force(u)) * u).sum()
        laboratory.step(u)
    dissipated = laboratory.points.plastic[:, 1] @ laboratory.points.initial_volume
    return work, laboratory.points.stored_energy() - at_start, dissipated


@pytest.mark.slow
@every_kind
@every_basis
@every_material
def test_stress_work_is_stored_or_dissipated(kind: str, basis: str, material: str) -> None:
    """The balance closes with the step: second order in elasticity, first order in plasticity."""
    errors = []
    for steps in (10, 20) if material in ("hencky_elastic", "von_mises") else (20, 80):
        work, stored, dissipated = energy_balance(kind, basis, material, steps)
        errors.append(abs(work - stored - dissipated) / work)
        if yields(material):
            assert dissipated > (0.05 if "undrained" in material else 0.1) * stored
        else:
            assert dissipated == 0.0
    assert errors[1] < 0.01
    assert errors[1] < (0.7 if yields(material) else 0.3) * errors[0] or errors[1] < 1e-3


@plane_or_solid
@every_basis
@every_material
@pytest.mark.parametrize("degrees", [1e-6, 25.0, 90.0, 179.0])
def test_rigid_rotation_rotates_the_force(
    kind: str, basis: str, material: str, degrees: float
) -> None:
    random = np.random.default_rng(3)
    laboratory = deformed_laboratory(kind, basis, material, random)
    dim = dimension(kind)
    turn = rotation(kind, degrees)[:dim, :dim]
    still = np.zeros(laboratory.active.position.shape)
    force = laboratory.internal_force(still)
    turned = laboratory.internal_force(laboratory.active.position @ (turn - np.eye(dim)).T)
    np.testing.assert_allclose(turned, force @ turn.T, rtol=0, atol=1e-12 * np.abs(force).max())


@every_kind
@every_basis
@every_material
def test_rigid_translation_leaves_the_force(kind: str, basis: str, material: str) -> None:
    random = np.random.default_rng(4)
    laboratory = deformed_laboratory(kind, basis, material, random)
    still = np.zeros(laboratory.active.position.shape)
    force = laboratory.internal_force(still)
    moved = still + (np.array([0.0, 0.3]) if kind == "axisymmetric" else 0.3)
    scale = np.abs(force).max()
    np.testing.assert_allclose(laboratory.internal_force(moved), force, rtol=0, atol=1e-12 * scale)
    free = force if kind != "axisymmetric" else force[:, 1:]  # the hoop pushes radially
    np.testing.assert_allclose(free.sum(axis=0), 0.0, atol=1e-12 * scale)


@plane_or_solid
@every_basis
@every_material
@pytest.mark.parametrize("degrees", [25.0, 90.0])
def test_stress_update_is_objective(kind: str, basis: str, material: str, degrees: float) -> None:
    """A step F and a step R F end in stresses that differ by the rotation R alone."""
    random = np.random.default_rng(5)
    plain = deformed_laboratory(kind, basis, material, random)
    turned = plain.copy()
    dim = dimension(kind)
    turn = rotation(kind, degrees)
    stretch = np.eye(dim) + 0.15 * random.uniform(-1, 1, (dim, dim))
    plain.step(plain.active.position @ (stretch - np.eye(dim)).T)
    both = turn[:dim, :dim] @ stretch
    turned.step(turned.active.position @ (both - np.eye(dim)).T)
    first, second = by_number(plain.points), by_number(turned.points)
    for name, bound in (("stress", 1e-12 * np.abs(plain.points.stress).max()),
                        ("elastic_strain", 1e-13)):  # fmt: skip
        one, other = tensor(first[name]), tensor(second[name])
        np.testing.assert_allclose(other, turn @ one @ turn.T, rtol=0, atol=bound)
    np.testing.assert_allclose(second["plastic"], first["plastic"], rtol=1e-11, atol=1e-14)


@every_kind
@every_basis
def test_scatter_is_the_adjoint_of_interpolation(kind: str, basis: str) -> None:
    random = np.random.default_rng(6)
    laboratory = deformed_laboratory(kind, basis, "hencky_elastic", random)
    active, soil = laboratory.active, laboratory.soil
    nodal = random.normal(size=(active.nodes, dimension(kind)))
    vector = random.normal(size=laboratory.points.position.shape)
    left = (soil.interpolate(nodal) * vector).sum()
    right = (nodal * soil.scatter(vector)).sum()
    assert left == pytest.approx(right, rel=1e-12)


@every_kind
@every_basis
def test_scatter_keeps_the_sum_and_the_moment(kind: str, basis: str) -> None:
    """Weight put on the grid is the points' weight, with the same centre."""
    random = np.random.default_rng(7)
    laboratory = deformed_laboratory(kind, basis, "hencky_elastic", random)
    mass = laboratory.points.mass
    nodal = laboratory.soil.scatter(mass)
    assert nodal.sum() == pytest.approx(mass.sum(), rel=1e-13)
    moment = nodal @ laboratory.active.position
    np.testing.assert_allclose(moment, mass @ laboratory.points.position, rtol=1e-12)


@every_kind
@every_basis
def test_interpolation_reproduces_an_affine_motion(kind: str, basis: str) -> None:
    random = np.random.default_rng(8)
    laboratory = deformed_laboratory(kind, basis, "hencky_elastic", random)
    dim = dimension(kind)
    field = random.normal(size=(dim, dim))
    found = laboratory.soil.interpolate(laboratory.active.position @ field)
    np.testing.assert_allclose(found, laboratory.points.position @ field, rtol=0, atol=1e-12)


def test_axisymmetric_force_is_that_of_the_full_circle() -> None:
    """A ring under hoop stress alone: f_r = 2 pi A tau, from the virtual work of u_r = 1."""
    random = np.random.default_rng(9)
    laboratory = Laboratory.of("axisymmetric", "linear", "hencky_elastic", random)
    stretch = np.zeros(laboratory.active.position.shape)
    stretch[:, 0] = 1e-8 * laboratory.active.position[:, 0]  # equal radial and hoop strain 1e-8
    force = laboratory.internal_force(stretch)
    # virtual displacement u_r = r: power = integral of (s_rr + s_tt) over the volume 2 pi r dr dz
    power = (force[:, 0] * laboratory.active.position[:, 0]).sum()
    lame = 1000.0 * 0.3 / (1.3 * 0.4)
    stress = 1e-8 * (2 * lame + 1000.0 / 1.3)
    assert power == pytest.approx(2 * stress * np.pi * 2.0**2 * 2.0, rel=1e-6)
