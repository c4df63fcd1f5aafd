# SPDX-License-Identifier: BSD-3-Clause
"""How the run-out is read, and rows that fail where sand is lost, moves or runs too far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tilth.verification import column_collapse
from tilth.verification.column_collapse import Deposit, front


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
        ({"run_out": 0.76}, "run-out, plane, a 0.5"),
        ({"run_out": 0.44}, "run-out, plane, a 0.5"),
        ({"depth": 0.3}, "depth of the lowest point in the base, plane, a 0.5"),
        ({"motion": 0.002}, "kinetic energy at the end over the potential energy, plane, a 0.5"),
    ],
)
def test_rows_fail_where_they_must(
    change: dict[str, float], missed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = replace(Deposit(0.6, 0.0, 0.0), **change)
    monkeypatch.setattr(column_collapse, "collapse", lambda model, width: found)
    rows = list(column_collapse.comparisons(long=False))
    assert [row.quantity for row in rows if not row.passed] == ([missed] if missed else [])


def test_an_exponent_is_that_of_its_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    def collapse(model, width):
        height = model.bodies[0].shape.upper[1]
        return Deposit(1.9 * height**0.8, 0.0, 0.0)

    monkeypatch.setattr(column_collapse, "collapse", collapse)
    (row,) = column_collapse.tall(column_collapse.PLANE, "plane", 2.0 / 3.0)
    assert row.computed == pytest.approx(0.8)
    assert row.passed
