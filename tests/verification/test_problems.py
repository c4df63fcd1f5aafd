# SPDX-License-Identifier: BSD-3-Clause
"""Every reference problem is within its tolerances: what `tilth verify` says, as a test."""

import pytest
from missed import failures, gone

from tilth.verification.problems import PROBLEMS
from tilth.verification.run import verified


@pytest.mark.slow
@pytest.mark.parametrize("problem", PROBLEMS)
def test_reference_problem_is_within_its_tolerances(problem):
    rows = list(verified([problem], long=False))
    assert rows
    assert failures(problem, rows) + gone(problem, rows, long=False) == []


@pytest.mark.long
@pytest.mark.parametrize("problem", PROBLEMS)
def test_reference_problem_is_within_its_tolerances_on_fine_grids(problem):
    rows = list(verified([problem], long=True))
    assert failures(problem, rows) + gone(problem, rows, long=True) == []
