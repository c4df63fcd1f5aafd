# SPDX-License-Identifier: BSD-3-Clause
"""How the run-out is read, and rows that fail where sand is lost, moves or runs too far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tilth_verification import column_collapse
from tilth_verification.column_collapse import Deposit, front


def test_the_front_of_a_wedge() -> None:
    """The share 1 - (1 - x)^2 of a triangle of length 1 lies up to x; a few points do not count."""
    x = (np.arange(200_000) + 0.5) / 200_000
    expected = 1.0 - np.sqrt(1.0 - column_collapse.SHARE)
    assert front(x, 1.0 - x) == pytest.approx(expected, abs=1e-4)
    assert front(np.append(x, 9.0), np.append(1.0 - x, 10.0)) == pytest.approx(expected, abs=1e-2)


def test_the_front_does_not_depend_on_the_order() -> None:
    random = np.random.default_rng(3)
    place, volume = random.uniform(size=500), random.uniform(0.5, 1.0, size=500)
    order = random.permutation(500)
    assert front(place[order], volume[order]) == front(place, volume)


@pytest.mark.parametrize(
    ("change", "missed"),
    [
        ({}, ""),
        ({"run_out": 1.53}, "run-out"),
        ({"run_out": 0.88}, "run-out"),
        ({"depth": 0.3}, "depth of the lowest point in the base"),
        ({"motion": 0.002}, "kinetic energy at the end over the potential energy"),
    ],
)
def test_rows_fail_where_they_must(
    change: dict[str, float], missed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = replace(Deposit(1.2, 0.0, 0.0), **change)
    monkeypatch.setattr(column_collapse, "collapse", lambda model, width: found)
    rows = list(column_collapse.comparisons(long=False))
    expected = [f"{missed}, plane, a 1"] if missed else []
    assert [row.quantity for row in rows if not row.passed] == expected


def test_the_fits_are_steeper_below_their_change() -> None:
    """At 1 and 4, by hand."""
    fits = column_collapse.plane_fit, column_collapse.round_fit
    assert [fit(1.0) for fit in fits] == pytest.approx([1.2, 1.24])
    assert [fit(4.0) for fit in fits] == pytest.approx([4.7877, 3.2], rel=1e-4)
