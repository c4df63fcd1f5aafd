# SPDX-License-Identifier: BSD-3-Clause
"""One implicit boundary in one step: its points in contact with soil, and its forces on the soil.

With N the shape functions of a cell, the boundary's internal force is the surface form

    f_a = integral of N_a [traction + P m],    w = sum_b N_b u_b - prescribed displacement,

with m the means of the slip w over the patches of the multipliers (`multipliers.py`), and the
penalty P = 4 / (3 delta) Pi Q Pi with the projector Pi on the constrained directions and the
acoustic tensor Q of the soil (docs/theory/implicit_boundaries.md). `BandConstraint` is the band
form.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.boundaries.surfaces.ends import INSIDE, Ends, without_vertices_near_ends
from tilth.boundaries.surfaces.multipliers import Multipliers, constrained_directions
from tilth.boundaries.surfaces.points import ConstrainedPoints, PointsNearSoil, rotated
from tilth.boundaries.surfaces.trace import Trace
from tilth.mpm.active_grid import ActiveGrid

if TYPE_CHECKING:
    from tilth.boundaries.surfaces.boundary import Implicit

LARGE_MOTION = 5e-4
"""Motion of soil in a step [cells] with which it has moved past a boundary's points."""


@dataclass(frozen=True)
class ImplicitConstraint(PointsNearSoil, ABC):
    """Those of a boundary in contact with soil.

    Attributes:
        boundary: the boundary.
        moved: motion of the soil in the last step [cells], shape (n,).
    """

    boundary: Implicit
    moved: Floats

    @cached_property
    def before(self) -> Floats:
        """Stresses from the last step, rotated to this step's middle [stress], (n, columns)."""
        return rotated(self.boundary.carried[self.chosen], self.pose, 0)

    @abstractmethod
    def after(self, displacement: Floats) -> Floats:
        """Returns the points' stresses at the end of a step, shape (n, columns).

        displacement: of the nodes in the step [length], shape (nodes, dim).
        """

    def nodal_force(self, carried: Floats, nodes: int) -> Floats:
        """Returns the internal force of the points' stresses [force], shape (nodes, dim)."""
        dim = self.pose.position.shape[1]
        return self.at.scatter(self.pose.weight[:, None] * carried[:, :dim], nodes)

    def commit(self, carried: Floats) -> None:
        """Stores the points' stresses for the next step; points without contact get zero."""
        stored = np.zeros_like(self.boundary.carried)
        stored[self.chosen] = rotated(carried, self.pose, 1)
        self.boundary.carried = stored


@dataclass(frozen=True)
class SurfaceConstraint(ImplicitConstraint, ConstrainedPoints):
    """An `ImplicitConstraint` with the surface form.

    Attributes:
        open_ends: ends of the boundary beyond which the soil goes on; None without an end.
        trace: the soil's displacement at the points, on the nodes of the grid; None if it is that
            in the cells.
        offset: from the points to the middles of the parts of which it is the mean [length], shape
            (n, dim).
        multipliers: of this boundary; selected for all boundaries of a step together.
    """

    open_ends: Ends | None = None
    trace: Trace | None = None
    offset: Floats | None = None
    multipliers: Multipliers | None = None

    @property
    def trace_of_rows(self) -> Trace | None:
        """As `ConstrainedPoints.trace_of_rows`."""
        return self.trace

    def joined(self, multiplier: Integers, vertex: Floats, active: ActiveGrid) -> Integers:
        """As `ConstrainedPoints.joined`."""
        if self.open_ends is None or len(self.open_ends.normal) == 0:
            return multiplier
        position, normal = self.pose.position, self.pose.normal
        some = np.zeros(len(vertex), dtype=np.int64)
        some[multiplier] = np.arange(len(position))
        size = self.at.size[self.at.cell]
        beyond = self.open_ends.distance(active.grid.position(vertex), normal[some])
        gone = beyond > -INSIDE * size[some].min(axis=1)
        of_point = active.overlay[self.at.node[:, 0]][self.at.cell]
        return np.stack(
            [
                without_vertices_near_ends(
                    each, gone, position, normal, of_point, float(size.max())
                )
                for each in multiplier
            ]
        )

    @cached_property
    def increment(self) -> Floats:
        """Prescribed displacement where the soil's is taken [length], shape (n, dim)."""
        if self.offset is None:
            return self.pose.increment
        return self.pose.increment_at(self.offset)

    def nodal_force(self, carried: Floats, nodes: int) -> Floats:
        """As `ImplicitConstraint.nodal_force`."""
        if self.trace is None:
            return super().nodal_force(carried, nodes)
        dim = self.pose.position.shape[1]
        return self.trace.scatter(self.pose.weight[:, None] * carried[:, :dim], nodes)

    @property
    def constrained_directions(self) -> Floats:
        """Unit vectors along the constrained directions, shape (r, n, dim)."""
        condition = self.boundary.declared.kind
        return constrained_directions(condition, self.pose.normal, self.pose.direction)

    @cached_property
    def before(self) -> Floats:
        """As `ImplicitConstraint.before`, with averaged tractions where the soil yields.

        The distribution of the traction over a multiplier's patch results from the soil's elastic
        strain. The plastic part of it is shared among the points whose soil yields, so that points
        newly in contact have the same traction as the others, and as far as soil moves past the
        boundary also among those where it is elastic. The force of each patch does not change,
        and in soil that hardly moves tractions do not, once they are uniform where it yields.
        """
        assert self.multipliers is not None
        carried = rotated(self.boundary.carried[self.chosen], self.pose, 0)
        plastic = 1.0 - self.elastic_share
        takes = plastic + self.elastic_share * np.minimum(self.moved / LARGE_MOTION, 1.0)
        return (1.0 - plastic)[:, None] * carried + self.multipliers.shared(carried, plastic, takes)

    def initial_slip(self) -> Floats:
        """Returns the mean slips at zero nodal displacement [length], shape (m,)."""
        assert self.multipliers is not None
        return -self.multipliers.mean(self.increment)

    def after(self, displacement: Floats) -> Floats:
        """As `ImplicitConstraint.after`."""
        assert self.multipliers is not None
        soil = self.at if self.trace is None else self.trace
        traction = self.multipliers.penalty * self.multipliers.mean(
            soil.interpolate(displacement) - self.increment
        )
        return self.before + self.multipliers.distribute(traction)
