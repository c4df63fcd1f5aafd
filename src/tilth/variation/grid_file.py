# SPDX-License-Identifier: BSD-3-Clause
"""Values on a regular grid in a CSV file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.fields import AXES
from tilth.variation.csv_file import read_csv
from tilth.variation.tables import ROUND_OFF, place_text


@dataclass(frozen=True)
class RegularGrid:
    """Values at the crossings of a grid's lines.

    Attributes:
        axes: numbers of the axes of the grid, in the order of the file's columns.
        lines: increasing coordinates along each of them [length].
        value: one axis for each of `axes`.
    """

    axes: tuple[int, ...]
    lines: tuple[Floats, ...]
    value: Floats

    def at(self, position: Floats, key: str, file: str) -> Floats:
        """Returns the values at positions (n, dim), linear between the grid's lines, shape (n,).

        Raises:
            BadInput: a position outside the grid, with its place; `key` and `file` are named.
        """
        from scipy.interpolate import RegularGridInterpolator

        columns = []
        for axis, lines in zip(self.axes, self.lines, strict=True):
            at, first, last = position[:, axis], lines[0], lines[-1]
            tolerance = ROUND_OFF * (last - first)
            outside = np.flatnonzero((at < first - tolerance) | (at > last + tolerance))
            if len(outside):
                raise BadInput(
                    f"the material point at {place_text(position[outside[0]])} is outside the "
                    f"grid, which goes from {AXES[axis]} = {first:.6g} to {last:.6g} "
                    f"({len(outside)} of {len(at)} points are outside)",
                    "give a grid that covers the soil",
                    key=key,
                    value=file,
                )
            columns.append(at.clip(first, last))
        interpolator = RegularGridInterpolator(self.lines, self.value, method="linear")
        return np.asarray(interpolator(np.column_stack(columns)))


def read_grid(
    file: str,
    dimension: int,
    key: str,
    value_names: tuple[str, ...] = ("value",),
    or_else: str = "",
) -> RegularGrid:
    """Reads a grid: a line with the names of the axes and "value", then a row for each crossing.

    Args:
        file: path of the .csv file.
        dimension: axes that the file may name, from the first one.
        key: of the entry in the case file, for messages.
        value_names: names that the last column may have.
        or_else: what else may be done with rows that are no grid, for the message.

    Raises:
        BadInput: the file cannot be read, or has not the value of each crossing once.
    """

    def refused(problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=key, value=file)

    known = AXES[:dimension]

    def accepted(names: list[str]) -> bool:
        axes = {name for name in names[:-1] if name in known}
        return bool(axes) and len(axes) == len(names) - 1 and names[-1] in value_names

    example = ",".join((*known, value_names[0]))
    names, table = read_csv(file, key, example, "each crossing", accepted)
    axes = [AXES.index(name) for name in names[:-1]]
    return _gridded(tuple(axes), table, refused, or_else)


def _gridded(
    axes: tuple[int, ...], table: Floats, refused: Callable[[str, str], BadInput], or_else: str
) -> RegularGrid:
    """Returns the grid of a table of coordinates and values."""
    found = [np.unique(column, return_inverse=True) for column in table[:, :-1].T]
    lines = tuple(coordinates for coordinates, _ in found)
    shape = tuple(len(coordinates) for coordinates in lines)
    size = " x ".join(str(length) for length in shape)
    if min(shape) < 2:
        short = AXES[axes[shape.index(min(shape))]]
        raise refused(
            f"has a single coordinate along {short}",
            f"give at least two, or leave out the column {short}",
        )
    number = np.ravel_multi_index(tuple(index for _, index in found), shape)
    count = np.bincount(number, minlength=int(np.prod(shape)))
    if (count != 1).any():
        wrong = int(np.flatnonzero(count != 1)[0])
        place = place_text(
            np.array([x[i] for x, i in zip(lines, np.unravel_index(wrong, shape), strict=True)])
        )
        times = "no value" if count[wrong] == 0 else f"{count[wrong]} values"
        raise refused(
            f"is no regular grid: its coordinates have {size} crossings, but it has {len(table)} "
            f"rows, and {times} at {place}",
            f"give one row for each combination of the coordinates{or_else}",
        )
    value = np.empty(len(table))
    value[number] = table[:, -1]
    return RegularGrid(axes, lines, value.reshape(shape))
