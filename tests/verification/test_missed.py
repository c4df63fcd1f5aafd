# SPDX-License-Identifier: BSD-3-Clause
"""The rule for rows that miss their tolerance: neither worse than listed nor listed in vain."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from missed import MARGIN, MISSED, Missed, failures, gone

from tilth.errors import AnalysisFailed
from tilth_verification.comparison import Comparison
from tilth_verification.problems import PROBLEMS
from tilth_verification.run import Row, verified

DOCS = Path(__file__).parents[2] / "docs"

SPREAD, FORCE = "spread, h 1 m", "force at * m, h 1 m"
LISTED = (
    Missed("pile", SPREAD, 0.2),
    Missed("pile", FORCE, 0.3, long=False),
    Missed("wall", "its base", 0.4, short=False),
)


def row(quantity: str, error: float, problem: str = "pile", tolerance: float = 0.1) -> Row:
    found = Comparison(quantity, "", 1.0 + error, 1.0, error, tolerance, "by hand")
    return Row(problem, found, 0.0)


@pytest.mark.parametrize("error", [0.0, 0.1])
def test_a_row_within_its_tolerance_is_no_failure(error: float) -> None:
    assert failures("pile", [row("settlement", error)], LISTED) == []


@pytest.mark.parametrize("error", [0.11, math.inf, math.nan])
def test_a_row_out_of_its_tolerance_is_a_failure(error: float) -> None:
    (found,) = failures("pile", [row("settlement", error)], LISTED)
    assert "'settlement' of problem pile" in found
    assert "tolerance 0.1; by hand" in found


@pytest.mark.parametrize("error", [0.101, 0.2, 0.2199])
def test_a_listed_row_may_miss_its_tolerance_up_to_its_bound(error: float) -> None:
    assert failures("pile", [row(SPREAD, error)], LISTED) == []


@pytest.mark.parametrize("error", [0.2201, 7.0, math.inf, math.nan])
def test_a_listed_row_beyond_its_bound_is_a_failure(error: float) -> None:
    (found,) = failures("pile", [row(SPREAD, error)], LISTED)
    assert f"'{SPREAD}' of problem pile misses its tolerance of 0.1 by more than it did" in found
    assert "0.22 at most" in found


@pytest.mark.parametrize("error", [0.0, 0.1])
def test_a_listed_row_that_passes_is_reported(error: float) -> None:
    (found,) = failures("pile", [row(SPREAD, error)], LISTED)
    assert f"row '{SPREAD}' of problem pile passes now" in found
    assert "take it from the list tests/verification/missed.py and from the table of" in found


def test_a_name_counts_for_its_own_problem_only() -> None:
    (found,) = failures("wall", [row(SPREAD, 0.15, "wall")], LISTED)
    assert "problem wall: 1.15, not 1" in found


@pytest.mark.parametrize(
    ("quantity", "listed"),
    [
        ("force at 0.13 m, h 1 m", True),
        ("force at 1e-05 m, h 1 m", True),
        ("force at depth m, h 1 m", False),
        ("force at m, h 1 m", False),
        ("force at 0.13 m, h 1 mm", False),
        ("a force at 0.13 m, h 1 m", False),
        ("force at 0.13 m, then at 0.2 m, h 1 m", False),
    ],
)
def test_a_computed_number_in_a_name_may_change(quantity: str, listed: bool) -> None:
    assert (failures("pile", [row(quantity, 0.3)], LISTED) == []) == listed


def test_names_that_no_row_has_are_reported_of_complete_runs() -> None:
    rows = [row("settlement", 0.0), row("force at 0.5 m, h 1 m", 0.3)]
    assert failures("pile", rows, LISTED) == []
    (found,) = gone("pile", rows, long=False, missed=LISTED)
    assert f"no row of problem pile is called '{SPREAD}' any more" in found
    rows.append(row(SPREAD, 0.2))
    assert gone("pile", rows, long=False, missed=LISTED) == []


@pytest.mark.parametrize("long", [False, True])
def test_names_are_expected_of_the_runs_that_have_them(long: bool) -> None:
    assert len(gone("pile", [], long=long, missed=LISTED)) == (1 if long else 2)
    assert len(gone("wall", [], long=long, missed=LISTED)) == (1 if long else 0)


def test_an_analysis_that_fails_is_a_failure_and_nothing_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No row after it is reported as gone."""

    def comparisons(long: bool) -> Iterator[Comparison]:
        yield row("settlement", 0.0).comparison
        raise AnalysisFailed("no equilibrium")

    monkeypatch.setitem(PROBLEMS, "pile", comparisons)
    rows = list(verified(["pile"], long=False))
    (found,) = failures("pile", rows, LISTED) + gone("pile", rows, long=False, missed=LISTED)
    assert "no equilibrium" in found


def stored_rows(problem: str) -> list[Row]:
    """The rows of docs/verification.md, which are those of a run without `--long`."""
    keys = ("quantity", "unit", "computed", "reference", "error", "tolerance", "source")
    return [
        Row(problem, Comparison(**{key: entries[key] for key in keys}), 0.0)
        for entries in json.loads((DOCS / "verification.json").read_text(encoding="utf-8"))
        if entries["problem"] == problem
    ]


@pytest.mark.parametrize("problem", PROBLEMS)
def test_the_list_is_that_of_the_page(problem: str) -> None:
    rows = stored_rows(problem)
    assert failures(problem, rows) + gone(problem, rows, long=False) == []


def test_the_list_names_each_row_once_and_the_decision_its_problem() -> None:
    assert MARGIN == 1.1
    assert len({(each.problem, each.quantity) for each in MISSED}) == len(MISSED)
    decision = (DOCS / "decisions" / "0018-multiplier-space.md").read_text(encoding="utf-8")
    for each in MISSED:
        assert each.problem in PROBLEMS
        assert each.short or each.long
        assert 0.0 < each.error < 1.0
        assert f"\n| {each.problem}, " in decision
