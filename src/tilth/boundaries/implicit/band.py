# SPDX-License-Identifier: BSD-3-Clause
"""The band form of an implicit boundary: the method's full K1, K2 + K2^T and K3.

Trial and test functions are D u_g + u_a and D v_g with D = I - (1 - d) Pi. With the slip
w = u_g - u_a, its gradient, and the elastic stress C : e of a strain e, a point of the band exerts

    f_a = N_a t + (D C : (d' Pi w (x) m)) grad N_a,
    t = d'^2 Pi Q Pi w + d' Pi (C : (D grad w)) m,

the integrand of K3, K2 and K2^T (Kumar et al. 2008; docs/theory/implicit_boundaries.md). K1 is the
stiffness of the material points.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.implicit.constraint import ImplicitConstraint
from tilth.terms.linear import Coupling

LEAST_ALIGNED_COMPONENT = 1.0 - 1e-9
"""Least value of the largest component of a unit normal that is parallel to a grid axis."""


class BandConstraint(ImplicitConstraint):
    """The quadrature points of a boundary's band that are in contact with soil in one step."""

    def may_lock(self) -> bool:
        """Returns whether it may lock the adjacent soil: it moves or is oblique to the grid."""
        aligned = np.abs(self.pose.normal).max(axis=1) > LEAST_ALIGNED_COMPONENT
        return self.boundary.declared.is_moving or not bool(aligned.all())

    def _elastic(self, strain: Floats) -> Floats:
        """Returns C : e of displacement gradients (n, ..., 3, 3) [stress]."""
        constrained, shear = self.moduli.T
        shape = (-1,) + (1,) * (strain.ndim - 1)
        trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
        return np.asarray(
            (constrained - 2.0 * shear).reshape(shape) * trace * np.eye(3)
            + shear.reshape(shape) * (strain + np.swapaxes(strain, -1, -2))
        )

    @cached_property
    def _at_points(self) -> tuple[Floats, Floats, Floats, Floats]:
        """d', Pi, D and m in three dimensions: (n,), (n, 3, 3), (n, 3, 3), (n, 3)."""
        n, dim = self.pose.position.shape
        assert self.boundary.quadrature is not None
        projector, normal = np.zeros((n, 3, 3)), np.zeros((n, 3))
        projector[:, :dim, :dim] = self.pose.projector
        normal[:, :dim] = self.pose.normal
        d = self.boundary.quadrature.d[self.chosen]
        matrix = np.eye(3) - (1.0 - d)[:, None, None] * projector
        return self.boundary.quadrature.d_prime[self.chosen], projector, matrix, normal

    @cached_property
    def _gradient(self) -> Floats:
        """Displacement gradient per nodal displacement, shape (n, 2^dim, dim, 3, 3)."""
        n, nodes = self.at.value.shape
        dim = self.pose.position.shape[1]
        operator = np.zeros((n, nodes, dim, 3, 3))
        for k in range(dim):
            operator[:, :, k, k, :dim] = self.at.gradient
        if self.axisymmetric:
            operator[:, :, 0, 2, 2] = self.at.value / np.abs(self.pose.position[:, :1])
        return operator

    def _carried(self, slip: Floats, gradient: Floats) -> Floats:
        """Returns t and the stress of the slip, (n, ..., dim + 9), for slips (n, ..., dim)."""
        d_prime, projector, matrix, normal = self._at_points
        dim = slip.shape[-1]
        extra = (None,) * (slip.ndim - 2)
        at = (slice(None), *extra)
        slip3 = np.zeros((*slip.shape[:-1], 3))
        slip3[..., :dim] = slip
        constrained = np.einsum("n...ij,n...j->n...i", projector[at], slip3)
        scaled = d_prime.reshape(-1, *(1,) * (slip.ndim - 1))
        jump = scaled[..., None] * constrained[..., :, None] * normal[at][..., None, :]
        stress = self._elastic(jump)
        consistent = self._elastic(np.einsum("n...ij,n...jk->n...ik", matrix[at], gradient))
        traction = np.einsum("n...ij,n...jk,n...k->n...i", projector[at], consistent, normal[at])
        penalty = np.einsum("n...ij,n...j->n...i", self.penalty[at], slip)
        t = penalty + scaled * traction[..., :dim]
        return np.concatenate([t, stress.reshape(*slip.shape[:-1], 9)], axis=-1)

    def _force(self, carried: Floats) -> Floats:
        """Returns the nodal forces of carried stresses, (n, ..., dim + 9) -> (n, 2^dim, ...)."""
        _, _, matrix, _ = self._at_points
        dim = self.pose.position.shape[1]
        extra = (None,) * (carried.ndim - 2)
        stress = carried[..., dim:].reshape(*carried.shape[:-1], 3, 3)
        stress = np.einsum("n...ij,n...jk->n...ik", matrix[(slice(None), *extra)], stress)
        force = np.einsum("na,n...k->na...k", self.at.value, carried[..., :dim])
        force = force + np.einsum("nakij,n...ij->na...k", self._gradient, stress)
        weight = self.pose.weight.reshape(-1, *(1,) * (force.ndim - 1))
        return np.asarray(weight * force)

    def coupling(self) -> Coupling:
        """Returns the forces of the slip in the step as elements of one cell each."""
        n, nodes = self.at.value.shape
        dim = self.pose.position.shape[1]
        unit = self.at.value[:, :, None, None] * np.eye(dim)  # slip per nodal displacement
        slips = unit.reshape(n, nodes * dim, dim)
        columns = self._carried(slips, self._gradient.reshape(n, nodes * dim, 3, 3))
        matrix = self._force(columns).reshape(n, nodes, nodes, dim, dim)
        matrix = np.moveaxis(matrix, 3, 4)  # (n, a, b, component of a, component of b)
        constant = self._force(self._carried(*self._prescribed()))
        starts = self.at.start[:-1]
        return Coupling(
            node=self.at.node,
            matrix=np.add.reduceat(matrix, starts, axis=0),
            force=np.add.reduceat(constant, starts, axis=0),
        )

    def _prescribed(self) -> tuple[Floats, Floats]:
        """Returns the slip and its gradient at zero nodal displacement, (n, dim) and (n, 3, 3)."""
        n, dim = self.pose.position.shape
        gradient = np.zeros((n, 3, 3))
        gradient[:, :dim, :dim] = self.pose.gradient
        if self.axisymmetric:
            gradient[:, 2, 2] = self.pose.increment[:, 0] / np.abs(self.pose.position[:, 0])
        return -self.pose.increment, -gradient

    def after(self, displacement: Floats) -> Floats:
        """As `ImplicitConstraint.after`."""
        nodal = displacement[self.at.node[self.at.cell]]
        slip, gradient = self._prescribed()
        slip = slip + self.at.interpolate(displacement)
        gradient = gradient + np.einsum("nakij,nak->nij", self._gradient, nodal)
        return self.before + self._carried(slip, gradient)

    def nodal_force(self, carried: Floats, nodes: int) -> Floats:
        """As `ImplicitConstraint.nodal_force`."""
        force = np.zeros((nodes, self.pose.position.shape[1]))
        np.add.at(force, self.at.node[self.at.cell], self._force(carried))
        return force
