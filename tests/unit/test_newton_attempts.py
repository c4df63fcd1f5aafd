# SPDX-License-Identifier: BSD-3-Clause
"""How a step is tried again: what a case declares of the line search, and contact."""

from __future__ import annotations

import pytest

from tilth.analysis.residual import newton_attempts
from tilth.model import Analysis
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
