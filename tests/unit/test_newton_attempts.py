# SPDX-License-Identifier: BSD-3-Clause
"""How a step is tried again, what a line search tries, and which equilibria are none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from tilth.analysis.attempts import require_little_growth
from tilth.analysis.residual import Residual, State, newton_attempts
from tilth.analysis.step import LINE_SEARCH, Equilibrium, corrected
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.model import Analysis
from tilth.mpm.soil import Soil
from tilth.terms.balance import Forces
from tilth.terms.protocol import Changes


@pytest.mark.parametrize(
    ("declared", "searched"), [(None, [False, True]), (False, [False]), (True, [True])]
)
def test_contact_is_tried_in_all_ways_whatever_the_line_search(
    declared: bool | None, searched: list[bool]
) -> None:
    analysis = Analysis(kind="plane_strain", line_search=declared)
    without = newton_attempts(analysis, 0.0, contact=False)
    assert [each.line_search for each in without] == searched
    assert all(each.changes is Changes.USUAL for each in without)
    with_contact = newton_attempts(analysis, 0.0, contact=True)
    assert with_contact[: len(without)] == without
    last = with_contact[len(without) :]
    assert [each.changes for each in last] == [Changes.CAREFUL, Changes.SINGLE]
    assert all(each.line_search is searched[-1] for each in last)


class Valley:
    """A residual of |1 - u / 100|, 3 + u for u between 0 and `bad`; points invert beyond 10."""

    def __init__(self, bad: float) -> None:
        self.bad = bad

    def at(self, displacement: Floats, unknowns: Floats) -> State:
        """The state at a displacement of one node along one axis."""
        u = float(displacement[0, 0])
        if u > 10.0:
            raise StepFailed("inverted")
        free = 3.0 + u if 0.0 < u < self.bad else abs(1.0 - u / 100.0)
        return State(displacement, unknowns, cast(Forces, None), free, free)


def searched(bad: float, correction: float) -> float:
    """Where a line search goes from 0."""
    valley, zero = cast(Residual, Valley(bad)), np.zeros((1, 1))
    now = valley.at(zero, np.zeros(0))
    moved = (np.array([[correction]]), np.zeros(0))
    return float(corrected(valley, now, moved, LINE_SEARCH).displacement[0, 0])


def test_a_line_search_shortens_until_points_do_not_invert() -> None:
    assert searched(0.0, 8.0) == 8.0
    assert searched(0.0, 600.0) == 600.0 / 64.0  # the first share that is possible
    with pytest.raises(StepFailed, match="inverted"):
        searched(0.0, 2000.0)


def test_a_line_search_takes_the_best_share_if_none_is_better_than_before() -> None:
    assert searched(11.0, 320.0) == 5.0  # of 10 and 5, which are possible


def test_soil_that_is_torn_off_is_no_equilibrium() -> None:
    growth = np.array([1.0, 0.5, 1.9])
    points = SimpleNamespace(point_id=np.array([7, 8, 9]))
    soil = SimpleNamespace(points=points, step_inverses=lambda u: (growth, None))
    zero = np.zeros((1, 2))
    found = Equilibrium(zero, zero, zero, zero, [1.0, 1e-10])
    require_little_growth(cast(Soil, soil), found)
    growth[1] = 40.0
    with pytest.raises(StepFailed, match="grows 40 times") as failure:
        require_little_growth(cast(Soil, soil), found)
    assert failure.value.point == 8
    assert failure.value.residuals == [1.0, 1e-10]
