# SPDX-License-Identifier: BSD-3-Clause
"""The formulas for a footing on sand over clay, and rows that fail where a curve is wrong."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tilth_verification import spudcan_sand_over_clay as spudcan
from tilth_verification.curves import Curve
from tilth_verification.spudcan_sand_over_clay import (
    DIAMETER,
    DILATION,
    FRICTION,
    SAND,
    STRENGTH,
    UNIT_WEIGHT,
)


def punched(peak: float, after: float) -> Curve:
    """A resistance that rises to a peak at 1 m, falls to `after` at 3 m and stays."""
    way = np.linspace(0.0, 0.8 * DIAMETER, 97)
    return Curve(way, np.interp(way, [0.0, 1.0, 3.0, 4.8], [0.0, peak, after, after]))


def test_the_peak_and_the_drop_after_it() -> None:
    curve = punched(8e3, 7e3)
    way, greatest = spudcan.peak(curve)
    assert way == pytest.approx(1.0)
    assert greatest == pytest.approx(8e3)
    assert spudcan.drop(curve) == pytest.approx(1.0 / 8.0)
    assert all(row.passed for row in spudcan.punched(curve, 8))


def test_a_resistance_that_only_rises_and_a_footing_that_stops_are_missed() -> None:
    way = np.linspace(0.0, 0.5 * DIAMETER, 61)
    rows = list(spudcan.punched(Curve(way, 3e3 * way), 8))
    assert [row.quantity[:5] for row in rows if not row.passed] == ["drop ", "penet"]


@pytest.mark.parametrize(("peak", "missed"), [(2e3, [True, False]), (12e3, [False, True])])
def test_a_peak_out_of_the_range_of_both_formulas_is_missed(
    peak: float, missed: list[bool]
) -> None:
    rows = list(spudcan.peak_in_range(punched(peak, peak), 8))
    assert [not row.passed for row in rows] == missed
    assert all(row.passed for row in spudcan.peak_in_range(punched(8e3, 8e3), 8))


def test_the_load_spreads_the_more_the_flatter() -> None:
    assert spudcan.load_spread(math.inf) == pytest.approx(0.25 * math.pi * 36.0 * 6.05 * 20.0)
    assert spudcan.load_spread(3.0) == pytest.approx(spudcan.load_spread(math.inf) * (8 / 6) ** 2)


def test_the_silo_of_sand_is_in_equilibrium() -> None:
    """The closed form of Lee et al. is the solution of their differential equation for slices.

    With z down from the footing, 0.88 H above the clay, and R = D / 2 + z tan psi:
    d sigma / dz = gamma - E* tan psi sigma / R, and sigma below is the clay's bearing capacity with
    the weight of all sand beside it.
    """
    tangent, sine = math.tan(DILATION), math.sin(FRICTION)
    reduced = sine * math.cos(DILATION) / (1.0 - sine * math.sin(DILATION))
    factor = 0.642 * (SAND / DIAMETER) ** -0.576
    exponent = 2.0 * (1.0 + factor * (reduced / tangent - 1.0))
    height = 0.88 * SAND
    bottom = 6.05 * STRENGTH + UNIT_WEIGHT * SAND

    def slope(z: float, stress: np.ndarray) -> np.ndarray:
        return UNIT_WEIGHT - exponent * tangent * stress / (0.5 * DIAMETER + z * tangent)

    found = solve_ivp(slope, (height, 0.0), [bottom], rtol=1e-10, atol=1e-10)
    area = 0.25 * math.pi * DIAMETER**2
    assert spudcan.punch_through() == pytest.approx(area * found.y[0, -1], rel=1e-6)
