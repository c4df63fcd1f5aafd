# SPDX-License-Identifier: BSD-3-Clause
"""Affine motion of all active nodes or of the outer nodes, for single-element-like tests.

A node is an inner node if each of the 4 cells per direction around it, two on each side, contains
the centre of a material point. If the outline is convex and the points are less than a cell apart,
the 2 cells next to the node are then full.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.boundaries.protocol import Prescribed
from tilth.grid.keys import lattice_keys
from tilth.model import AffineBoundary
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import ActiveGrid


def outer_nodes(active: ActiveGrid) -> Flags:
    """Returns which active nodes are not inner nodes, shape (nodes,)."""
    outer = np.zeros(active.nodes, dtype=bool)
    dim = active.grid.dim
    for shift in np.ndindex(*(4,) * dim):
        cell = active.lattice.copy()
        cell[:, :dim] += np.array(shift) - 2
        outer |= ~np.isin(lattice_keys(cell, active.overlay), active.occupied)
    return outer


class Affine:
    """Prescribes x = F(t) X on its nodes, with the increment (F(after) F(before)^-1 - I) x."""

    def __init__(self, declared: AffineBoundary, curve: LoadCurve) -> None:
        self.name = declared.name
        self._declared = declared
        self._curve = curve
        self._end = np.array(declared.deformation_gradient)

    def deformation_gradient(self, time: float) -> Floats:
        """Returns F at `time` [-], shape (dim, dim)."""
        factor = self._curve.factor(time)
        identity = np.eye(len(self._end))
        if self._declared.path == "linear":
            return np.asarray(identity + factor * (self._end - identity))
        from scipy.linalg import expm

        return np.asarray(expm(factor * self._logarithm))

    @cached_property
    def _logarithm(self) -> Floats:
        from scipy.linalg import logm

        return np.asarray(logm(self._end).real)

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """Returns the increments of all or the outer nodes from time `before` to `after`."""
        step = self.deformation_gradient(after) @ np.linalg.inv(self.deformation_gradient(before))
        increment = active.position @ (step - np.eye(len(step))).T
        if self._declared.nodes == "all":
            return Prescribed(np.ones(increment.shape, dtype=bool), increment)
        constrained = np.repeat(outer_nodes(active)[:, None], increment.shape[1], axis=1)
        return Prescribed(constrained, np.where(constrained, increment, 0.0))

    def distance_from(self, active: ActiveGrid) -> float:
        """As `Boundary.distance_from`: it acts on nodes wherever they are."""
        return 0.0
