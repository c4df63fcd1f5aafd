# SPDX-License-Identifier: BSD-3-Clause
"""The lines of a graded grid along one axis: coordinates in cells and back.

`line` has their distances from the grid's origin [length], shape (n,), ascending from 0: line i has
the lattice index i. Beyond the first and the last line the cells next to it go on.
"""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats, Integers


def in_cells(distance: Floats, line: Floats) -> Floats:
    """Returns distances from the origin [length] in cells, of the same shape."""
    below = _cell(np.searchsorted(line, distance, side="right") - 1, line)
    return np.asarray(below + (distance - line[below]) / (line[below + 1] - line[below]))


def distance(cells: Floats, line: Floats) -> Floats:
    """Returns the distances from the origin [length] of coordinates in cells."""
    below = _cell(np.floor(cells).astype(np.int64), line)
    return np.asarray(line[below] + (cells - below) * (line[below + 1] - line[below]))


def size(cell: Integers, line: Floats) -> Floats:
    """Returns the sizes of cells by the lattice index of their lower line [length]."""
    below = _cell(cell, line)
    return np.asarray(line[below + 1] - line[below])


def _cell(cell: Integers, line: Floats) -> Integers:
    return np.clip(cell, 0, len(line) - 2)
