# SPDX-License-Identifier: BSD-3-Clause
"""One implicit boundary in one step: where it touches soil, and the forces that it exerts there.

With N the shape functions of a cell, the boundary's internal force is the surface form

    f_a = integral of N_a [traction + P m],    w = sum_b N_b u_b - prescribed displacement,

with m the means of the slip w on the multipliers' patches (`multipliers.py`), and the penalty
P = 4 / (3 delta) Pi Q Pi with the projector Pi on the constrained directions and the acoustic
tensor Q of the soil (docs/theory/implicit_boundaries.md). The paper's full form is
`BandConstraint`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.boundaries.implicit.multipliers import Multipliers, constrained_directions
from tilth.mpm.quadrature import Place

if TYPE_CHECKING:
    from tilth.boundaries.implicit.boundary import Implicit, Pose


@dataclass(frozen=True)
class ImplicitConstraint(ABC):
    """The quadrature points of a boundary that touch soil in one step, ordered by cell.

    Attributes:
        boundary: the boundary.
        chosen: numbers of its quadrature points, shape (n,).
        at: the cells that they act on.
        pose: their place and direction.
        moduli: constrained modulus (capped) and shear modulus of the soil there [stress], (n, 2).
        axisymmetric: whether the hoop counts.
        elastic_share: of the soil's last strain increment at the points [-], shape (n,).
    """

    boundary: Implicit
    chosen: Integers
    at: Place
    pose: Pose
    moduli: Floats
    axisymmetric: bool
    elastic_share: Floats

    @cached_property
    def penalty(self) -> Floats:
        """P, the stress per slip [stress/length], shape (n, dim, dim)."""
        assert self.boundary.quadrature is not None
        return np.asarray(
            _core.boundary_penalty(
                np.ascontiguousarray(self.pose.normal),
                np.ascontiguousarray(self.pose.projector),
                self.moduli,
                self.boundary.quadrature.square[self.chosen],
            )
        )

    @cached_property
    def before(self) -> Floats:
        """What the points carry from the last step, turned into the middle of this one."""
        return turned(self.boundary.carried[self.chosen], self.pose, 0)

    @abstractmethod
    def after(self, displacement: Floats) -> Floats:
        """Returns what the points carry at the end of a step with this nodal displacement."""

    def nodal_force(self, carried: Floats, nodes: int) -> Floats:
        """Returns the boundary's internal force of what its points carry, shape (nodes, dim)."""
        dim = self.pose.place.shape[1]
        return self.at.scatter(self.pose.weight[:, None] * carried[:, :dim], nodes)

    def commit(self, carried: Floats) -> None:
        """Carries on to the next step; what touches no soil carries nothing."""
        kept = np.zeros_like(self.boundary.carried)
        kept[self.chosen] = turned(carried, self.pose, 1)
        self.boundary.carried = kept


@dataclass(frozen=True)
class SurfaceConstraint(ImplicitConstraint):
    """The same with the surface form.

    Attributes:
        multipliers: those of this boundary; chosen for all boundaries of a step together.
    """

    multipliers: Multipliers | None = None

    @property
    def constrained_directions(self) -> Floats:
        """Unit vectors along what the boundary holds, shape (r, n, dim)."""
        condition = self.boundary.declared.condition
        return constrained_directions(condition, self.pose.normal, self.pose.direction)

    @cached_property
    def before(self) -> Floats:
        """As `ImplicitConstraint.before`; where soil flows, the means over this step's patches.

        How the traction is spread over a patch is the mark of the soil's elastic strain; soil that
        flows forgets it, and a point that is new there bears what those around it bear. The force
        of each patch stays.
        """
        assert self.multipliers is not None
        carried = turned(self.boundary.carried[self.chosen], self.pose, 0)
        rest = (1.0 - self.elastic_share)[:, None] * carried
        return carried - rest + self.multipliers.spread(self.multipliers.mean(rest))

    def slip_at_rest(self) -> Floats:
        """Returns the mean slips of a grid that does not move [length], shape (m,)."""
        assert self.multipliers is not None
        return -self.multipliers.mean(self.pose.increment)

    def after(self, displacement: Floats) -> Floats:
        """As `ImplicitConstraint.after`."""
        assert self.multipliers is not None
        slip = self.at.interpolate(displacement) - self.pose.increment
        traction = self.multipliers.penalty * self.multipliers.mean(slip)
        return self.before + self.multipliers.spread(traction)


def turned(carried: Floats, pose: Pose, part: int) -> Floats:
    """Returns carried vectors (and tensors behind them) turned by a half of the step's motion."""
    if pose.turn is None:
        return carried
    dim = pose.place.shape[1]
    turn = pose.turn[part]
    result = carried.copy()
    result[:, :dim] = np.einsum("nij,nj->ni", turn, carried[:, :dim])
    if carried.shape[1] > dim:
        whole = np.tile(np.eye(3), (len(carried), 1, 1))
        whole[:, :dim, :dim] = turn
        tensor = carried[:, dim:].reshape(-1, 3, 3)
        result[:, dim:] = (whole @ tensor @ np.swapaxes(whole, 1, 2)).reshape(-1, 9)
    return result
