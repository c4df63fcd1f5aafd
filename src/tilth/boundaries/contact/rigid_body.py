# SPDX-License-Identifier: BSD-3-Clause
"""A rigid body: its place, its motion in a step, and the forces on it besides contact.

The motion of a step is a translation t of the centre and a rotation by the vector v: a point x
moves by d = t + (R(v) - I)(x - c). Components of t and v are prescribed or free; the free ones are
unknowns of the step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats
from tilth.boundaries.contact.body_inertia import BodyInertia
from tilth.boundaries.contact.rotation import (
    derivative,
    left_jacobian,
    left_jacobian_derivative,
    rotated_by,
    rotation_by,
    second_derivative,
    vector_near,
)
from tilth.boundaries.contact.state import RigidBodyState
from tilth.model import RigidBody as DeclaredBody
from tilth.terms.inertia import TimeStep

WEAK_SPRING = 1e-10
"""Stiffness of the springs that hold a free body against the step's start, relative to the soil's
modulus times a cell's face over the size of the body: they make the system regular where nothing
else holds it."""


class RigidBody:
    """A rigid body with its state.

    Args:
        declared: the user's declaration.
        dim: number of directions.
        kind: of the analysis.
        end: of the schedule, in a stage of the stage's.
        acceleration: acceleration of all body forces at a time, shape (dim,).
        dynamic: whether it has inertia.

    Attributes:
        name: given by the user.
        declared: the user's declaration.
        components: names of the components of its motion, translations first.
        free: which of them are free, shape (components,).
        time: to which the state belongs.
        displacement: of the centre since the start [length], shape (dim,).
        turn: sum of the rotation vectors of all steps [rad], shape (1,) or (3,).
        rotation: from the reference configuration, shape (dim, dim).
        force, moment: of the soil on the body at the end of the last step [force], [force length],
            shapes (dim,) and (1,) or (3,), the moment about its centre.
        size: of the body, to scale rotations [length].
        load_share: of the declared forces, moments and weight that acts; 1 but for the search for
            the equilibrium at the start.
        inertia: velocities and inertia; None in a quasi-static analysis.
        step: of the equations of motion; None in equilibrium.
    """

    def __init__(
        self,
        declared: DeclaredBody,
        dim: int,
        kind: str,
        end: float,
        acceleration: Callable[[float], Floats],
        dynamic: bool = False,
    ) -> None:
        self.name = declared.name
        self.declared = declared
        self.components = declared.components(dim, kind)
        self._schedule_end = end
        self._acceleration = acceleration
        self.free: Flags = np.array(
            [not declared.is_prescribed(name) for name in self.components], dtype=bool
        )
        turns = 1 if dim == 2 else 3
        self._axis = np.array([self._slot(name, dim) for name in self.components])
        self._centre = np.array(declared.centre, dtype=np.float64)
        self.size = 1.0
        self.time = self._end = 0.0
        self.displacement: Floats = np.zeros(dim)
        self.turn: Floats = np.zeros(turns)
        self.rotation: Floats = np.eye(dim)
        self.force: Floats = np.zeros(dim)
        self.moment: Floats = np.zeros(turns)
        self.load_share = 1.0
        self._increments: Floats = np.zeros(dim + turns)
        self.inertia = BodyInertia.of(declared, dim) if dynamic else None
        self.step: TimeStep | None = None

    @staticmethod
    def _slot(name: str, dim: int) -> int:
        """Returns the place of a component among all translations and rotations."""
        if name in ("x", "y", "z"):
            return "xyz".index(name)
        return dim if name == "rotation" else dim + "xyz".index(name[-1])

    @property
    def dim(self) -> int:
        """Number of directions."""
        return len(self.displacement)

    @property
    def centre(self) -> Floats:
        """Its centre at the start of the step [length], shape (dim,)."""
        return np.asarray(self._centre + self.displacement)

    @property
    def scale(self) -> Floats:
        """Factors of the free components for comparison with displacements, shape (m,)."""
        return np.where(self._axis[self.free] < self.dim, 1.0, self.size)

    @property
    def weak_share(self) -> float:
        """Factor of those springs: 1/size [1/length], in axisymmetry for the circumference 2 pi."""
        return 2.0 * np.pi if len(self.components) == 1 else 1.0 / self.size

    def begin(self, after: float, step: TimeStep | None = None) -> None:
        """Begins a step to the time `after`, with the free components at rest.

        With inertia the free ones have their motion without a change of the acceleration.

        step: of the equations of motion; None where equilibrium is sought.
        """
        self._end, self.step = after, step
        self._increments = self._prescribed(self.time, after)
        if step is not None:
            self._increments = self.increments(self.first_unknowns)

    @property
    def is_moving(self) -> bool:
        """Whether it has a velocity."""
        return self.inertia is not None and bool(self.inertia.motion.velocity.any())

    @property
    def moves_with_inertia(self) -> bool:
        """Whether some of its components are free in a step of the equations of motion."""
        return self.step is not None and bool(self.free.any())

    @property
    def needs_contact(self) -> bool:
        """Whether a translation is free that neither spring nor inertia holds."""
        if self.step is not None:
            return False
        return bool((self.free & (self._axis < self.dim) & (self.springs == 0.0)).any())

    def is_loaded(self, time: float) -> bool:
        """Whether a force or moment acts on a free component that no spring holds."""
        applied = self.applied(np.zeros(self.dim + len(self.turn)), time)
        return bool((applied[self.springs[self.free] == 0.0] != 0.0).any())

    def falls_along(self, time: float) -> Floats | None:
        """Returns the direction of the force on it if only soil can hold it there, unit, (dim,).

        None if no translation is free, if springs or inertia hold it, or without a force.
        """
        if self.step is not None:
            return None
        translations = self._axis[self.free] < self.dim
        if not translations.any() or self.springs[self.free][translations].any():
            return None
        force = np.zeros(self.dim)
        applied = self.applied(np.zeros(self.dim + len(self.turn)), time)
        force[self._axis[self.free][translations]] = applied[translations]
        size = float(np.linalg.norm(force))
        return force / size if size > 0.0 else None

    @property
    def first_unknowns(self) -> Floats:
        """The free components where the search for a dynamic step begins, shape (m,)."""
        assert self.inertia is not None
        assert self.step is not None
        guess = self.inertia.guess(self.rotation, self.step)
        return np.asarray(guess[self._axis[self.free]])

    def start(self, unknowns: Floats, first: float) -> None:
        """Sets the accelerations to those after a short step from rest, shape (m,).

        first: size of the first step [time].
        """
        if self.inertia is not None and self.step is not None:
            increments = self.increments(unknowns)
            load = self._load(increments, self._end)
            self.inertia.start(increments, self.rotation, load, self.step, first)

    def moved_by(self, translation: Floats) -> Floats:
        """Returns the free components of a translation (dim,) [length], shape (m,)."""
        whole = np.concatenate([translation, np.zeros_like(self.turn)])
        return np.asarray(whole[self._axis[self.free]])

    def increments(self, unknowns: Floats) -> Floats:
        """Returns all translations and rotations of the step, shape (dim + 1 or 3,).

        unknowns: the free components, shape (m,).
        """
        full = self._increments.copy()
        full[self._axis[self.free]] = unknowns
        return full

    def set_trial(self, unknowns: Floats) -> None:
        """Sets where the body is at the end of the step, shape (m,)."""
        self._increments = self.increments(unknowns)

    def _prescribed(self, before: float, after: float) -> Floats:
        increments = np.zeros(self.dim + len(self.turn))
        for name, slot in zip(self.components, self._axis, strict=True):
            if self.declared.is_prescribed(name):
                values = [
                    self.declared.prescribed(name, time, self._schedule_end) or 0.0
                    for time in (before, after)
                ]
                increments[slot] = values[1] - values[0]
        return increments

    def place(self, time: float) -> tuple[Floats, Floats]:
        """Returns displacement of the centre (dim,) and rotation (dim, dim) at a time.

        Within the current step its motion is uniform. At other times the prescribed components have
        their values of that time, the free ones those of now.
        """
        if time == self._end and self._end > self.time:
            step = self._increments
        elif self.time < time < self._end:
            step = self._increments * ((time - self.time) / (self._end - self.time))
        else:
            step = self._prescribed(self.time, time)
        translation, vector = step[: self.dim], step[self.dim :]
        return self.displacement + translation, rotation_by(vector) @ self.rotation

    def position(self, reference: Floats, factor: float) -> Floats:
        """As `Motion.position`; the factor is the time."""
        displacement, rotation = self.place(factor)
        return np.asarray((reference - self._centre) @ rotation.T + self._centre + displacement)

    def reference(self, position: Floats, factor: float) -> Floats:
        """As `Motion.reference`; the factor is the time."""
        displacement, rotation = self.place(factor)
        return np.asarray((position - self._centre - displacement) @ rotation + self._centre)

    def gradient(self, reference: Floats, factor: float) -> Floats:
        """As `Motion.gradient`; the factor is the time."""
        _, rotation = self.place(factor)
        return np.broadcast_to(rotation, (len(reference), *rotation.shape))

    def displacements(self, increments: Floats, position: Floats) -> Floats:
        """Returns d of points of the body at the start of the step [length], shape (n, dim)."""
        arm = position - self.centre
        return np.asarray(increments[: self.dim] + rotated_by(increments[self.dim :], arm))

    def displacement_derivatives(self, increments: Floats, position: Floats) -> Floats:
        """Returns the derivatives of d by the free components, shape (m, n, dim)."""
        translations = np.broadcast_to(
            np.eye(self.dim)[:, None], (self.dim, len(position), self.dim)
        )
        turns = derivative(increments[self.dim :], position - self.centre)
        return np.asarray(np.concatenate([translations, turns])[self._axis[self.free]])

    def geometric_stiffness(self, increments: Floats, position: Floats, force: Floats) -> Floats:
        """Returns -sum of forces (n, dim) times the second derivatives of d, shape (m, m)."""
        dim, turns = self.dim, len(self.turn)
        whole = np.zeros((dim + turns, dim + turns))
        second = second_derivative(increments[dim:], position - self.centre)
        whole[dim:, dim:] = -np.einsum("abni,ni->ab", second, force)
        slots = self._axis[self.free]
        return np.asarray(whole[np.ix_(slots, slots)])

    def applied(self, increments: Floats, time: float) -> Floats:
        """Returns the force and moment on the free components that contact balances, shape (m,).

        Weight, loads and springs at a time; with inertia the opposite of what contact has in the
        step.

        increments: of the step so far. Forces in [force], moments in [force length].
        """
        load = self._load(increments, time)
        if self.inertia is not None and self.step is not None:
            load = -self.inertia.contact_force(increments, self.rotation, load, self.step)
        return np.asarray(load[self._axis[self.free]])

    def _load(self, increments: Floats, time: float) -> Floats:
        """Returns force and moment with weight and springs, conjugate to the increments."""
        load = self._declared_load(time)
        load[self.dim :] = left_jacobian(increments[self.dim :]).T @ load[self.dim :]
        total = np.concatenate([self.displacement, self.turn]) + increments
        load[self._axis] -= self.springs * total[self._axis]
        return load

    def load_stiffness(self, increments: Floats, time: float) -> Floats:
        """Returns the derivative of -`applied` by the free components, shape (m, m)."""
        dim, turns = self.dim, len(self.turn)
        whole = np.zeros((dim + turns, dim + turns))
        whole[self._axis, self._axis] = self.springs
        moment = self._declared_load(time)[dim:]
        whole[dim:, dim:] -= left_jacobian_derivative(increments[dim:], moment)
        if self.inertia is not None and self.step is not None:
            whole /= self.inertia.share(self.step)
            load = self._load(increments, time)
            whole += self.inertia.stiffness(increments, self.rotation, load, self.step)
        slots = self._axis[self.free]
        return np.asarray(whole[np.ix_(slots, slots)])

    def _declared_load(self, time: float) -> Floats:
        """Returns force and moment with the weight, without springs, shape (dim + 1 or 3,)."""
        declared = self.declared
        load = np.zeros(self.dim + len(self.turn))
        for name, slot in zip(self.components, self._axis, strict=True):
            load[slot] = declared.applied(name, time, self._schedule_end)
        if declared.mass:
            load[: self.dim] += declared.mass * self._acceleration(time)
        return load * self.load_share

    @property
    def springs(self) -> Floats:
        """Stiffness of the springs to the ground of each component, shape (components,)."""
        return np.array([self.declared.spring(name) for name in self.components])

    def result(self) -> RigidBodyState:
        """Returns its motion since the start, and the soil's force and moment on it."""
        rotation, moment = np.zeros(3), np.zeros(3)
        if self.dim == 2:
            rotation[2:], moment[2:] = self.turn, self.moment
        else:
            rotation, moment = vector_near(self.rotation, self.turn), self.moment
        return RigidBodyState(self.displacement, rotation, self.force, moment)

    def commit(self, unknowns: Floats, force: Floats, moment: Floats) -> None:
        """Ends the step with these free components (m,) and the soil's force and moment."""
        step = self.increments(unknowns)
        if self.inertia is not None and self.step is not None:
            load = self._load(step, self._end)
            self.inertia.commit(step, self.rotation, load, self.step)
        elif self.inertia is not None and self._end > self.time:  # in equilibrium
            self.inertia.rest()
        self.displacement = self.displacement + step[: self.dim]
        self.turn = self.turn + step[self.dim :]
        self.rotation = rotation_by(step[self.dim :]) @ self.rotation
        self.force, self.moment = force, moment
        self.time = self._end

    def place_now(self) -> tuple[Floats, Floats, Floats]:
        """Returns displacement (dim,) [length], turn [rad] and rotation, for `put_back`."""
        return self.displacement, self.turn, self.rotation

    def put_back(self, place: tuple[Floats, Floats, Floats]) -> None:
        """Puts it back where it was, but for what springs hold; the soil's force on it stays.

        The force of a spring belongs to its extension. Rotations stay if one has a spring.
        """
        sprung = np.zeros(self.dim + len(self.turn), dtype=bool)
        sprung[self._axis] = self.springs > 0.0
        self.displacement = np.where(sprung[: self.dim], self.displacement, place[0])
        if not sprung[self.dim :].any():
            self.turn, self.rotation = place[1:]

    def come_down(self, way: Floats) -> None:
        """Moves it by a translation (dim,) [length] before the first step, as far as it is free."""
        self.displacement = self.displacement + self.increments(self.moved_by(way))[: self.dim]

    def go_on_from(self, last: RigidBody) -> None:
        """Takes over where the body is at the end of the last stage."""
        self.restore(last.state())
        self.time = self._end = 0.0

    def begin_stage(self, first: float) -> None:
        """Sets the accelerations at the start of a stage with inertia, in which it is new or rests.

        first: size of the first step [time].
        """
        if self.inertia is not None:
            load = self._load(np.zeros_like(self._increments), 0.0)
            contact = np.concatenate([self.force, self.moment])
            self.inertia.begin(load, contact, self.rotation, first)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        motion = {} if self.inertia is None else self.inertia.state()
        return motion | {
            "time": np.array([self.time]),
            "displacement": self.displacement,
            "turn": self.turn,
            "rotation": self.rotation,
            "force": self.force,
            "moment": self.moment,
        }

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        own = self.state()
        for name, array in own.items():
            if state[name].shape != array.shape:
                raise ValueError(f"{name!r} has another shape")
        self.time = self._end = float(state["time"][0])
        self.displacement, self.turn = state["displacement"], state["turn"]
        self.rotation, self.force = state["rotation"], state["force"]
        self.moment = state["moment"]
        if self.inertia is not None:
            self.inertia.restore(state)
        self._increments = np.zeros(self.dim + len(self.turn))
