# SPDX-License-Identifier: BSD-3-Clause
"""Inertia of a rigid body that is free to move (docs/theory/inertia.md, "Rigid bodies").

The centre of mass moves as soil does (terms/inertia.py). Angular velocity Omega and acceleration
are in the frame of the body, where its tensor of inertia I is constant. With R the rotation before
the step and v the rotation vector of the step, R' = exp(v) R, so that V = R^T v takes the part of
the displacement (Bruels and Cardona 2010), and the moment is

    m = R' (I Omega_dot' + Omega' x I Omega').
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.boundaries.contact.rotation import DIFFERENCE, left_jacobian, rotation_by
from tilth.model import RigidBody
from tilth.terms.inertia import Motion, TimeStep

NAMES = ("velocity", "acceleration", "algorithmic")


class BodyInertia:
    """Motion and inertia of a rigid body.

    Args:
        mass: [mass].
        moments: principal moments of inertia about the centre [mass length^2], (1,) or (3,).
        velocity: of the centre at the start [length/time], shape (dim,).
        angular_velocity: at the start [rad/time], shape (1,) or (3,).

    Attributes:
        motion: velocity and accelerations of the centre, then of the rotation in the frame of the
            body, shape (dim + 1 or 3,) each.
    """

    def __init__(
        self, mass: float, moments: Floats, velocity: Floats, angular_velocity: Floats
    ) -> None:
        self._mass, self._moments = mass, moments
        first = np.concatenate([velocity, angular_velocity])
        zero = np.zeros_like(first)
        self.motion = Motion(first, zero, zero)
        self._dim = len(velocity)

    @classmethod
    def of(cls, declared: RigidBody, dim: int) -> BodyInertia:
        """Returns that of a declared body; components without mass are prescribed."""
        turns = 1 if dim == 2 else 3
        moments = np.broadcast_to(np.array(declared.moments_of_inertia or 0.0), (turns,))
        spin = np.broadcast_to(np.array(declared.angular_velocity or 0.0), (turns,))
        velocity = np.zeros(dim) if declared.velocity is None else np.array(declared.velocity)
        return cls(declared.mass or 0.0, np.array(moments), velocity, np.array(spin))

    def force(self, increments: Floats, rotation: Floats, step: TimeStep) -> Floats:
        """Returns force and moment that the motion of a step needs at its end, (dim + 1 or 3,).

        Work-conjugate to the increments.

        Args:
            increments: translation [length] and rotation vector [rad] of the step.
            rotation: of the body before the step, shape (dim, dim).
            step: its size and method.
        """
        dim, after = self._dim, self._after(increments, rotation, step)
        translation = self._mass * after.acceleration[:dim]
        spin = after.velocity[dim:]
        moment = self._moments * after.acceleration[dim:]
        if dim == 3:
            vector = increments[dim:]
            moment = moment + np.cross(spin, self._moments * spin)
            moment = left_jacobian(vector).T @ rotation_by(vector) @ rotation @ moment
        return np.concatenate([translation, moment])

    def stiffness(self, increments: Floats, rotation: Floats, step: TimeStep) -> Floats:
        """Returns the derivative of `force` by the increments."""
        dim, total = self._dim, len(increments)
        _, by_increment = step.integration.derivatives(step.size)
        whole = np.zeros((total, total))
        whole[:dim, :dim] = self._mass * by_increment * np.eye(dim)
        if dim == 2:
            whole[dim:, dim:] = np.diag(self._moments * by_increment)
            return whole
        for j in range(dim, total):
            unit = DIFFERENCE * np.eye(total)[j]
            forward = self.force(increments + unit, rotation, step)
            backward = self.force(increments - unit, rotation, step)
            whole[dim:, j] = (forward - backward)[dim:] / (2.0 * DIFFERENCE)
        return whole

    def guess(self, rotation: Floats, step: TimeStep) -> Floats:
        """Returns the increments of a step without a change of the acceleration."""
        dim, before = self._dim, self._before(step)
        moved = step.size * before.velocity + 0.5 * step.size**2 * before.algorithmic
        if dim == 3:
            moved[dim:] = rotation @ moved[dim:]
        return np.asarray(moved)

    def _before(self, step: TimeStep) -> Motion:
        zero = np.zeros_like(self.motion.velocity)
        return Motion(zero, zero, zero) if step.from_rest else self.motion

    def _after(self, increments: Floats, rotation: Floats, step: TimeStep) -> Motion:
        """Returns the motion at the end of a step."""
        moved = increments.copy()
        if self._dim == 3:
            moved[3:] = rotation.T @ increments[3:]
        return step.integration.after(moved, step.size, self._before(step))

    def commit(self, increments: Floats, rotation: Floats, step: TimeStep) -> None:
        """Ends a step; rotation: before it."""
        self.motion = self._after(increments, rotation, step)

    def start(self, increments: Floats, rotation: Floats, step: TimeStep) -> None:
        """Sets the accelerations to those after a short step from rest; the velocity stays.

        The moment of the gyroscopic terms, which the step at rest lacks, is added.
        """
        acceleration = self._after(increments, rotation, step).acceleration
        if self._dim == 3:
            spin = self.motion.velocity[3:]
            acceleration[3:] -= np.cross(spin, self._moments * spin) / self._moments
        self.motion = Motion(self.motion.velocity, acceleration, acceleration)

    def energy(self) -> float:
        """Returns the kinetic energy [force length]."""
        velocity, dim = self.motion.velocity, self._dim
        translation = self._mass * float(velocity[:dim] @ velocity[:dim])
        return 0.5 * (translation + float(self._moments @ velocity[dim:] ** 2))

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {name: getattr(self.motion, name) for name in NAMES}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        for name in NAMES:
            if state[name].shape != self.motion.velocity.shape:
                raise ValueError(f"{name!r} has another shape")
        self.motion = Motion(*(state[name] for name in NAMES))
