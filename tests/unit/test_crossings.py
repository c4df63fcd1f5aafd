# SPDX-License-Identifier: BSD-3-Clause
"""Polygons and polylines that cross themselves, against exact arithmetic on whole numbers."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from tilth.model.crossings import crosses_itself

Point = tuple[int, int]
Edge = tuple[Point, Point]


def side(a: Point, b: Point, c: Point) -> int:
    """Sign of the area of a triangle."""
    return int(np.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])))


def on(a: Point, b: Point, c: Point) -> bool:
    """Whether c is on the segment a-b."""
    between = all(min(a[i], b[i]) <= c[i] <= max(a[i], b[i]) for i in (0, 1))
    return side(a, b, c) == 0 and between


def meet(one: Edge, other: Edge) -> bool:
    """Whether two segments have a point in common."""
    (a, b), (c, d) = one, other
    proper = side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
    return proper or on(a, b, c) or on(a, b, d) or on(c, d, a) or on(c, d, b)


def expected(points: list[Point], closed: bool) -> bool:
    """Whether edges without a common vertex meet, or an edge goes back on the one before."""
    path = [*points, points[0]] if closed else points
    edges = list(pairwise(path))
    for (i, one), (j, other) in combinations(enumerate(edges), 2):
        if j == i + 1 or (closed and i == 0 and j == len(edges) - 1):
            (a, b), (_, c) = (one, other) if j == i + 1 else (other, one)
            if on(a, b, c) or on(b, c, a):
                return True
        elif meet(one, other):
            return True
    return False


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("number", [3, 4, 5, 6, 9])
def test_random_paths_on_a_lattice(number: int, closed: bool) -> None:
    random = np.random.default_rng(number)
    found = set()
    for _ in range(200):
        points = [(int(x), int(y)) for x, y in random.integers(0, 6, (number, 2))]
        if any(a == b for a, b in zip(points, [*points[1:], points[0]], strict=True)):
            continue
        found.add(expected(points, closed))
        assert crosses_itself(points, closed) == expected(points, closed), points
    assert found == {False, True}


def test_many_vertices_whose_edges_all_overlap_along_x() -> None:
    """The worst case of the search, a comb; one tooth that crosses another is found."""
    y = np.arange(2000.0)
    comb = np.stack([np.where(y % 2, 1e4 + y, 0.0), y], axis=1)
    assert not crosses_itself(comb.tolist(), closed=False)
    comb[1001, 1] = 1500.5
    assert crosses_itself(comb.tolist(), closed=False)
