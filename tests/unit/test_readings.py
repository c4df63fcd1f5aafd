# SPDX-License-Identifier: BSD-3-Clause
"""Few combinations of parameters still have all pairs of values."""

from itertools import combinations, product

import pytest
from readings import cover, some_of


@pytest.mark.parametrize(("numbers", "most"), [((3, 4, 2), 12), ((3, 4, 4, 2, 2), 20), ((2, 3), 6)])
def test_every_pair_of_values_meets(numbers: tuple[int, ...], most: int) -> None:
    chosen = cover(numbers, 2)
    assert len(chosen) <= most
    for (a, of_a), (b, of_b) in combinations(enumerate(numbers), 2):
        assert {(place[a], place[b]) for place in chosen} == set(product(range(of_a), range(of_b)))


def test_every_value_is_taken_once() -> None:
    assert len(cover((3, 4, 2), 1)) == 4


def test_the_others_are_long() -> None:
    rows = some_of(1, kind=["a", "b"], basis=["c", "d", "e"]).mark.args[1]
    assert len(rows) == 6
    assert sum(not row.marks for row in rows) == 3
