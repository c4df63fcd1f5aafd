# SPDX-License-Identifier: BSD-3-Clause
"""Inertia of a rigid body that is free to move (docs/theory/inertia.md, "Rigid bodies").

Angular velocity Omega and acceleration are in the frame of the body, where its tensor of inertia I
is constant. With R the rotation before the step and v the rotation vector of the step, R' = exp(v)
R, so that V = R^T v takes the part of the displacement (Bruels and Cardona 2010).

Forces that are smooth in time, weight, loads and springs, are integrated as those of soil
(terms/inertia.py). Contact is not smooth: with the formulas of Newmark the velocity at its end
would be that of an elastic rebound, and energy can grow. Its acceleration c at the end of the step
is taken for the whole step, as in Moreau's time stepping,

    u = u_s + h^2 c,       v' = v_s' + h c,

with u_s, v_s' of the smooth forces, whose balance at the end of the step is w_s' = f'/m, about the
centre I w_s' + Omega' x I Omega' = m'. An impact on what does not yield is so without rebound; in
lasting contact the velocity lags by h c / 2 behind.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.boundaries.contact.rotation import DIFFERENCE, left_jacobian, rotation_by
from tilth.model import RigidBody
from tilth.terms.inertia import TimeStep
from tilth.terms.motion import Motion

NAMES = ("velocity", "acceleration", "algorithmic")

ITERATIONS = 8
"""For the gyroscopic moment: each reduces its error by the angle of a step in radians."""


class BodyInertia:
    """Motion and inertia of a rigid body.

    Args:
        mass: [mass].
        moments: principal moments of inertia about the centre [mass length^2], (1,) or (3,).
        velocity: of the centre at the start [length/time], shape (dim,).
        angular_velocity: at the start [rad/time], shape (1,) or (3,).

    Attributes:
        motion: velocity and accelerations of the centre, then of the rotation in the frame of the
            body, shape (dim + 1 or 3,) each; the accelerations are those of the smooth forces.
        contact: c at the end of the last step, of the same shape.
    """

    def __init__(
        self, mass: float, moments: Floats, velocity: Floats, angular_velocity: Floats
    ) -> None:
        self._mass = np.concatenate([np.full(len(velocity), mass), moments])
        self._inverse = 1.0 / np.where(self._mass > 0.0, self._mass, 1.0)
        first = np.concatenate([velocity, angular_velocity])
        zero = np.zeros_like(first)
        self.motion = Motion(first, zero, zero)
        self.contact = zero
        self._dim = len(velocity)

    @classmethod
    def of(cls, declared: RigidBody, dim: int) -> BodyInertia:
        """Returns that of a declared body; components without mass are prescribed."""
        turns = 1 if dim == 2 else 3
        moments = np.broadcast_to(np.array(declared.moments_of_inertia or 0.0), (turns,))
        spin = np.broadcast_to(np.array(declared.angular_velocity or 0.0), (turns,))
        velocity = np.zeros(dim) if declared.velocity is None else np.array(declared.velocity)
        return cls(declared.mass or 0.0, np.array(moments), velocity, np.array(spin))

    def contact_force(
        self, increments: Floats, rotation: Floats, load: Floats, step: TimeStep
    ) -> Floats:
        """Returns force and moment that contact has in a step of this motion, (dim + 1 or 3,).

        All are work-conjugate to the increments.

        Args:
            increments: translation [length] and rotation vector [rad] of the step.
            rotation: of the body before the step, shape (dim, dim).
            load: all other forces and moments at the end of the step, shape (dim + 1 or 3,).
            step: its size and method.
        """
        found = self._mass * self._by_contact(increments, rotation, load, step)
        return self._conjugate(increments, rotation) @ found

    def stiffness(
        self, increments: Floats, rotation: Floats, load: Floats, step: TimeStep
    ) -> Floats:
        """Returns the derivative of `contact_force` by the increments with this load."""
        _, by_increment = step.integration.derivatives(step.size)
        whole = np.diag(self._mass * by_increment / self.share(step))
        for j in range(3, len(increments) if self._dim == 3 else 0):
            unit = DIFFERENCE * np.eye(len(increments))[j]
            forward = self.contact_force(increments + unit, rotation, load, step)
            backward = self.contact_force(increments - unit, rotation, load, step)
            whole[3:, j] = (forward - backward)[3:] / (2.0 * DIFFERENCE)
        return whole

    @staticmethod
    def share(step: TimeStep) -> float:
        """Returns by how much less contact moves a body that Newmark's formulas move, [-]."""
        return step.integration.derivatives(step.size)[1] * step.size**2

    def guess(self, rotation: Floats, step: TimeStep) -> Floats:
        """Returns the increments of a step without a change of the accelerations."""
        before, moved = self._before(step), np.zeros_like(self.contact)
        if not step.from_rest:
            a = 0.5 * before.algorithmic + self.contact
            moved = step.size * before.velocity + step.size**2 * a
        if self._dim == 3:
            moved[3:] = rotation @ moved[3:]
        return np.asarray(moved)

    def _before(self, step: TimeStep) -> Motion:
        zero = np.zeros_like(self.motion.velocity)
        return Motion(zero, zero, zero) if step.from_rest else self.motion

    def _moved(self, increments: Floats, rotation: Floats) -> Floats:
        """Returns the increments, the rotation in the frame of the body."""
        moved = increments.copy()
        if self._dim == 3:
            moved[3:] = rotation.T @ increments[3:]
        return moved

    def _conjugate(self, increments: Floats, rotation: Floats) -> Floats:
        """Returns the matrix from force and moment in the frame of the body to conjugate ones."""
        matrix = np.eye(len(increments))
        if self._dim == 3:
            vector = increments[3:]
            matrix[3:, 3:] = left_jacobian(vector).T @ rotation_by(vector) @ rotation
        return matrix

    def _by_load(self, increments: Floats, rotation: Floats, load: Floats) -> Floats:
        """Returns the accelerations by a load; 0 for components without mass."""
        own = np.linalg.solve(self._conjugate(increments, rotation), load)
        return np.asarray(np.where(self._mass > 0.0, own, 0.0) * self._inverse)

    def _gyroscopic(self, spin: Floats) -> Floats:
        """Returns the part of the accelerations by an angular velocity (1,) or (3,)."""
        found = np.zeros_like(self._mass)
        if self._dim == 3:
            found[3:] = -np.cross(spin, self._mass[3:] * spin) * self._inverse[3:]
        return found

    def _by_contact(
        self, increments: Floats, rotation: Floats, load: Floats, step: TimeStep
    ) -> Floats:
        """Returns c, the accelerations by contact."""
        moved, before, h = self._moved(increments, rotation), self._before(step), step.size
        total = step.integration.after(moved, h, before).acceleration
        by_load, share = self._by_load(increments, rotation, load), self.share(step)
        if self._dim == 2:
            return np.asarray((total - by_load) / share)
        spin = before.velocity[3:]
        for _ in range(ITERATIONS):
            found = (total - by_load - self._gyroscopic(spin)) / share
            smooth = step.integration.after(moved - h**2 * found, h, before)
            spin = (smooth.velocity + h * found)[3:]
        return np.asarray(found)

    def commit(self, increments: Floats, rotation: Floats, load: Floats, step: TimeStep) -> None:
        """Ends a step; arguments as in `contact_force`."""
        h, moved = step.size, self._moved(increments, rotation)
        self.contact = self._by_contact(increments, rotation, load, step)
        smooth = step.integration.after(moved - h**2 * self.contact, h, self._before(step))
        velocity = smooth.velocity + h * self.contact
        self.motion = Motion(velocity, smooth.acceleration, smooth.algorithmic)

    def rest(self) -> None:
        """Sets velocity and accelerations to zero."""
        zero = np.zeros_like(self.contact)
        self.motion, self.contact = Motion(zero, zero, zero), zero

    def start(
        self, increments: Floats, rotation: Floats, load: Floats, step: TimeStep, first: float
    ) -> None:
        """Sets the accelerations to those after a short step from rest.

        The velocity lags as in lasting contact. first: size of the first step [time]; others as in
        `contact_force`.
        """
        self.contact = self._by_contact(increments, rotation, load, step)
        self._begin(self._by_load(increments, rotation, load), first)

    def begin(self, load: Floats, contact: Floats, rotation: Floats, first: float) -> None:
        """Sets the accelerations by known forces, all (dim + 1 or 3,); others as in `start`.

        contact: force and moment of contact, which weigh up the load of a body at rest.
        """
        none = np.zeros_like(load)
        self.contact = self._by_load(none, rotation, contact)
        self._begin(self._by_load(none, rotation, load), first)

    def _begin(self, by_load: Floats, first: float) -> None:
        acceleration = by_load + self._gyroscopic(self.motion.velocity[self._dim :])
        velocity = self.motion.velocity - 0.5 * first * self.contact
        self.motion = Motion(velocity, acceleration, acceleration)

    def energy(self) -> float:
        """Returns the kinetic energy [force length]."""
        return 0.5 * float(self._mass @ self.motion.velocity**2)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {name: getattr(self.motion, name) for name in NAMES} | {"contact": self.contact}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        for name in (*NAMES, "contact"):
            if state[name].shape != self.motion.velocity.shape:
                raise ValueError(f"{name!r} has another shape")
        self.motion = Motion(*(state[name] for name in NAMES))
        self.contact = state["contact"]
