# SPDX-License-Identifier: BSD-3-Clause
"""F-bar: tangent, limits in which it is the standard method, and docs/theory/f_bar.md itself."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import scipy.linalg
from small_problems import (
    BASES,
    CORNER_BASES,
    ELASTIC,
    KINDS,
    POINT_MATERIALS,
    Laboratory,
    block_entries,
    by_number,
    dimension,
    jittered_points,
    tensor,
)

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
every_material = pytest.mark.parametrize("material", POINT_MATERIALS)


def laboratory_of(
    kind: str, basis: str, material: str, seed: int, method: str = "f_bar", per_cell: int = 2
) -> Laboratory:
    """A block of jittered points; the same ones for the same seed, whatever the method."""
    entries = block_entries(kind, basis, material)
    entries["bodies"][0] |= {"anti_locking": method, "points_per_cell": per_cell}
    model = Model.from_dict(entries)
    points = jittered_points(model, np.random.default_rng(seed), 0.4)
    return Laboratory(kind, points, Simulation(model, points).grid)


def deform(laboratory: Laboratory, random: np.random.Generator, steps: int) -> None:
    for _ in range(steps):
        laboratory.step(laboratory.random_displacement(random, 0.06))


def assert_close(one: Floats, other: Floats, tolerance: float) -> None:
    """Compares relative to the largest entry."""
    np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * np.abs(other).max())


# --- the tangent -----------------------------------------------------------------------------


@every_kind
@every_basis
@every_material
@pytest.mark.parametrize("seed", [0, 1])
def test_stiffness_is_the_derivative_of_the_internal_force(
    kind: str, basis: str, material: str, seed: int
) -> None:
    random = np.random.default_rng(seed)
    laboratory = laboratory_of(kind, basis, material, seed)
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
def test_stiffness_is_not_symmetric(kind: str, basis: str, material: str) -> None:
    """F-bar has no potential; the standard matrix is symmetric to 1e-12 (test_stiffness.py)."""
    random = np.random.default_rng(3)
    laboratory = laboratory_of(kind, basis, material, 3)
    deform(laboratory, random, 2)
    matrix = laboratory.stiffness(laboratory.random_displacement(random, 0.06)).toarray()
    assert np.abs(matrix - matrix.T).max() > 1e-3 * np.abs(matrix).max()


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


@every_kind
@every_basis
@every_material
def test_homogeneous_deformation_is_that_of_the_standard_method(
    kind: str, basis: str, material: str
) -> None:
    """The cells stretch as their points do, wherever these are."""
    dim = dimension(kind)
    h = 0.06 * np.random.default_rng(2).uniform(-1, 1, (dim, dim))
    if kind == "axisymmetric":
        h[0, 1] = 0.0  # u_r of order r
    answers = []
    for method in ("none", "f_bar"):
        laboratory = laboratory_of(kind, basis, material, 2, method)
        for _ in range(3):
            laboratory.step(laboratory.active.position @ h.T)
        points = by_number(laboratory.points)
        force = laboratory.internal_force(laboratory.active.position @ h.T)
        answers.append((points["elastic_strain"], points["stress"], points["plastic"], force))
        np.testing.assert_allclose(np.ptp(points["elastic_strain"], axis=0), 0.0, atol=1e-13)
    for standard, f_bar in zip(*answers, strict=True):
        np.testing.assert_allclose(f_bar, standard, rtol=0, atol=1e-12 * np.abs(standard).max())


# --- the assumed volume and the true one -----------------------------------------------------


@every_kind
@every_basis
@every_material
def test_elastic_strain_has_the_assumed_volume_and_points_the_true_one(
    kind: str, basis: str, material: str
) -> None:
    """No material here has plastic volume, so the elastic strain holds all of it."""
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
            np.testing.assert_allclose(strained, points.assumed_jacobian, rtol=1e-12)
            assert np.abs(strained - volume / points.initial_volume).max() > 0.01
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


# --- docs/theory/f_bar.md once more, slowly ---------------------------------------------------


def shares_of_cells(
    position: Floats, half_length: Floats, basis: str
) -> list[tuple[tuple[int, ...], float, Floats]]:
    """Cells of size 1 that a point reaches: cell, share, centroid of the point's part in it."""
    if basis == "linear":
        return [(tuple(np.floor(position).astype(int)), 1.0, position)]
    parts = []
    low, high = position - half_length, position + half_length
    for place in product(*[
        range(int(np.floor(a)), int(np.ceil(b))) for a, b in zip(low, high, strict=True)
    ]):  # fmt: skip
        start, end = np.maximum(low, place), np.minimum(high, np.array(place) + 1)
        parts.append((place, float(np.prod((end - start) / (high - low))), 0.5 * (start + end)))
    assert sum(share for _, share, _ in parts) == pytest.approx(1.0, rel=1e-13)
    return parts


def shares_of_corners(
    position: Floats, corner: Floats
) -> list[tuple[tuple[int, ...], float, Floats]]:
    """The same of a domain with corners: its places of the trapezoidal rule, 5 a direction."""
    dim = len(position)
    side = [np.array(c[::-1]) for c in product((0, 1), repeat=dim)]  # x fastest
    cells = [tuple(np.floor(position + (1.0 - 1e-8) * c).astype(int)) for c in corner]
    parts = []
    for t in product(np.linspace(0.0, 1.0, 5), repeat=dim):
        hats = [np.where(s, t, 1.0 - np.array(t)) for s in side]
        place = position + sum(np.prod(hat) * c for hat, c in zip(hats, corner, strict=True))
        edges = np.array([
            sum((1.0 if s[k] else -1.0) * np.prod(np.delete(hat, k)) * c
                for s, hat, c in zip(side, hats, corner, strict=True))
            for k in range(dim)
        ])  # fmt: skip
        weight = np.linalg.det(edges) * 0.5 ** sum(x in (0.0, 1.0) for x in t)
        cell = tuple(np.floor(place).astype(int))
        if cell not in cells:  # a domain that spans a cell
            cell = cells[int(np.argmax([np.prod(np.equal(s, np.array(t) > 0.5)) for s in side]))]
            place = np.clip(place, cell, np.array(cell) + 1.0)
        parts.append((cell, float(weight), place))
    total = sum(weight for _, weight, _ in parts)
    return [(cell, weight / total, place) for cell, weight, place in parts]


def cell_stretch(
    place: tuple[int, ...], centre: Floats, nodal: dict[tuple[int, ...], Floats], kind: str
) -> float:
    """J0 of a cell: the determinant of 1 + grad u of its corners' functions at `centre`."""
    dim = len(place)
    gradient, value = np.zeros((dim, dim)), np.zeros(dim)
    local = centre - place
    for corner in product((0, 1), repeat=dim):
        u = nodal[tuple(np.add(place, corner))]
        hat = np.array([x if c else 1.0 - x for x, c in zip(local, corner, strict=True)])
        value += np.prod(hat) * u
        for k in range(dim):
            slope = (1.0 if corner[k] else -1.0) * np.prod(np.delete(hat, k))
            gradient[:, k] += slope * u
    stretch = float(np.linalg.det(np.eye(dim) + gradient))
    return stretch * (1.0 + value[0] / centre[0]) if kind == "axisymmetric" else stretch


def expected_stretch(laboratory: Laboratory, u: Floats, basis: str) -> Floats:
    """J0 of every point in the step, in the order of the points."""
    points, dim = laboratory.points, laboratory.grid.dim
    nodal = dict(zip(map(tuple, laboratory.active.lattice[:, :dim].tolist()), u, strict=True))
    if basis in CORNER_BASES:
        reached = [
            shares_of_corners(x, corner)
            for x, corner in zip(points.position, points.corner, strict=True)
        ]
    else:
        reached = [
            shares_of_cells(x, half, basis)
            for x, half in zip(points.position, points.half_length, strict=True)
        ]
    total: dict[tuple[int, ...], float] = {}
    moment: dict[tuple[int, ...], Floats] = {}
    for volume, parts in zip(points.volume, reached, strict=True):
        for place, share, centroid in parts:
            weight = share * volume if basis != "linear" else 1.0
            total[place] = total.get(place, 0.0) + weight
            moment[place] = moment.get(place, np.zeros(dim)) + weight * centroid
    of_cell = {
        place: cell_stretch(place, moment[place] / total[place], nodal, laboratory.kind)
        for place in total
    }
    return np.array([sum(w * of_cell[place] for place, w, _ in parts) for parts in reached])


@pytest.mark.slow
@every_kind
@every_basis
def test_one_step_against_a_slow_reading_of_the_theory(kind: str, basis: str) -> None:
    random = np.random.default_rng(11)
    laboratory = laboratory_of(kind, basis, "hencky_elastic", 11)
    deform(laboratory, random, 2)
    assert np.floor(laboratory.points.position).max() >= 1
    points, dim = laboratory.points, laboratory.grid.dim
    u = laboratory.random_displacement(random, 0.06)
    before = by_number(points)
    order = points.index_of(np.arange(len(points)))
    stretch = expected_stretch(laboratory, u, basis)[order]
    force = laboratory.internal_force(u)
    node = laboratory.active.position
    laboratory.step(u)
    after = by_number(points)

    np.testing.assert_allclose(
        after["assumed_jacobian"] / before["assumed_jacobian"], stretch, rtol=1e-13
    )
    gradient = after["deformation_gradient"] @ np.linalg.inv(before["deformation_gradient"])
    scaled = 2 if kind == "plane_strain" else 3
    assumed = gradient.copy()
    ratio = (stretch / np.linalg.det(gradient)) ** (1.0 / scaled)
    assumed[:, :scaled, :scaled] *= ratio[:, None, None]
    lame = ELASTIC["young_modulus"] * ELASTIC["poisson_ratio"]
    lame /= (1.0 + ELASTIC["poisson_ratio"]) * (1.0 - 2.0 * ELASTIC["poisson_ratio"])
    shear = ELASTIC["young_modulus"] / (2.0 + 2.0 * ELASTIC["poisson_ratio"])
    for p in range(len(points)):
        left = assumed[p] @ scipy.linalg.expm(2.0 * tensor(before["elastic_strain"][p]))
        strain = 0.5 * scipy.linalg.logm(left @ assumed[p].T).real
        np.testing.assert_allclose(tensor(after["elastic_strain"][p]), strain, rtol=0, atol=1e-12)
        kirchhoff = lame * np.trace(strain) * np.eye(3) + 2.0 * shear * strain
        cauchy = kirchhoff / after["assumed_jacobian"][p]
        assert_close(tensor(after["stress"][p]), cauchy, 1e-11)

    # the power of the force in an affine motion is that of the stress in the true volume
    volume = before["initial_volume"] * np.linalg.det(after["deformation_gradient"])
    stress = tensor(after["stress"])
    for i, k in product(range(dim), repeat=2):
        rate = np.zeros((3, 3))
        rate[i, k] = 1.0
        velocity = node @ rate[:dim, :dim].T
        spatial = rate @ np.linalg.inv(gradient)
        if kind == "axisymmetric":
            moved = before["position"][:, 0] * gradient[:, 2, 2]  # radius
            spatial[:, 2, 2] = (before["position"] @ rate[:2, :2].T)[:, 0] / moved
        power = np.einsum("p,pij,pij->", volume, stress, spatial)
        scale = np.abs(force).max()
        assert np.sum(force * velocity) == pytest.approx(power, rel=1e-11, abs=1e-12 * scale)
