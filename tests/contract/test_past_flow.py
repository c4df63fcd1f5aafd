# SPDX-License-Identifier: BSD-3-Clause
"""Plastic flow that is past within a step: `Soil.flow`, as in two steps."""

from __future__ import annotations

import numpy as np
import pytest
from small_problems import (
    BASES,
    KINDS,
    POINT_MATERIALS,
    by_number,
    deformed_laboratory,
    dimension,
    yields,
)

every_kind = pytest.mark.parametrize("kind", KINDS)
every_material = pytest.mark.parametrize("material", POINT_MATERIALS)


@every_kind
@every_material
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("method", ["none", "f_bar"])
def test_the_force_stays_and_the_way_back_is_elastic(
    method: str, kind: str, basis: str, material: str
) -> None:
    random = np.random.default_rng(6)
    laboratory = deformed_laboratory(kind, basis, material, random, 2, method=method)
    soil, u = laboratory.soil, laboratory.random_displacement(random, 0.06)
    force = laboratory.internal_force(u)
    flowed = soil.plastic_increment()
    soil.flow(u)
    again = laboratory.internal_force(u)
    np.testing.assert_allclose(again, force, rtol=0, atol=1e-10 * np.abs(force).max())
    np.testing.assert_allclose(soil.plastic_increment(), flowed, rtol=0, atol=1e-10)
    if yields(material):
        assert flowed.any()
        back = 0.9 * u  # where the first flow has been less
        laboratory.internal_force(back)
        assert (soil.plastic_increment() >= flowed - 1e-10).all()
    soil.past = None
    np.testing.assert_allclose(laboratory.internal_force(u), force, rtol=1e-13)
    np.testing.assert_allclose(soil.plastic_increment(), flowed, rtol=1e-13, atol=1e-15)


@every_kind
@every_material
def test_it_is_as_in_two_steps(kind: str, material: str) -> None:
    """Of homogeneous motions, which do not depend on where the points are in the grid.

    Without F-bar, which smooths the volumetric strains at the end of each step.
    """
    random = np.random.default_rng(7)
    laboratory = deformed_laboratory(kind, "gimp", material, random, 2)
    dim = dimension(kind)
    if kind == "axisymmetric":
        first, second = (np.diag(1.0 + 0.06 * random.uniform(-1, 1, 2)) for _ in range(2))
    else:
        first, second = (np.eye(dim) + 0.06 * random.uniform(-1, 1, (dim, dim)) for _ in range(2))
    two = laboratory.copy()
    for each in (first, second):
        two.step(two.active.position @ (each - np.eye(dim)).T)
    soil, x = laboratory.soil, laboratory.active.position
    soil.update(x @ (first - np.eye(dim)).T)
    soil.flow(x @ (first - np.eye(dim)).T)
    laboratory.step(x @ (second @ first - np.eye(dim)).T)
    one, other = by_number(laboratory.points), by_number(two.points)
    scale = np.abs(other["stress"]).max()
    np.testing.assert_allclose(one["plastic"], other["plastic"], rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(one["stress"], other["stress"], rtol=0, atol=1e-8 * scale)


@every_kind
def test_points_keep_their_own_plastic_volume_changes(kind: str) -> None:
    """Those of before count once, and later ones as without past flow."""
    random = np.random.default_rng(9)
    laboratory = deformed_laboratory(kind, "gimp", "mohr_coulomb", random, 2, method="f_bar")
    soil, u = laboratory.soil, laboratory.random_displacement(random, 0.06)
    laboratory.internal_force(u)
    assert soil.refine() > 1.0
    force = laboratory.internal_force(u)
    soil.flow(u)
    again = laboratory.internal_force(u)
    np.testing.assert_allclose(again, force, rtol=0, atol=1e-10 * np.abs(force).max())
    soil.refine()
    revised = laboratory.internal_force(u)
    assert np.abs(revised - force).max() > 1e-6 * np.abs(force).max()


@pytest.mark.parametrize("kind", KINDS)
def test_its_stiffness_is_the_derivative_of_its_force(kind: str) -> None:
    random = np.random.default_rng(8)
    laboratory = deformed_laboratory(kind, "gimp", "mohr_coulomb", random)
    u = laboratory.random_displacement(random, 0.06)
    laboratory.internal_force(u)
    laboratory.soil.flow(u)
    at = u + laboratory.random_displacement(random, 0.03)
    along = laboratory.random_displacement(random, 1.0)
    product = (laboratory.stiffness(at) @ along.ravel()).reshape(along.shape)
    above, below = (laboratory.internal_force(at + step * along) for step in (1e-6, -1e-6))
    difference = 0.5e6 * (above - below)
    np.testing.assert_allclose(difference, product, rtol=0, atol=1e-7 * np.abs(product).max())
