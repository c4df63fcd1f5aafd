# SPDX-License-Identifier: BSD-3-Clause
"""The condition u_r = 0 on the axis of symmetry, wherever soil extends to it.

The user does not declare it. If a grid line lies on r = 0, its nodes are constrained, and those
beyond it, which are active only because domains overlap the axis. Otherwise the grid's displacement
is constrained at r = 0 on each row of nodes, by the penalty and the carried force of the implicit
boundaries (docs/decisions/0017-axis-of-symmetry.md).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers, require_table
from tilth.boundaries.step.axis_rows import AxisRows
from tilth.boundaries.step.conditions import UNCONSTRAINED, Conditions
from tilth.comm import together
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.terms.linear import Coupling

if TYPE_CHECKING:
    from tilth.boundaries.surfaces.boundary import Implicit

GRID_LINE_TOLERANCE = 1e-6
"""Distance from the axis, in cells, up to which a grid line lies on it."""

RADIAL_MOTION_TOLERANCE = 1e-9
"""Largest radial displacement on the axis, relative to the greatest one prescribed in the step."""

PENALTY_FACTOR = 4.0
"""The penalty, in units of Young's modulus over delta: 4 / (3 delta) times a modulus of 3 E."""

RELATIVE_BAND_WIDTH = 1e-3
"""Width delta of the equivalent implicit boundary's band, in smallest edges of a cell."""


@dataclass(frozen=True)
class AxisConstraints:
    """The axis in one step: conditions on its nodes, and a penalty on n rows of nodes beside it.

    Attributes:
        conditions: all essential conditions, including those on the axis.
        row: lattice coordinates along y of the rows that the penalty acts on, shape (n,).
        overlay: of each row, shape (n,).
        node: the two nodes of each row on either side of the axis, shape (n, 2).
        value: their shape functions at r = 0 [-], shape (n, 2).
        stiffness: force per radial displacement at r = 0 [force/length], shape (n,).
        before: force at the start of the step [force], shape (n,).
    """

    conditions: Conditions
    row: Integers
    overlay: Integers
    node: npt.NDArray[np.int32]
    value: Floats
    stiffness: Floats
    before: Floats

    @classmethod
    def without_penalty(cls, conditions: Conditions) -> AxisConstraints:
        """Returns the conditions alone."""
        none, pairs = np.zeros(0), np.zeros((0, 2))
        index = none.astype(np.int64)
        return cls(conditions, index, index, pairs.astype(np.int32), pairs, none, none)

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
    """Constrains the soil on the axis of symmetry; without effect in other kinds of analysis.

    Args:
        model: the declared problem.
        initial: its points at time 0, in the order of their permanent numbers.

    Attributes:
        height: y of the rows with a force at the end of the last step, ascending in each
            overlay [length], shape (n,).
        overlay: of these rows, ascending, shape (n,).
        carried: this force on each row [force], shape (n,).
    """

    def __init__(self, model: Model, initial: MaterialPoints) -> None:
        self._keys = model.boundary_keys()
        self._rows = AxisRows(model, initial) if model.analysis.kind == "axisymmetric" else None
        self.height: Floats = np.zeros(0)
        self.overlay: Integers = np.zeros(0, dtype=np.int64)
        self.carried: Floats = np.zeros(0)

    def heights(self, active: ActiveGrid) -> tuple[Integers, Floats]:
        """Returns the rows of nodes with soil on the axis, and their y [length], (n,) each.

        They are ascending in each overlay.
        """
        if self._rows is None:
            return np.zeros(0, dtype=np.int64), np.zeros(0)
        row, _, _ = self._rows.find(active)
        return row, _height(active.grid, row)

    def constrain(
        self,
        active: ActiveGrid,
        conditions: Conditions,
        boundaries: Sequence[Implicit] = (),
        time: float = 0.0,
    ) -> AxisConstraints:
        """Returns the conditions of a step, and the constraints on the axis.

        All processes call it.

        boundaries: those that can be between soil and axis, at `time`, the start of the step.

        Raises:
            BadInput: a boundary prescribes a radial displacement on the axis.
        """
        if self._rows is None:
            return AxisConstraints.without_penalty(conditions)
        row, overlay, modulus = self._rows.find(active, boundaries, time)
        column, fraction = _columns(active.grid)
        greatest = active.comm.max(float(np.abs(conditions.increment[:, 0]).max(initial=0.0)))
        constrained = np.zeros(active.nodes, dtype=bool)
        beyond = _nodes(active, column - 1, row, overlay)
        constrained[beyond[beyond >= 0]] = True
        if fraction > 0.0:
            conditions = conditions.with_axis(constrained)
            with together(active.comm):
                return self._between(
                    active, conditions, row, overlay, modulus, column, fraction, greatest
                )
        on_axis = _nodes(active, column, row, overlay)
        with together(active.comm):
            one = np.ones((len(row), 1))
            self._refuse_motion(conditions, active, on_axis[:, None], one, greatest)
        constrained[on_axis[on_axis >= 0]] = True
        return AxisConstraints.without_penalty(conditions.with_axis(constrained))

    def _between(
        self,
        active: ActiveGrid,
        conditions: Conditions,
        row: Integers,
        overlay: Integers,
        modulus: Floats,
        column: int,
        fraction: float,
        greatest: float,
    ) -> AxisConstraints:
        """Returns the penalty at r = 0, a fraction of a cell away from the nodes of a column.

        greatest: see `_refuse_motion`.
        """
        grid = active.grid
        nodes = np.stack([_nodes(active, column + k, row, overlay) for k in range(3)], axis=1)
        inactive = nodes[:, 0] < 0  # no soil in the cell on the axis: extrapolated from the next
        pair = np.where(inactive[:, None], nodes[:, 1:], nodes[:, :2])
        width, following = grid.sizes(np.array([[column, 0], [column + 1, 0]]))[:, 0]
        at = np.where(inactive, (fraction - 1.0) * (width / following), fraction)
        value = np.stack([1.0 - at, at], axis=1)
        both_active = (pair >= 0).all(axis=1)
        self._refuse_motion(conditions, active, pair[both_active], value[both_active], greatest)
        free = both_active & ~conditions.constrained[pair, 0].all(axis=1)
        row, overlay = row[free], overlay[free]
        band = RELATIVE_BAND_WIDTH * grid.cell_size.min()
        place = np.stack([np.full(len(row), column), row], axis=1)
        height = grid.sizes_around(place)[:, 1]
        area = np.pi * (width * height)  # the circumference of half a cell, times the row's height
        spacing = np.stack([grid.sizes(place - [0, 1])[:, 1], grid.sizes(place)[:, 1]])
        return AxisConstraints(
            conditions=conditions,
            row=row,
            overlay=overlay,
            node=pair[free].astype(np.int32),
            value=value[free],
            stiffness=PENALTY_FACTOR * modulus[free] / band * area,
            before=self._carried_at(_height(grid, row), overlay, spacing),
        )

    def _carried_at(self, height: Floats, overlay: Integers, spacing: Floats) -> Floats:
        """Returns the forces of the last step's rows within half a spacing [force], otherwise 0.

        spacing: to the rows of nodes below and above [length], shape (2, n).
        """
        found = np.zeros(len(height))
        for number in np.unique(self.overlay):
            own, before = overlay == number, self.overlay == number
            last, carried = self.height[before], self.carried[before]
            below, above = 0.5 * spacing[:, own]
            nearest = np.searchsorted(last, height[own] - below)
            nearest = np.minimum(nearest, len(last) - 1)
            apart = last[nearest] - height[own]
            near = (apart >= -below) & (apart <= above)
            found[own] = np.where(near, carried[nearest], 0.0)
        return found

    def commit(self, step: AxisConstraints, active: ActiveGrid, displacement: Floats) -> None:
        """Stores the forces at the end of a converged step with a displacement (nodes, dim).

        All processes store those of all rows.
        """
        slip = (step.value * displacement[step.node, 0]).sum(axis=1)
        rows = _height(active.grid, step.row), step.overlay, step.before + step.stiffness * slip
        if active.shared is not None:
            own = active.shared.owns(active.key[step.node[:, 0]])
            parts = active.comm.gathered([each[own] for each in rows])
            height, overlay, carried = (np.concatenate(each) for each in zip(*parts, strict=True))
            order = np.lexsort((height, overlay))
            rows = height[order], overlay[order], carried[order]
        self.height, self.overlay, self.carried = rows

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"place": self.height, "overlay": self.overlay, "carried": self.carried}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        require_table(state, increasing="overlay", strictly=False)
        for number in np.unique(state["overlay"]):
            own = {"place": state["place"][state["overlay"] == number]}
            require_table(own, increasing="place", strictly=False)
        self.height, self.overlay, self.carried = state["place"], state["overlay"], state["carried"]

    def _refuse_motion(
        self,
        conditions: Conditions,
        active: ActiveGrid,
        node: Integers,
        value: Floats,
        greatest: float,
    ) -> None:
        """Refuses prescribed radial motion at nodes (n, k) with shape functions at r = 0.

        greatest: prescribed radial displacement of any node [length].
        """
        radial = conditions.increment[:, 0]
        constrained = ((node >= 0) & (conditions.boundary[node, 0] != UNCONSTRAINED)).all(axis=1)
        motion = np.where(constrained, (radial[node] * value).sum(axis=1), 0.0)
        wrong = np.flatnonzero(np.abs(motion) > RADIAL_MOTION_TOLERANCE * greatest)
        if len(wrong):
            nearest = node[wrong[0], value[wrong[0]].argmax()]
            name = conditions.names[conditions.boundary[nearest, 0]]
            raise radial_motion_error(name, self._keys[name], active.position[nearest, 1])


def radial_motion_error(name: str, key: str, height: float) -> BadInput:
    """Returns the error for a boundary that prescribes a radial displacement on the axis.

    key: of the boundary in the case file. height: y of the point [length].
    """
    return BadInput(
        f"boundary {name!r} prescribes a radial displacement at the point (0, {height:g}), but "
        "soil cannot leave the axis of symmetry",
        "leave its motion along x out, or let it end before the axis",
        key=key,
    )


def _columns(grid: Grid) -> tuple[int, float]:
    """Returns the last column of nodes at r <= 0 and the distance of the axis from it, in cells."""
    axis = float(grid.in_cells(np.zeros(2))[0])
    if abs(axis - round(axis)) <= GRID_LINE_TOLERANCE:
        return round(axis), 0.0
    column = int(np.floor(axis))
    return column, float(axis - column)


def _nodes(active: ActiveGrid, column: int, row: Integers, overlay: Integers) -> Integers:
    """Returns the nodes of a column in some rows, -1 where not active, shape (n,)."""
    lattice = np.stack([np.full(len(row), column), row, np.zeros_like(row)], axis=1)
    return active.find(lattice, overlay)


def _height(grid: Grid, row: Integers) -> Floats:
    place = np.zeros((len(row), grid.dim))
    place[:, 1] = row
    return grid.position(place)[:, 1]
