# SPDX-License-Identifier: BSD-3-Clause
"""Measures of force curves, and the bearing factor of a pipe, against numbers known beforehand."""

import numpy as np
import pytest

from tilth_verification.buried_pipe import bearing_factor
from tilth_verification.curves import Curve, largest_difference


def parabola(steps: int) -> Curve:
    displacement = np.linspace(0.0, 2.0, steps + 1)[1:]
    return Curve(displacement, displacement**2)


def test_roughness_of_a_parabola():
    """Its second difference is twice the square of an increment, everywhere."""
    curve = parabola(40)
    for increments, start in ((40, 0.0), (20, 1.0)):
        even = np.linspace(0.0, 2.0, increments + 1)
        mean = (even[even >= start] ** 2).mean()
        exact = 2.0 * (2.0 / increments) ** 2 / mean
        # below the first step the curve is constant: parabolas begin there with the first force
        assert curve.roughness(increments, start) == pytest.approx(exact, rel=0.02)


def test_a_straight_line_is_smooth_and_a_zigzag_is_not():
    displacement = np.arange(1.0, 11.0)
    assert Curve(displacement, 3.0 + displacement).roughness(10, 1.0) == pytest.approx(
        0.0, abs=1e-14
    )
    zigzag = 1.0 + 0.1 * (-1.0) ** np.arange(10)
    assert Curve(displacement, zigzag).roughness(10, 1.0) == pytest.approx(0.4)


def test_largest_difference_of_two_curves():
    reference = parabola(40)
    bump = np.where(np.isclose(reference.displacement, 1.5), 1.1, 1.01)
    displacement, computed, exact = largest_difference(
        Curve(reference.displacement, reference.force * bump), reference, 0.5
    )
    assert (displacement, computed, exact) == pytest.approx((1.5, 1.1 * 2.25, 2.25))
    early = np.where(reference.displacement < 0.5, 2.0, 1.0)
    _, computed, exact = largest_difference(
        Curve(reference.displacement, reference.force * early), reference, 0.5
    )
    assert computed == exact


@pytest.mark.parametrize(
    ("adhesion", "factor"),
    [(0.0, np.pi + 6.0), (0.25, 10.056), (0.5, 10.820), (0.75, 11.452), (1.0, 11.940)],
)
def test_bearing_factor_of_a_deep_pipe(adhesion, factor):
    """The formula of Randolph & Houlsby (1984) at their steps of the adhesion."""
    assert bearing_factor(adhesion) == pytest.approx(factor, abs=5e-4)
