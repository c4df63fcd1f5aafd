# SPDX-License-Identifier: BSD-3-Clause
"""Parameters of tests that take long: as many combinations as meet, the others only with `long`."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product
from typing import Any

import pytest


def long(*values: Any) -> Any:
    """The values of parameters of a test that is run only with `long`."""
    return pytest.param(*values, marks=pytest.mark.long)


def some_of(together: int = 2, **values: Sequence[Any]) -> pytest.MarkDecorator:
    """Parametrises a test with combinations of values; those that add nothing new are `long`.

    The others have each value with each value of any other parameter (`together` 2), or each value
    at least once (`together` 1).
    """
    chosen = cover([len(each) for each in values.values()], together)
    rows = []
    for place in product(*(range(len(each)) for each in values.values())):
        row = [each[i] for each, i in zip(values.values(), place, strict=True)]
        rows.append(pytest.param(*row) if place in chosen else long(*row))
    return pytest.mark.parametrize(tuple(values), rows)


def cover(numbers: Sequence[int], together: int) -> set[tuple[int, ...]]:
    """Few combinations, of numbers below those given, that have all of any `together` of them.

    One after the other, each is the first of those that add most.
    """
    every = list(product(*map(range, numbers)))
    missing = {part for place in every for part in _parts(place, together)}
    chosen = set()
    while missing:
        best = max(every, key=lambda place: len(_parts(place, together) & missing))
        chosen.add(best)
        missing -= _parts(best, together)
    return chosen


def _parts(place: tuple[int, ...], together: int) -> set[tuple[tuple[int, int], ...]]:
    return set(combinations(enumerate(place), together))
