# SPDX-License-Identifier: BSD-3-Clause
"""How a step is tried again, and what a line search tries."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from tilth.algebra.unknowns import Unknowns
from tilth.analysis.residual import Equations, Iterate, Size, newton_attempts
from tilth.analysis.step import LINE_SEARCH, LONG_LINE_SEARCH, corrected
from tilth.errors import StepFailed
from tilth.model import Analysis
from tilth.terms.balance import Residual
from tilth.terms.protocol import Changes


@pytest.mark.parametrize(
    ("declared", "searched"), [(None, [False, True]), (False, [False]), (True, [True])]
)
def test_contact_is_tried_in_all_ways_whatever_the_line_search(
    declared: bool | None, searched: list[bool]
) -> None:
    analysis = Analysis(kind="plane_strain", line_search=declared)
    without = newton_attempts(analysis, {}, contact=False)
    assert [each.line_search for each in without] == searched
    assert all(each.changes is Changes.USUAL for each in without)
    with_contact = newton_attempts(analysis, {}, contact=True)
    assert with_contact[: len(without)] == without
    last = with_contact[len(without) :]
    assert [each.changes for each in last] == [Changes.CAREFUL, Changes.SINGLE]
    assert all(each.line_search is searched[-1] for each in last)


class Valley:
    """A residual of |1 - u / 100|, 3 + u for u between 0 and `bad`; points invert beyond 10.

    As terms of the balance do, it remembers where it was evaluated last.
    """

    def __init__(self, bad: float) -> None:
        self.bad = bad
        self.last = 0.0

    def at(self, x: Unknowns) -> Iterate:
        """The state at a displacement of one node along one axis."""
        u = self.last = float(x.u[0, 0])
        if u > 10.0:
            raise StepFailed("inverted")
        free = 3.0 + u if 0.0 < u < self.bad else abs(1.0 - u / 100.0)
        return Iterate(x, cast(Residual, None), {"momentum": Size(free, 1.0)}, free)


def searched(bad: float, correction: float, patient: bool = True) -> float:
    """Where a line search goes from 0."""
    valley = Valley(bad)
    now = valley.at(Unknowns({"u": np.zeros((1, 1))}))
    moved, shares = Unknowns({"u": np.array([[correction]])}), LINE_SEARCH
    if patient:
        shares = LONG_LINE_SEARCH
    found = corrected(cast(Equations, valley), now, moved, shares, patient)
    assert found.x.u[0, 0] == valley.last
    return valley.last


def test_a_line_search_shortens_until_points_do_not_invert() -> None:
    assert searched(0.0, 8.0) == 8.0
    assert searched(0.0, 600.0) == 600.0 / 64.0  # the first share that is possible
    with pytest.raises(StepFailed, match="inverted"):
        searched(0.0, 2000.0)
    with pytest.raises(StepFailed, match="inverted"):
        searched(0.0, 600.0, patient=False)


def test_a_patient_line_search_takes_the_best_share_if_none_is_better_than_before() -> None:
    assert searched(11.0, 320.0) == 5.0  # of 10 and 5, which are possible
    assert searched(11.0, 40.0, patient=False) == 5.0  # the last one
    assert searched(11.0, 8.0, patient=False) == 1.0
    assert searched(0.0, -8.0) == -8.0 / 64.0  # uphill
