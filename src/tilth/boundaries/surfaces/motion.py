# SPDX-License-Identifier: BSD-3-Clause
"""Prescribed motions of a boundary: its positions at a given factor."""

from __future__ import annotations

import math
from typing import Protocol, cast

import numpy as np

from tilth.arrays import Floats
from tilth.geometry.protocol import Geometry, RoundGeometry
from tilth.model import ImplicitBoundary
from tilth.model.fields import AXES
from tilth.model.user_function import UserFunction

DIFFERENCE_STEP = 1e-6
"""Step of the finite differences for the gradient of a user's motion, in cells."""


class Motion(Protocol):
    """The map x = motion(X, factor) of reference positions X of a boundary; n points."""

    def position(self, reference: Floats, factor: float) -> Floats:
        """Returns x [length], shape (n, dim), for X, shape (n, dim)."""
        ...

    def reference(self, position: Floats, factor: float) -> Floats:
        """Returns X [length], shape (n, dim), for x, shape (n, dim)."""
        ...

    def gradient(self, reference: Floats, factor: float) -> Floats:
        """Returns dx/dX [-], shape (n, dim, dim)."""
        ...


class LinearMotion:
    """Change of radius about the geometry's centre, then rotation, then translation.

    x = c + R(f angle) [c0 + S(f) (X - c0) - c] + f displacement, with S the stretch of the radius,
    c0 its centre and c that of the rotation. With a volume loss V, S = sqrt(1 - f V) for a circle
    or cylinder and the cubic root for a sphere.
    """

    def __init__(self, declared: ImplicitBoundary, geometry: Geometry, dim: int) -> None:
        self._dim = dim
        self._displacement = np.zeros(dim)
        for axis, value in (declared.displacement or {}).items():
            self._displacement[AXES.index(axis)] = value
        self._rotation = declared.rotation
        self._geometry = geometry
        self._declared = declared

    def _linear(self, factor: float) -> tuple[Floats, Floats]:
        """Returns A and b of x = A X + b."""
        matrix, offset = np.eye(self._dim), np.zeros(self._dim)
        if self._declared.radius_change or self._declared.volume_loss:
            geometry = cast(RoundGeometry, self._geometry)  # the schema asks for one
            axes = np.vstack([np.zeros(self._dim), np.eye(self._dim)])
            radial = geometry.radial(axes)  # affine: offset first, then its columns
            stretch = (self._declared.radius(factor) - geometry.radius) / geometry.radius
            matrix = matrix + stretch * (radial[1:] - radial[0]).T
            offset = stretch * radial[0]
        if self._rotation is not None:
            turn = rotation_matrix(self._rotation.angle * factor, self._rotation.axis, self._dim)
            centre = np.asarray(self._rotation.centre)
            matrix, offset = turn @ matrix, centre + turn @ (offset - centre)
        return matrix, offset + factor * self._displacement

    def position(self, reference: Floats, factor: float) -> Floats:
        """As `Motion.position`."""
        matrix, offset = self._linear(factor)
        return np.asarray(reference @ matrix.T + offset)

    def reference(self, position: Floats, factor: float) -> Floats:
        """As `Motion.reference`."""
        matrix, offset = self._linear(factor)
        return np.asarray(np.linalg.solve(matrix, (position - offset).T).T)

    def gradient(self, reference: Floats, factor: float) -> Floats:
        """As `Motion.gradient`."""
        matrix, _ = self._linear(factor)
        return np.broadcast_to(matrix, (len(reference), *matrix.shape))


class UserMotion:
    """x = X + displacement(X, factor) with a user's function."""

    def __init__(self, function: UserFunction, cell_size: float) -> None:
        self._function = function
        self._step = DIFFERENCE_STEP * cell_size

    def position(self, reference: Floats, factor: float) -> Floats:
        """As `Motion.position`."""
        return np.asarray(reference + self._function(reference, factor))

    def reference(self, position: Floats, factor: float) -> Floats:
        """As `Motion.reference`, by Newton's iteration."""
        reference = position.copy()
        for _ in range(20):
            residual = position - self.position(reference, factor)
            if np.abs(residual).max(initial=0.0) < 1e-6 * self._step:
                break
            gradient = self.gradient(reference, factor)
            reference = reference + np.linalg.solve(gradient, residual[..., None])[..., 0]
        return reference

    def gradient(self, reference: Floats, factor: float) -> Floats:
        """As `Motion.gradient`, by central differences."""
        columns = []
        for unit in np.eye(reference.shape[1]):
            forward = self.position(reference + self._step * unit, factor)
            backward = self.position(reference - self._step * unit, factor)
            columns.append((forward - backward) / (2.0 * self._step))
        return np.stack(columns, axis=2)


def make_motion(
    declared: ImplicitBoundary, geometry: Geometry, key: str, cell_size: Floats
) -> Motion:
    """Returns the motion of a declared boundary.

    key: of the user's function in the case file.

    Raises:
        BadInput: the user's function cannot be loaded.
    """
    if declared.motion is None:
        return LinearMotion(declared, geometry, len(cell_size))
    function = UserFunction(declared.motion, key=key, shape=(len(cell_size),))
    return UserMotion(function, float(cell_size.min()))


def rotation_matrix(degrees: float, axis: str | None, dim: int) -> Floats:
    """Returns the rotation by an angle, positive about the axis (z in 2D), shape (dim, dim)."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turned = 2 if axis is None else AXES.index(axis)
    first, second = (turned + 1) % 3, (turned + 2) % 3
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = cosine
    matrix[first, second], matrix[second, first] = -sine, sine
    return matrix[:dim, :dim]


def cofactor(gradient: Floats) -> Floats:
    """Returns the cofactor matrices J F^-T that map area vectors, shape (n, dim, dim)."""
    distinct, count = _distinct(gradient)
    inverse, determinant = np.linalg.inv(distinct), np.linalg.det(distinct)
    found = determinant[:, None, None] * np.swapaxes(inverse, 1, 2)
    return np.broadcast_to(found, (count, *found.shape[1:]))


def rotation_part(gradient: Floats) -> Floats:
    """Returns the rotations of the polar decompositions, shape (n, dim, dim)."""
    distinct, count = _distinct(gradient)
    left, _, right = np.linalg.svd(distinct)
    return np.broadcast_to(left @ right, (count, *distinct.shape[1:]))


def _distinct(gradient: Floats) -> tuple[Floats, int]:
    """Returns the distinct matrices, one if all are broadcast from it, and the total number."""
    same = gradient.strides[0] == 0 and len(gradient) > 0
    return (gradient[:1] if same else gradient), len(gradient)
