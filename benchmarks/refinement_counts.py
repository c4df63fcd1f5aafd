# SPDX-License-Identifier: BSD-3-Clause
"""Cells of uniform grids, graded grids and octrees for the same sizes of cells, counted on paper.

The wanted size of a cell grows linearly with the distance from where the soil fails, to a largest
one. A graded grid has along each axis the smallest size that any point of its plane wants; an
octree (a quadtree in the plane) divides the cells that are larger than the size wanted within them.
Prints the counts of docs/decisions/0033-local-refinement.md.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats

GROWTH = 0.15
"""Of the size with the distance [-]: neighbours differ by about 15 %."""


@dataclass(frozen=True)
class Problem:
    """Soil in a box from 0.

    Attributes:
        side: of the box [m].
        finest, largest: sizes of cells [m].
        distance: of places (n, dim) from where the soil fails [m].
    """

    side: tuple[float, ...]
    finest: float
    largest: float
    distance: Callable[[Floats], Floats]

    def size(self, place: Floats) -> Floats:
        """Returns the size wanted at places (n, dim) [m]."""
        return np.minimum(self.finest + GROWTH * self.distance(place), self.largest)


def from_edges(place: Floats) -> Floats:
    """Distance from the edges of a quarter of a square footing of side 1 m on 5 m of soil."""
    across = np.maximum(np.abs(place[:, :2]), 0.5) - 0.5
    inside = 0.5 - place[:, :2].max(axis=1)
    flat = np.where(inside > 0.0, inside, np.hypot(*across.T))
    return np.hypot(flat, place[:, 2] - 5.0)


def from_sphere(place: Floats) -> Floats:
    """Distance from the soil that a sphere of diameter 1 m moves through, from the surface."""
    below = np.maximum(2.2 - place[:, 2], 0.0)
    return np.hypot(np.maximum(np.hypot(*place[:, :2].T) - 0.6, 0.0), below)


PROBLEMS = {
    "strip footing": Problem(
        (5.0, 5.0), 0.0125, 0.6, lambda x: np.hypot(x[:, 0] - 0.5, x[:, 1] - 5.0)
    ),
    "square footing": Problem((5.0, 5.0, 5.0), 0.025, 1.0, from_edges),
    "deep pipe": Problem(
        (3.0, 6.0), 0.0625, 0.4,
        lambda x: np.maximum(np.hypot(x[:, 0], x[:, 1] - 3.0) - 0.9, 0.0),
    ),
    "sphere in 3D": Problem((2.5, 2.5, 2.5), 0.125, 0.5, from_sphere),
}  # fmt: skip


def uniform(problem: Problem) -> float:
    """Cells of the finest size."""
    return float(np.prod([side / problem.finest for side in problem.side]))


def graded(problem: Problem, samples: int = 81) -> float:
    """Cells of a graded grid, the product over the axes of the integral of 1 / size."""
    lines = [np.linspace(0.0, side, samples) for side in problem.side]
    place = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    wanted = problem.size(place.reshape(-1, len(lines))).reshape(place.shape[:-1])
    count = 1.0
    for axis, line in enumerate(lines):
        others = tuple(k for k in range(len(lines)) if k != axis)
        per_length = 1.0 / wanted.min(axis=others)
        count *= float(0.5 * (per_length[1:] + per_length[:-1]) @ np.diff(line))
    return count


def octree(problem: Problem) -> int:
    """Cells of an octree whose roots are a quarter of the shortest side."""
    dim = len(problem.side)
    root = min(problem.side) / 4.0
    numbers = [range(round(side / root)) for side in problem.side]
    low = root * np.array(list(itertools.product(*numbers)), dtype=float)
    inner = np.array(list(itertools.product((0.0, 0.5, 1.0), repeat=dim)))
    corner = np.array(list(itertools.product((0.0, 0.5), repeat=dim)))
    size, count = root, 0
    while len(low):
        probes = (low[:, None] + size * inner).reshape(-1, dim)
        wanted = problem.size(probes).reshape(len(low), -1).min(axis=1)
        divided = size > 1.5 * wanted  # on average cells then have the size wanted
        count += int((~divided).sum())
        low = (low[divided][:, None] + size * corner).reshape(-1, dim)
        size *= 0.5
    return count


def main() -> None:
    """Prints the counts."""
    print(f"{'':16}{'uniform':>12}{'graded':>10}{'octree':>10}{'graded/octree':>15}")
    for name, problem in PROBLEMS.items():
        tensor, tree = graded(problem), octree(problem)
        print(f"{name:16}{uniform(problem):12,.0f}{tensor:10,.0f}{tree:10,}{tensor / tree:15.1f}")


if __name__ == "__main__":
    main()
