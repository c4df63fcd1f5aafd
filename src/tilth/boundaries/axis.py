# SPDX-License-Identifier: BSD-3-Clause
"""The axis of an axisymmetric analysis: u_r = 0 there, wherever soil reaches it.

It is no boundary of the soil and nobody has to declare it. Where a grid line lies on r = 0 its
nodes are constrained, and those beyond it, which only overlapping domains bring to life. Elsewhere
the grid's field is constrained at r = 0 on each row of nodes, by the penalty and the carried force
of the implicit boundaries (docs/decisions/0017-axis-of-symmetry.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.boundaries.axis_rows import AxisRows
from tilth.boundaries.together import NOBODY, Conditions
from tilth.errors import BadInput
from tilth.model import Model
from tilth.mpm.grid import ActiveGrid, Grid
from tilth.mpm.points import MaterialPoints
from tilth.terms.linear import Coupling

ON_LINE = 1e-6
"""A grid line lies on the axis within this share of a cell."""

NEGLIGIBLE = 1e-9
"""Radial displacement, relative to the greatest one prescribed in the step, that counts as none."""

STIFFNESS = 4.0
"""The penalty, in units of Young's modulus over delta: 4 / (3 delta) times a modulus of 3 E."""

DELTA = 1e-3
"""Width delta of the band that the penalty stands for, in smallest edges of a cell."""


@dataclass(frozen=True)
class OnAxis:
    """What the axis holds in one step.

    Attributes:
        conditions: all essential conditions, those of the axis included.
        row: rows of nodes on which the field is constrained between two columns, shape (n,).
        node: the two nodes of each, shape (n, 2).
        value: their shape functions at r = 0 [-], shape (n, 2).
        stiffness: force per radial displacement there [force/length], shape (n,).
        before: force carried over from the last step [force], shape (n,).
    """

    conditions: Conditions
    row: Integers
    node: npt.NDArray[np.int32]
    value: Floats
    stiffness: Floats
    before: Floats

    @classmethod
    def by_nodes(cls, conditions: Conditions) -> OnAxis:
        """Returns what holds nothing but degrees of freedom of the conditions."""
        none, pairs = np.zeros(0), np.zeros((0, 2))
        return cls(conditions, none.astype(np.int64), pairs.astype(np.int32), pairs, none, none)

    def couplings(self) -> list[Coupling]:
        """Returns the force N_a (before + stiffness sum_b N_b u_b) on the nodes of each row."""
        if len(self.row) == 0:
            return []
        n, product = len(self.row), self.value[:, :, None] * self.value[:, None, :]
        matrix, force = np.zeros((n, 2, 2, 2, 2)), np.zeros((n, 2, 2))
        matrix[..., 0, 0] = self.stiffness[:, None, None] * product
        force[..., 0] = self.value * self.before[:, None]
        return [Coupling(node=self.node, matrix=matrix, force=force)]


class Axis:
    """Holds the soil on the axis of symmetry; nothing in other kinds of analysis.

    Args:
        model: the declared problem.
        initial: its points at time 0, in the order of their permanent numbers.

    Attributes:
        place: height of the rows that carry a force over from the last step, ascending [length],
            shape (n,).
        carried: that force, shape (n,).
    """

    def __init__(self, model: Model, initial: MaterialPoints) -> None:
        self._keys = model.boundary_keys()
        self._rows = AxisRows(model, initial) if model.analysis.kind == "axisymmetric" else None
        self.place: Floats = np.zeros(0)
        self.carried: Floats = np.zeros(0)

    def heights(self, active: ActiveGrid) -> tuple[Integers, Floats]:
        """Returns the rows of nodes on which soil reaches the axis, and their y [length], (n,)."""
        if self._rows is None:
            return np.zeros(0, dtype=np.int64), np.zeros(0)
        row, _ = self._rows.find(active)
        return row, _height(active.grid, row)

    def hold(self, active: ActiveGrid, conditions: Conditions) -> OnAxis:
        """Returns the conditions of a step together with what the axis holds in it.

        Raises:
            BadInput: a boundary prescribes a radial displacement on the axis.
        """
        if self._rows is None:
            return OnAxis.by_nodes(conditions)
        row, modulus = self._rows.find(active)
        column, share = _columns(active.grid)
        constrained = np.zeros(active.nodes, dtype=bool)
        beyond = _nodes(active, column - 1, row)
        constrained[beyond[beyond >= 0]] = True
        if share > 0.0:
            conditions = conditions.with_axis(constrained)
            return self._between(active, conditions, row, modulus, column, share)
        on_axis = _nodes(active, column, row)
        self._refuse_motion(conditions, active, on_axis[:, None], np.ones((len(row), 1)))
        constrained[on_axis[on_axis >= 0]] = True
        return OnAxis.by_nodes(conditions.with_axis(constrained))

    def _between(
        self,
        active: ActiveGrid,
        conditions: Conditions,
        row: Integers,
        modulus: Floats,
        column: int,
        share: float,
    ) -> OnAxis:
        """Holds the field at r = 0, a share of a cell away from the nodes of a column."""
        cell = active.grid.cell_size
        nodes = np.stack([_nodes(active, column + k, row) for k in range(3)], axis=1)
        alone = nodes[:, 0] < 0  # no soil reaches the cell of the axis: the next one's field
        pair = np.where(alone[:, None], nodes[:, 1:], nodes[:, :2])
        at = np.where(alone, share - 1.0, share)
        value = np.stack([1.0 - at, at], axis=1)
        known = (pair >= 0).all(axis=1)
        self._refuse_motion(conditions, active, pair[known], value[known])
        free = known & ~conditions.constrained[pair, 0].all(axis=1)
        area = np.pi * cell.prod()  # the circumference of half a cell, times the row's height
        return OnAxis(
            conditions=conditions,
            row=row[free],
            node=pair[free].astype(np.int32),
            value=value[free],
            stiffness=STIFFNESS * modulus[free] / (DELTA * cell.min()) * area,
            before=self._carried_at(_height(active.grid, row[free]), cell[1]),
        )

    def _carried_at(self, height: Floats, spacing: float) -> Floats:
        """Returns what rows of the last step within half a spacing carry, elsewhere 0."""
        if len(self.place) == 0:
            return np.zeros(len(height))
        nearest = np.searchsorted(self.place, height - 0.5 * spacing)
        nearest = np.minimum(nearest, len(self.place) - 1)
        near = np.abs(self.place[nearest] - height) <= 0.5 * spacing
        return np.where(near, self.carried[nearest], 0.0)

    def commit(self, step: OnAxis, active: ActiveGrid, displacement: Floats) -> None:
        """Carries the forces of a converged step on, of a nodal displacement (nodes, dim)."""
        slip = (step.value * displacement[step.node, 0]).sum(axis=1)
        self.place = _height(active.grid, step.row)
        self.carried = step.before + step.stiffness * slip

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a checkpoint must hold."""
        return {"place": self.place, "carried": self.carried}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint."""
        self.place, self.carried = state["place"], state["carried"]

    def _refuse_motion(
        self, conditions: Conditions, active: ActiveGrid, node: Integers, value: Floats
    ) -> None:
        """Refuses prescribed radial motion at nodes (n, k) with shape functions at r = 0."""
        radial = conditions.increment[:, 0]
        constrained = ((node >= 0) & (conditions.holder[node, 0] != NOBODY)).all(axis=1)
        motion = np.where(constrained, (radial[node] * value).sum(axis=1), 0.0)
        wrong = np.flatnonzero(np.abs(motion) > NEGLIGIBLE * np.abs(radial).max(initial=0.0))
        if len(wrong):
            heaviest = node[wrong[0], value[wrong[0]].argmax()]
            name = conditions.names[conditions.holder[heaviest, 0]]
            raise leaves_the_axis(name, self._keys[name], active.position[heaviest, 1])


def leaves_the_axis(name: str, key: str, height: float) -> BadInput:
    """Returns the error of a boundary that prescribes a radial motion on the axis at a height.

    key: where the boundary stands in the case file.
    """
    return BadInput(
        f"boundary {name!r} prescribes a radial displacement at the place (0, {height:g}), but "
        "soil cannot leave the axis of symmetry",
        "leave its motion along x out, or let it end before the axis",
        key=key,
    )


def _columns(grid: Grid) -> tuple[int, float]:
    """Returns the column of nodes on the axis or next beyond it, and how far the axis is from it.

    In cells; 0 if the column lies on the axis.
    """
    place = -grid.origin[0] / grid.cell_size[0]
    if abs(place - round(place)) <= ON_LINE:
        return round(place), 0.0
    column = int(np.floor(place))
    return column, float(place - column)


def _nodes(active: ActiveGrid, column: int, row: Integers) -> Integers:
    """Returns the nodes of a column in some rows, -1 where not active, shape (n,)."""
    return active.find(np.stack([np.full(len(row), column), row, np.zeros_like(row)], axis=1))


def _height(grid: Grid, row: Integers) -> Floats:
    return np.asarray(grid.origin[1] + row * grid.cell_size[1])
