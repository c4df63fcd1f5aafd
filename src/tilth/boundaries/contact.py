# SPDX-License-Identifier: BSD-3-Clause
"""One implicit boundary in one step: where it touches soil, and the forces that it exerts there.

With N the shape functions of a cell, the boundary's internal force is the surface form

    f_a = integral of N_a [traction + P w],    w = sum_b N_b u_b - prescribed displacement,

with the penalty P = 4 / (3 delta) Pi Q Pi, the projector Pi on the constrained directions and the
acoustic tensor Q of the soil (docs/theory/implicit_boundaries.md). The paper's full form adds the
terms of `BandContact`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.boundaries.protocol import Floats
from tilth.coupling import Coupling
from tilth.place import Place

if TYPE_CHECKING:
    from tilth.boundaries.implicit import Implicit, Pose

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Contact:
    """The quadrature points of a boundary that touch soil in one step, ordered by cell.

    Attributes:
        boundary: the boundary.
        chosen: numbers of its terms, shape (n,).
        at: the cells that they act on.
        pose: their place and direction.
        moduli: constrained modulus (capped) and shear modulus of the soil there [stress], (n, 2).
        axisymmetric: whether the hoop counts.
    """

    boundary: Implicit
    chosen: Integers
    at: Place
    pose: Pose
    moduli: Floats
    axisymmetric: bool

    @cached_property
    def penalty(self) -> Floats:
        """P, the stress per slip [stress/length], shape (n, dim, dim)."""
        assert self.boundary.terms is not None
        return np.asarray(
            _core.boundary_penalty(
                np.ascontiguousarray(self.pose.normal),
                np.ascontiguousarray(self.pose.projector),
                self.moduli,
                self.boundary.terms.square[self.chosen],
            )
        )

    @cached_property
    def before(self) -> Floats:
        """What the points carry from the last step, turned into the middle of this one."""
        return turned(self.boundary.carried[self.chosen], self.pose, 0)

    def coupling(self) -> Coupling:
        """Returns the forces as elements of one cell each."""
        dim = self.pose.place.shape[1]
        weight = self.pose.weight
        constant = self.before[:, :dim] - np.einsum("nij,nj->ni", self.penalty, self.pose.increment)
        matrix, force = _core.surface_elements(
            self.at.start,
            self.at.value,
            np.ascontiguousarray(weight[:, None, None] * self.penalty),
            np.ascontiguousarray(weight[:, None] * constant),
        )
        return Coupling(node=self.at.node, matrix=np.asarray(matrix), force=np.asarray(force))

    def after(self, displacement: Floats) -> Floats:
        """Returns what the points carry at the end of a step with this nodal displacement."""
        slip = self.at.interpolate(displacement) - self.pose.increment
        return np.asarray(self.before + np.einsum("nij,nj->ni", self.penalty, slip))

    def nodal_force(self, carried: Floats, nodes: int) -> Floats:
        """Returns the boundary's internal force of what its points carry, shape (nodes, dim)."""
        dim = self.pose.place.shape[1]
        return self.at.scatter(self.pose.weight[:, None] * carried[:, :dim], nodes)

    def commit(self, carried: Floats) -> None:
        """Carries on to the next step; what touches no soil carries nothing."""
        kept = np.zeros_like(self.boundary.carried)
        kept[self.chosen] = turned(carried, self.pose, 1)
        self.boundary.carried = kept


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
