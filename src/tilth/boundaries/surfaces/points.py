# SPDX-License-Identifier: BSD-3-Clause
"""Quadrature points of a surface that act on soil in one step, and their motion in the step."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.surfaces.trace import Trace
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.quadrature import PointsInCells


@dataclass(frozen=True)
class Pose:
    """Quadrature points of a boundary in a step: positions at its start, directions at its middle.

    Attributes:
        position: at the start of the step [length], shape (n, dim).
        increment: prescribed displacement in the step [length], shape (n, dim).
        gradient: of the prescribed displacement by `position` [-], shape (n, dim, dim).
        normal: unit, into the soil, shape (n, dim).
        weight: at the start of the step, including 2 pi r in axisymmetry, shape (n,).
        direction: the declared direction, unit, shape (n, dim); None if none is declared.
        projector: on the constrained directions, shape (n, dim, dim).
        rotation: from the start to the middle and from the middle to the end of the step,
            shape (n, dim, dim) each; None for a fixed boundary.
    """

    position: Floats
    increment: Floats
    gradient: Floats
    normal: Floats
    weight: Floats
    direction: Floats | None
    projector: Floats
    rotation: tuple[Floats, Floats] | None

    def increment_at(self, offset: Floats) -> Floats:
        """Returns the prescribed displacement beside the points [length], shape (n, dim).

        offset: from the points [length], shape (n, dim).
        """
        return np.asarray(self.increment + np.einsum("nij,nj->ni", self.gradient, offset))

    def of(self, kept: Flags | Integers) -> Pose:
        """Returns that of the points `kept`, flags of shape (n,) or numbers in their new order."""
        rotation = self.rotation
        return Pose(
            position=self.position[kept],
            increment=self.increment[kept],
            gradient=self.gradient[kept],
            normal=self.normal[kept],
            weight=self.weight[kept],
            direction=None if self.direction is None else self.direction[kept],
            projector=self.projector[kept],
            rotation=None if rotation is None else (rotation[0][kept], rotation[1][kept]),
        )


@dataclass(frozen=True)
class PointsNearSoil:
    """The n quadrature points of a surface that act on soil in one step, ordered by cell.

    Attributes:
        chosen: their numbers among all points of the surface, shape (n,).
        at: the points in the cells of the grid.
        pose: their motion in the step.
        moduli: constrained modulus (capped) and shear modulus of the soil [stress], shape (n, 2).
        axisymmetric: whether the analysis is axisymmetric.
        elastic_share: elastic part of the soil's last strain increment [-], shape (n,).
        square: the factor of the penalty, see `BoundaryQuadrature`, shape (n,).
    """

    chosen: Integers
    at: PointsInCells
    pose: Pose
    moduli: Floats
    axisymmetric: bool
    elastic_share: Floats
    square: Floats

    @cached_property
    def penalty(self) -> Floats:
        """P, the stress per slip [stress/length], shape (n, dim, dim)."""
        return np.asarray(
            _core.boundary_penalty(
                np.ascontiguousarray(self.pose.normal),
                np.ascontiguousarray(self.pose.projector),
                self.moduli,
                self.square,
            )
        )


class ConstrainedPoints(PointsNearSoil, ABC):
    """Points whose slip is constrained by multipliers (`multipliers.py`)."""

    @property
    @abstractmethod
    def constrained_directions(self) -> Floats:
        """Unit vectors along the constrained directions, shape (r, n, dim)."""

    @property
    def trace_of_rows(self) -> Trace | None:
        """The soil's displacement in the rows of the multipliers; None for that in the cells."""
        return None

    def joined(self, multiplier: Integers, vertex: Floats, active: ActiveGrid) -> Integers:
        """Returns the multipliers, (r, n), where points of some have joined others.

        vertex: positions of the vertices, from the grid's origin in cells, shape (m, dim).
        """
        del vertex, active
        return multiplier


def rotated(carried: Floats, pose: Pose, half: int) -> Floats:
    """Returns carried vectors and tensors, (n, columns), rotated with one half of a step's motion.

    carried: vectors in the first dim columns, tensors in the other 9, if any. half: 0 or 1.
    """
    if pose.rotation is None:
        return carried
    dim = pose.position.shape[1]
    rotation = pose.rotation[half]
    result = carried.copy()
    result[:, :dim] = np.einsum("nij,nj->ni", rotation, carried[:, :dim])
    if carried.shape[1] > dim:
        in_space = np.tile(np.eye(3), (len(carried), 1, 1))
        in_space[:, :dim, :dim] = rotation
        tensor = carried[:, dim:].reshape(-1, 3, 3)
        result[:, dim:] = (in_space @ tensor @ np.swapaxes(in_space, 1, 2)).reshape(-1, 9)
    return result
