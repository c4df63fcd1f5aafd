# SPDX-License-Identifier: BSD-3-Clause
"""How the shear under a cylinder that is drawn is compared with the closed form."""

import numpy as np
import pytest

from tilth_verification.cattaneo import CELLS, FRICTION, RADIUS, Tractions
from tilth_verification.closed_forms.elastic_contact import Cattaneo, HertzCylinder

MODULUS = 1e7
CYLINDER = HertzCylinder(RADIUS, MODULUS)


def exact(cells: int, shear=None) -> Tractions:
    """The closed form at many places, for half a contact of that many cells of 1."""
    force = CYLINDER.force(cells)
    place = (np.arange(-1.2 * cells * 500, 1.2 * cells * 500) + 0.5) / 500
    law = Cattaneo(CYLINDER, FRICTION).shear(place, force, 0.5 * FRICTION * force)
    return Tractions(place, np.full_like(place, 1.0 / 500), law if shear is None else shear, law)


def test_means_are_those_of_lengths_about_nodes():
    place = np.array([0.3, -0.4, 0.6, 1.4])
    found = Tractions(place, np.array([1.0, 3.0, 1.0, 0.0]), place, 2.0 * place).about_nodes(1.0)
    np.testing.assert_allclose(found.width, [4.0, 1.0])
    np.testing.assert_allclose(found.shear, [(0.3 - 1.2) / 4.0, 0.6])
    np.testing.assert_allclose(found.expected, 2.0 * found.shear)
    np.testing.assert_allclose(found.place, found.shear)


def test_the_error_is_relative_to_the_closed_form():
    whole = exact(CELLS)
    assert whole.error == 0.0
    assert exact(CELLS, 1.3 * whole.shear).error == pytest.approx(0.3, rel=1e-12)
    assert exact(CELLS, 1.3 * whole.shear).about_nodes(1.0).error == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize(("cells", "least"), [(CELLS, 0.101), (2 * CELLS, 0.056)])
def test_what_is_constant_about_nodes_cannot_be_exact_at_points(cells, least):
    """By a piecewise quadrature of sqrt(1 - x^2) - c sqrt(1 - (x/c)^2) for c = sqrt(1/2)."""
    whole = exact(cells)
    part = np.floor(whole.place + 0.5).astype(int)
    means = whole.about_nodes(1.0).expected[part - part.min()]
    stairs = exact(cells, means)
    assert stairs.error == pytest.approx(least, abs=1e-3)
    assert stairs.about_nodes(1.0).error < 1e-12
