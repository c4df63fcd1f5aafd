# SPDX-License-Identifier: BSD-3-Clause
"""Spectral functions of symmetric tensors and the rules by which domains follow F."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm, polar
from scipy.spatial.transform import Rotation
from small_problems import KINDS, Laboratory, block_entries, dimension, parameters, tensor

from tilth import _core
from tilth.arrays import Floats

RULES = ("determinant", "deformation_gradient", "right_stretch", "left_stretch")


def components(whole: Floats) -> Floats:
    """xx yy zz xy yz xz of symmetric tensors (n, 3, 3)."""
    return np.ascontiguousarray(whole[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]])


def symmetric(values: Floats, kind: str, random: np.random.Generator) -> Floats:
    """Tensors (n, 3, 3) with these principal values (n, 3), turned as the kind allows."""
    n = len(values)
    if kind == "3d":
        turn = Rotation.random(n, random_state=random.integers(2**31)).as_matrix()
    else:
        angle = random.uniform(0, 2 * np.pi, n)
        turn = Rotation.from_rotvec(np.outer(angle, [0.0, 0.0, 1.0])).as_matrix()
    return np.asarray(np.einsum("nia,na,nja->nij", turn, values, turn))


def exponential(kind: str, strain: Floats) -> Floats:
    deformation = np.full((len(strain), 6), np.nan)
    _core.elastic_deformation(kind, components(strain), deformation)
    return tensor(deformation)


VALUES = {
    "general": [0.3, -0.2, 0.1],
    "large": [1.5, -2.0, 0.4],
    "equal pair": [0.2, 0.2, -0.1],
    "nearly equal pair": [0.2, 0.2 + 1e-11, -0.1],
    "equal triple": [0.2, 0.2, 0.2],
    "nearly equal triple": [0.2, 0.2 + 1e-9, 0.2 - 3e-9],
    "tiny": [1e-12, -2e-12, 5e-13],
    "mixed sizes": [1.0, 1e-8, -1e-12],
    "zero": [0.0, 0.0, 0.0],
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("values", list(VALUES.values()), ids=list(VALUES))
def test_exponential_of_a_strain(kind: str, values: list[float]) -> None:
    """exp(2 e) - 1, with full relative accuracy also where it is tiny."""
    random = np.random.default_rng(0)
    strain = symmetric(np.tile(values, (20, 1)), kind, random)
    found = exponential(kind, strain)
    for e, b in zip(strain, found, strict=True):
        tiny = np.abs(e).max() < 1e-6
        exact = 2 * e + 2 * e @ e if tiny else expm(2 * e) - np.eye(3)
        scale = max(np.abs(exact).max(), 1e-300)
        assert np.abs(b - exact).max() <= 2e-14 * scale * max(1.0, np.exp(2 * np.abs(e).max()))


@pytest.mark.parametrize("kind", KINDS)
def test_diagonal_strain_is_exact(kind: str) -> None:
    strain = np.diag([0.1, -0.3, 0.7])[None]
    found = exponential(kind, strain)[0]
    np.testing.assert_allclose(np.diag(found), np.expm1([0.2, -0.6, 1.4]), rtol=1e-15)
    assert not (found - np.diag(np.diag(found))).any()


@pytest.mark.parametrize("values", list(VALUES.values()), ids=list(VALUES))
def test_energy_does_not_depend_on_the_axes(values: list[float]) -> None:
    random = np.random.default_rng(1)
    strain = components(symmetric(np.tile(values, (50, 1)), "3d", random))
    density = np.full(50, np.nan)
    deformation, state = np.empty_like(strain), np.zeros((50, 0))
    _core.elastic_deformation("3d", strain, deformation)
    given = parameters("hencky_elastic")
    _core.stored_energy("3d", "hencky_elastic", given, deformation, state, density)
    shear, bulk = 1000.0 / 2.6, 1000.0 / 1.2
    trace = sum(values)
    exact = 0.5 * bulk * trace**2 + shear * (np.square(values).sum() - trace**2 / 3)
    np.testing.assert_allclose(density, exact, rtol=1e-12, atol=1e-300)


# --- domains (THEORY A6) ---------------------------------------------------------------------


def stretched(kind: str, rule: str, gradient: Floats) -> Floats:
    """Half lengths of initially unit ones."""
    dim = dimension(kind)
    initial = np.ones((1, dim))
    half = np.full((1, dim), np.nan)
    whole = np.eye(3)
    whole[: len(gradient), : len(gradient)] = gradient
    _core.stretch_domains(kind, rule, whole[None].copy(), initial, half)
    return half[0]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("rule", RULES)
def test_rules_agree_on_an_equal_stretch(kind: str, rule: str) -> None:
    gradient = 1.2 * np.eye(dimension(kind))
    np.testing.assert_allclose(stretched(kind, rule, gradient), 1.2, rtol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("rule", RULES[1:])
def test_stretch_along_the_axes_is_exact(kind: str, rule: str) -> None:
    stretch = np.array([1.7, 0.4, 0.9])[: dimension(kind)]
    np.testing.assert_allclose(stretched(kind, rule, np.diag(stretch)), stretch, rtol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("hoop", [1.0, 1.6])
def test_determinant_rule_keeps_the_size(kind: str, hoop: float) -> None:
    """In axisymmetry the area in the plane counts, not the hoop."""
    dim = dimension(kind)
    gradient = np.eye(3)
    gradient[:dim, :dim] += np.array([[0.3, 0.5, 0.1], [0.0, -0.2, 0.0], [0.2, 0.0, 0.4]])[
        :dim, :dim
    ]
    if kind == "axisymmetric":
        gradient[2, 2] = hoop
    half = stretched(kind, "determinant", gradient)
    assert np.prod(half) == pytest.approx(np.linalg.det(gradient[:dim, :dim]), rel=1e-13)
    assert np.ptp(half) < 1e-15


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("degrees", [0.0, 40.0, 90.0, 180.0])
def test_stretch_rules_are_the_polar_decomposition(kind: str, degrees: float) -> None:
    dim = dimension(kind)
    axis = [0.0, 0.0, 1.0] if dim == 2 else [0.6, 0.0, 0.8]
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * np.array(axis)).as_matrix()[:dim, :dim]
    stretch = np.array([[1.5, 0.2, 0.1], [0.2, 0.8, 0.0], [0.1, 0.0, 1.1]])[:dim, :dim]
    gradient = turn @ stretch
    np.testing.assert_allclose(
        stretched(kind, "right_stretch", gradient), np.diag(stretch), rtol=1e-12
    )
    left = polar(gradient, side="left")[1]
    np.testing.assert_allclose(stretched(kind, "left_stretch", gradient), np.diag(left), rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_faces_of_domains_move_with_the_grid(kind: str) -> None:
    """The rule `corners`: a stretch along the axes is exact, and shear does not change domains."""
    (body,) = block_entries(kind, "gimp")["bodies"]
    bodies = [body | {"domain_update": "corners"}]
    random = np.random.default_rng(2)
    laboratory = Laboratory.of(kind, "gimp", "hencky_elastic", random, bodies=bodies)
    dim, points = dimension(kind), laboratory.points
    before, number = points.half_length.copy(), points.point_id.copy()
    gradient = np.diag([1.15, 0.9, 1.05][:dim])
    gradient[-1, 0] = 0.1
    laboratory.step(laboratory.active.position @ (gradient - np.eye(dim)).T)
    after = points.half_length[points.index_of(number)]
    np.testing.assert_allclose(after / before, np.tile(np.diag(gradient), (len(points), 1)))


def test_names_of_unknown_rules_and_kinds_are_refused() -> None:
    with pytest.raises(ValueError, match="unknown domain rule"):
        stretched("plane_strain", "inflate", np.eye(2))
    with pytest.raises(ValueError, match="unknown analysis kind"):
        _core.response_size("plane_stress")


def test_arrays_of_a_wrong_size_are_refused() -> None:
    with pytest.raises(ValueError, match="deformation has 11 entries, expected 12"):
        _core.elastic_deformation("3d", np.zeros((2, 6)), np.zeros(11))
