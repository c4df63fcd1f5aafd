# SPDX-License-Identifier: BSD-3-Clause
"""Bearing capacities by the method of characteristics: those of the problem, and closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tilth_verification import strip_footing_friction as problem
from tilth_verification.closed_forms.slip_lines import Footing

SOILS = [
    problem.LOOSE, problem.LOOSE_ROUGH, problem.DENSE, problem.DENSE_ROUGH, problem.WEAK,
    problem.WEAK_ROUGH, problem.SAND, problem.SAND_ROUGH,
]  # fmt: skip
SANDY = Footing(1.0, 2.0, 30.0, 20.0, 10.0)


def capacity(footing: Footing, rough: bool) -> float:
    return footing.rough() if rough else footing.smooth()


@pytest.mark.parametrize("soil", SOILS, ids=str)
def test_the_references_of_the_problem(soil: problem.Soil) -> None:
    footing = Footing(
        problem.WIDTH, soil.cohesion, soil.friction, problem.UNIT_WEIGHT, soil.surcharge
    )
    assert capacity(footing, soil.rough) == pytest.approx(soil.capacity, rel=2e-3)


@pytest.mark.parametrize("rough", [False, True])
def test_weightless_soil_has_the_factors_of_prandtl_and_reissner(rough: bool) -> None:
    phi = math.radians(SANDY.friction_angle)
    surcharge = math.exp(math.pi * math.tan(phi)) * math.tan(0.25 * math.pi + 0.5 * phi) ** 2
    exact = SANDY.surcharge * surcharge + SANDY.cohesion * (surcharge - 1.0) / math.tan(phi)
    assert capacity(replace(SANDY, unit_weight=1e-9), rough) == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("rough", [False, True])
def test_more_lines_are_nearer_to_the_limit(rough: bool) -> None:
    """The error is of second order in the distance of the lines."""
    found = [capacity(replace(SANDY, lines=lines), rough) for lines in (10, 20, 40)]
    assert (found[0] - found[1]) / (found[1] - found[2]) == pytest.approx(4.0, abs=1.0)


@pytest.mark.parametrize("rough", [False, True])
def test_it_does_not_depend_on_the_units(rough: bool) -> None:
    other = Footing(1e3, 2e-3, 30.0, 20e-6, 10e-3)
    assert 1e3 * capacity(other, rough) == pytest.approx(capacity(SANDY, rough), rel=1e-7)
