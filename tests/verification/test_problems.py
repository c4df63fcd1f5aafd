# SPDX-License-Identifier: BSD-3-Clause
"""Every reference problem is within its tolerances: what `tilth verify` says, as a test."""

import pytest

from tilth.verification.problems import PROBLEMS
from tilth.verification.run import Row, verified


def failures(rows: list[Row]) -> list[str]:
    return [
        f"{row.comparison.quantity}: {row.comparison.computed:.6g}, not "
        f"{row.comparison.reference:.6g} (error {row.comparison.error:.2g}, "
        f"tolerance {row.comparison.tolerance:.2g}; {row.comparison.source})"
        for row in rows
        if not row.comparison.passed
    ]


@pytest.mark.parametrize("problem", PROBLEMS)
def test_reference_problem_is_within_its_tolerances(problem):
    rows = list(verified([problem], long=False))
    assert rows
    assert failures(rows) == []


@pytest.mark.long
@pytest.mark.parametrize("problem", PROBLEMS)
def test_reference_problem_is_within_its_tolerances_on_fine_grids(problem):
    assert failures(list(verified([problem], long=True))) == []
