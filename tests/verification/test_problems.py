# SPDX-License-Identifier: BSD-3-Clause
"""Every reference problem is within its tolerances: what `tilth verify` says, as a test.

Of problems that take long the first rows, or a coarse form in `test_coarse.py`, are enough to see
what is wrong; all their rows are computed with `pytest -m long`.
"""

from itertools import islice

import pytest
from missed import failures, gone
from test_coarse import COARSE

from tilth_verification.problems import PROBLEMS
from tilth_verification.run import verified

FIRST = {
    "block_on_block": 1,
    "buried_pipe": 3,
    "cam_clay_consolidation": 6,
    "cavity_expansion": 2,
    "cryer": 3,
    "de_leeuw": 3,
    "embankment": 12,
    "embankment_on_drains": 13,
    "end_loaded_cantilever": 4,
    "excavation": 6,
    "inclined_column": 7,
    "infinite_slope": 2,
    "large_consolidation": 6,
    "layered_cut": 2,
    "radial_drain": 11,
    "rigid_footing_elastic": 3,
    "rigid_sphere": 1,
    "rolling_sphere": 2,
    "self_weight_column": 36,
    "slope_strength_reduction": 9,
    "slurry": 6,
    "square_footing": 1,
    "strip_footing": 5,
    "strip_footing_friction": 3,
    "terzaghi": 12,
    "thick_cylinder": 119,
    "tunnel": 6,
    "undrained_limit": 12,
    "upsetting": 5,
}
"""How many rows of a problem are computed, if not all."""
WHOLE = [problem for problem in PROBLEMS if problem not in {*FIRST, *COARSE}]


@pytest.mark.slow
@pytest.mark.parametrize("problem", FIRST)
def test_first_rows_are_within_their_tolerances(problem: str) -> None:
    rows = list(islice(verified([problem], long=False), FIRST[problem]))
    assert len(rows) == FIRST[problem]
    assert failures(problem, rows) == []


@pytest.mark.parametrize(
    "problem",
    [
        pytest.param(problem, marks=pytest.mark.slow if problem in WHOLE else pytest.mark.long)
        for problem in PROBLEMS
    ],
)
def test_reference_problem_is_within_its_tolerances(problem: str) -> None:
    rows = list(verified([problem], long=False))
    assert rows
    assert failures(problem, rows) + gone(problem, rows, long=False) == []


@pytest.mark.long
@pytest.mark.parametrize("problem", PROBLEMS)
def test_reference_problem_is_within_its_tolerances_on_fine_grids(problem: str) -> None:
    rows = list(verified([problem], long=True))
    assert failures(problem, rows) + gone(problem, rows, long=True) == []
