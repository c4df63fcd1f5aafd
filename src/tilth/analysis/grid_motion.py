# SPDX-License-Identifier: BSD-3-Clause
"""The background grid of each load step: it is fixed, or follows a boundary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tilth.grid.background import Grid, background_grid
from tilth.model import Model
from tilth.model.fields import AXES
from tilth.model.grading import first_places

if TYPE_CHECKING:
    from tilth.boundaries.surfaces.boundary import Implicit


class GridMotion:
    """The background grid over time.

    Args:
        model: the declared problem.
        boundaries: its implicit boundaries, one of which the grid may follow.
    """

    def __init__(self, model: Model, boundaries: Sequence[Implicit]) -> None:
        self._follow = model.grid.follow
        self._initial = background_grid(model)
        self._first = np.array(first_places(None, model.grid.cell_size, model.dimension))
        if self._follow is not None:
            self._leader = next(b for b in boundaries if b.name == self._follow.boundary)

    @property
    def follows(self) -> bool:
        """Whether the grid moves."""
        return self._follow is not None

    def at(self, time: float) -> Grid:
        """Returns the grid of the step that begins at `time`."""
        if self._follow is None:
            return self._initial
        leader = self._leader
        position = leader.motion.position(np.array([self._follow.place]), leader.factor(time))[0]
        axes = [AXES.index(axis) for axis in self._follow.axes]
        origin = self._initial.origin.copy()
        origin[axes] = position[axes] + self._first[axes]  # places are relative to the point
        return replace(self._initial, origin=origin)
