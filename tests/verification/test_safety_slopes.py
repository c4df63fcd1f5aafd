# SPDX-License-Identifier: BSD-3-Clause
"""Factors of safety of soil with little or no cohesion, between Davis' and Spencer's.

A failed solution is no collapse: each factor, or what is certain of one that is undecided, is not
below Davis' (form C, of the reduced friction angle) and not above Spencer's by more than 5 %.
"""

from __future__ import annotations

import math

import pytest
from readings import long
from safety_slopes import HIGH, LOW, SafetySlope, agrees, reduced
from spencer import SpencerSlope

from tilth.model.davis import DavisForm

ACADS = 0.986
"""Spencer's factor of the simple slope of the ACADS survey (Giam and Donald 1989, example 1a), by
several programs; the survey's own is 1.00."""

COARSE, FINE = 0.5, 0.25
"""Cells over slopes of 5 m [m]."""

SLOPES = [
    (SafetySlope(2.0, 1.0, 33.0, 0.0), COARSE, (1.406, 1.549)),
    (SafetySlope(2.0, 5.0, 25.0, 25.0, wet=True), COARSE, (1.440, 1.440)),
    (SafetySlope(2.0, 0.0, 37.0, 0.0), COARSE, (1.306, 1.507)),
    (SafetySlope(1.5, 5.0, 30.0, 0.0), COARSE, (1.432, 1.545)),
    (SafetySlope(2.0, 2.0, 35.0, 5.0, wet=True), COARSE, (1.581, 1.674)),
    (SafetySlope(2.0, 1.0, 35.0, 35.0, wet=True), COARSE, (1.571, 1.571)),
    (SafetySlope(3.0, 0.0, 35.0, 5.0, angle=15.0), COARSE, (2.037, 2.101)),
    (SafetySlope(2.0, 1.0, 33.0, 33.0, angle=15.0), FINE, (1.549, 1.549)),
    (SafetySlope(1.5, 5.0, 30.0, 30.0, angle=15.0), FINE, (1.545, 1.545)),
    (SafetySlope(2.0, 2.0, 30.0, 0.0, angle=15.0), COARSE, (1.427, 1.540)),
    (SafetySlope(2.0, 0.0, 37.0, 37.0), FINE, (1.507, 1.507)),
]
"""Slope, cells [m], and its bounds by Davis and Spencer, which a test computes anew."""

IN_SHORT = 2
"""Slopes that are computed every time."""


def test_spencer_of_a_published_slope() -> None:
    ground = [(-50.0, 35.0), (-20.0, 35.0), (0.0, 25.0), (30.0, 25.0)]
    slope = SpencerSlope(ground, 20.0, 3.0, 19.6, 20.0)
    assert slope.least_factor((-35.0, -20.0), (-5.0, 5.0)) == pytest.approx(ACADS, rel=0.005)


def test_spencer_of_a_shallow_circle_is_the_infinite_slope() -> None:
    slope = SafetySlope(2.0, 0.0, 37.0, 37.0).spencer()
    exact = 2.0 * math.tan(math.radians(37.0))
    assert slope.factor(-9.9, -0.1, 0.01) == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(
    ("slope", "cell_size", "bounds"),
    SLOPES[:IN_SHORT] + [long(*each) for each in SLOPES[IN_SHORT:]],
)
def test_factors_are_between_davis_and_spencer(
    slope: SafetySlope, cell_size: float, bounds: tuple[float, float]
) -> None:
    result = reduced(slope, cell_size)
    davis, spencer = bounds
    assert agrees(result, davis, spencer)
    if result.is_decided:
        assert LOW * davis <= result.factor <= HIGH * spencer


@pytest.mark.slow
def test_sand_without_cohesion() -> None:
    """This slope once had the factor 0.79, of a failed solution."""
    davis, spencer = 2.132, 2.261
    result = reduced(SafetySlope(3.0, 0.0, 37.0, 0.0), COARSE, tolerance=0.02)
    assert result.trials[0].in_equilibrium
    assert result.is_decided
    assert LOW * davis <= result.factor <= HIGH * spencer


@pytest.mark.long
def test_davis_equivalents_have_spencers_factors() -> None:
    """Of slices with the same strength: beta of the reduced angle, and of the declared psi.

    All flow of these trials is associated, and the coarse grid too strong by the same 5 %: ratios
    to the factor of the soil with psi = phi are those of the slices.
    """
    associated = reduced(SafetySlope(1.5, 5.0, 30.0, 30.0), COARSE)
    forms: list[tuple[float, DavisForm]] = [(0.0, "B"), (10.0, "C")]
    for psi, form in forms:
        slope = SafetySlope(1.5, 5.0, 30.0, psi)
        equivalent, of_the_soil = slope.bounds()
        result = reduced(slope, COARSE, davis=form)
        assert result.is_decided
        assert equivalent < result.factor < 1.07 * equivalent
        ratio = result.factor / associated.factor
        assert ratio == pytest.approx(equivalent / of_the_soil, rel=0.015)


@pytest.mark.long
@pytest.mark.parametrize(("slope", "cell_size", "bounds"), SLOPES)
def test_the_bounds(slope: SafetySlope, cell_size: float, bounds: tuple[float, float]) -> None:
    assert slope.bounds() == pytest.approx(bounds, rel=2e-3)
