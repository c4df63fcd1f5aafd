# SPDX-License-Identifier: BSD-3-Clause
"""How failure is read from a curve, and the reference value against a bound computed here."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize

from tilth_verification.vertical_cut import FAILURE, sharpest


@pytest.mark.parametrize(("unit_of_load", "unit_of_settlement"), [(1.0, 1.0), (1e3, 1e-5)])
def test_the_sharpest_bend_is_where_the_slope_jumps(unit_of_load, unit_of_settlement):
    """In any units, and also if the first steps are larger than those near failure."""
    load = np.concatenate([np.arange(0.3, 2.8, 0.3), np.arange(3.0, 4.3, 0.01)])
    settlement = load + 100.0 * np.maximum(0.0, load - 3.8)
    found = sharpest(load * unit_of_load, settlement * unit_of_settlement)
    assert load[found] == pytest.approx(3.8, abs=0.0101)


def test_the_reference_is_slightly_below_the_upper_bound_of_a_slip_circle():
    """Rotation about (x, y), circle through the toe at 0, cut of height 1 with c 1: the moment of
    the strength, R^2 times the angle of the arc, over that of the weight beyond the face."""

    def bound(centre):
        x, y = centre
        radius = np.hypot(x, y)
        end = x + np.sqrt(radius**2 - (1.0 - y) ** 2)  # on the surface
        angle = np.arctan2(1.0 - y, end - x) - np.arctan2(-y, -x)

        def moment(height):
            right = x + np.sqrt(radius**2 - (height - y) ** 2)
            return 0.5 * ((right - x) ** 2 - x**2)

        return radius**2 * abs(angle) / quad(moment, 0.0, 1.0)[0]

    least = minimize(bound, (-0.6, 1.6), method="Nelder-Mead", options={"xatol": 1e-8}).fun
    assert least == pytest.approx(3.83, abs=0.005)
    assert 0.98 * least < FAILURE < least
