# SPDX-License-Identifier: BSD-3-Clause
"""Cell sizes that vary along an axis, given at places: the grid lines between these.

From one place to the next the cell sizes form a geometric progression. A distance L over which they
go from a to b has n = L ln(b/a) / (b - a) cells (L / a if a = b), rounded to a whole number of at
least 1, with the ratio q = (b/a)^(1/n) from each to the next. Its lines are at L (q^i - 1) /
(q^n - 1) from the first place, so that one passes through each place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from pydantic import PlainValidator
from pydantic_core import PydanticCustomError

from tilth import grid_lines
from tilth.arrays import Floats, make_read_only
from tilth.errors import Problem
from tilth.model.fields import (
    AXES,
    MOST_ROWS,
    Axis,
    as_list,
    positive,
    positive_per_direction,
    real,
)
from tilth.model.problems import reject, rejection

LARGEST_RATIO = 1.5
"""Ratio of the sizes of neighbouring cells, at most."""

LARGEST_CHANGE = 1.0 / 3.0
"""By this part the sizes of the cells may differ from those that were given, at most."""

MOST_LINES = 100_000
"""Cells between the first and the last place, at most."""

RESOLUTION = 1e-9
"""Size of a cell, at least, over the greatest coordinate of a place."""

ROUND_OFF = 1e-9
"""Relative excess of a ratio that is round-off."""

Places = tuple[tuple[float, float], ...]
"""Rows (place, cell size) [length], the places ascending."""

EXAMPLE = "give rows (place, size) such as [[0, 0.05], [1, 0.05], [5, 0.5]]"


def _size_per_axis(value: Any) -> float | Places:
    if (rows := as_list(value)) is None:
        return positive(value)
    pairs = [as_list(row) or [] for row in rows]
    if any(len(pair) != 2 for pair in pairs):
        raise reject("must be a number, or a list of rows (place, size)", EXAMPLE)
    if len(rows) < 2:
        raise reject("needs at least two rows", EXAMPLE)
    if len(rows) > MOST_ROWS:
        raise reject(f"has {len(rows):,} rows", f"give at most {MOST_ROWS:,}")
    found, problems = [], []
    for i, (place, size) in enumerate(pairs):
        try:
            found.append((real(place), positive(size)))
        except PydanticCustomError as error:
            refused = (error.context or {})["problems"]
            problems += [Problem(f"[{i}]", p.problem, p.remedy, rows[i]) for p in refused]
    if problems:
        raise rejection(problems)
    places = tuple(found)
    for (before, _), (after, _) in pairwise(places):
        if after <= before:
            what = f"the places must increase from row to row, but {after:g} follows {before:g}"
            raise reject(what, "sort the rows by place and keep one row per place")
    if problem := next(_grading_problems(places), None):
        raise rejection([problem])
    return places


def _grading_problems(places: Places) -> Iterator[Problem]:
    """Yields too many cells, cells of other sizes than given, and neighbours too different."""
    numbers = [_cells(one, other) for one, other in pairwise(places)]
    if sum(numbers) > MOST_LINES:
        what = f"needs {sum(numbers):.3g} cells between the first and the last place"
        yield Problem("", what, f"at most {MOST_LINES:,} are possible: use larger cells")
        return
    for (one, other), number in zip(pairwise(places), numbers, strict=True):
        change = number / max(round(number), 1)
        if not 1.0 - LARGEST_CHANGE <= change <= 1.0 + LARGEST_CHANGE:
            what = (
                f"between the places {one[0]:g} and {other[0]:g} there is room for {number:.2g} "
                f"cells with the sizes {one[1]:g} and {other[1]:g} there; those of a whole number "
                "of cells would differ from these by more than a third"
            )
            yield Problem("", what, "move these places apart, or give other sizes there")
            return
    line = line_of(places) + places[0][0]
    size = np.diff(line)
    if size.min() < RESOLUTION * np.abs(line).max():
        what = f"a cell of {min(size for _, size in places):g} is too small for the places"
        yield Problem("", what, "use larger cells, or places nearer to 0")
        return
    ratio = np.maximum(size[1:] / size[:-1], size[:-1] / size[1:])
    worst = int(ratio.argmax()) if len(ratio) else -1
    if worst >= 0 and ratio[worst] > LARGEST_RATIO * (1.0 + ROUND_OFF):
        what = (
            f"at {line[worst + 1]:.6g} a cell of {size[worst]:.4g} is beside one of "
            f"{size[worst + 1]:.4g}, a ratio of more than {LARGEST_RATIO:g}"
        )
        remedy = "give more distance between places of such different sizes, or sizes that are "
        yield Problem("", what, remedy + "closer to each other")


def _cells(one: tuple[float, float], other: tuple[float, float]) -> float:
    """Returns the number of cells between two places with their sizes, not rounded."""
    (start, first), (end, last) = one, other
    growth = math.log(last / first)
    mean = first if abs(growth) < ROUND_OFF else (last - first) / growth
    return (end - start) / mean


@lru_cache(maxsize=64)
def line_of(places: Places) -> Floats:
    """Returns the distances of the grid lines from the first place [length], shape (n,)."""
    parts = [np.zeros(1)]
    for one, other in pairwise(places):
        number = max(round(_cells(one, other)), 1)
        growth = math.log(other[1] / one[1])
        share = np.arange(1, number + 1) / number
        if abs(growth) >= ROUND_OFF:
            share = np.expm1(share * growth) / math.expm1(growth)
        start, end = one[0] - places[0][0], other[0] - places[0][0]
        parts += [start + share[:-1] * (end - start), np.array([end])]
    line = np.concatenate(parts)
    make_read_only(line)
    return line


def _cell_size(value: Any) -> Any:
    """Returns a number, one per direction, or for each axis a number or rows (place, size)."""
    if not isinstance(value, Mapping):
        return positive_per_direction(value)
    found: dict[Axis, float | Places] = {}
    problems = []
    for axis, each in value.items():
        if axis not in AXES:
            remedy = 'choose from "x", "y", "z"'
            problems.append(Problem(str(axis), "names no axis", remedy, each))
            continue
        try:
            found[axis] = _size_per_axis(each)
        except PydanticCustomError as error:
            refused = (error.context or {})["problems"]
            problems += [
                Problem(f"{axis}{p.key}", p.problem, p.remedy, p.value if p.key else each)
                for p in refused
            ]
    if problems:
        raise rejection(problems)
    return {axis: found[axis] for axis in AXES if axis in found}


CellSize = Annotated[
    float | Sequence[float] | Mapping[Axis, float | Sequence[Sequence[float]]],
    PlainValidator(_cell_size),
]
"""Edge lengths of cells: the same everywhere, or along an axis given at places."""


def along_axes(cell_size: Any, dimension: int) -> tuple[float | Places, ...]:
    """Returns the size of cells along each axis: a number, or rows (place, size)."""
    if isinstance(cell_size, Mapping):
        return tuple(cell_size[axis] for axis in AXES[:dimension])
    if isinstance(cell_size, Sequence):
        return tuple(cell_size)
    return (cell_size,) * dimension


def first_places(
    origin: Sequence[float] | None, cell_size: Any, dimension: int
) -> tuple[float, ...]:
    """Returns where the line with the index 0 is along each axis [length].

    It is the first place, or the declared origin along a uniform axis; zero if not declared.
    """
    found = list(origin or (0.0,) * dimension)
    for k, size in enumerate(along_axes(cell_size, dimension)):
        if isinstance(size, tuple):
            found[k] = size[0][0]
    return tuple(found)


def smallest(size: float | Places) -> float:
    """Returns the size of the smallest cell along an axis [length]."""
    return float(np.diff(line_of(size)).min()) if isinstance(size, tuple) else size


def largest(size: float | Places) -> float:
    """Returns the size of the largest cell along an axis [length]."""
    return float(np.diff(line_of(size)).max()) if isinstance(size, tuple) else size


@dataclass(frozen=True)
class GridAxis:
    """The grid lines of one axis.

    Attributes:
        origin: coordinate of the line with the index 0 [length].
        size: of the smallest cell [length].
        line: distances of the lines from the origin (`tilth/grid_lines.py`); empty if uniform.
    """

    origin: float
    size: float
    line: Floats

    def in_cells(self, coordinate: float) -> float:
        """Returns a coordinate [length] in cells: index of the line below plus a share."""
        distance = coordinate - self.origin
        if len(self.line) == 0:
            return distance / self.size
        return float(grid_lines.in_cells(np.asarray(distance), self.line))

    def coordinate(self, line: int) -> float:
        """Returns the coordinate of the line with this index [length]."""
        if len(self.line) == 0:
            return self.origin + line * self.size
        return self.origin + float(grid_lines.distance(np.asarray(float(line)), self.line))

    def size_at(self, coordinate: float) -> float:
        """Returns the size of the cell at a coordinate [length]."""
        if len(self.line) == 0:
            return self.size
        cell = np.asarray(math.floor(self.in_cells(coordinate)))
        return float(grid_lines.size(cell, self.line))
