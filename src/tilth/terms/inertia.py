# SPDX-License-Identifier: BSD-3-Clause
"""Inertia of the soil and its integration over time (docs/theory/inertia.md).

Newmark's method and the generalised-alpha method of Chung and Hulbert (1993), in the form of Arnold
and Bruels (2007): the balance M w + r = 0 holds at the end of the step, with the acceleration w
there. Displacement and velocity follow another one, the algorithmic acceleration a:

    u = h v + h^2 (1/2 - beta) a + h^2 beta a',       v' = v + h (1 - gamma) a + h gamma a',
    (1 - alpha_m) a' + alpha_m a = (1 - alpha_f) w' + alpha_f w,

with the values at the end of the step primed. With Newmark's method a = w.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.mass import ConsistentMass
from tilth.mpm.pattern import Elements, same_starts
from tilth.mpm.soil import Soil
from tilth.terms.ghost import Faces
from tilth.terms.motion import Motion
from tilth.terms.outcome import Outcome, Work
from tilth.terms.protocol import DisplacementTerm, Role, Term
from tilth.terms.space import Coupled, Space

GHOST_MASS = 1.0 / 12.0
"""Factor of the ghost mass, rho h^3 int [du/dn] [dw/dn] over a face of an empty cell: Coombs (2022)
has (rho / 4) (h^3 / 3)."""


RELATIVE_SHIFT = 1e-8
"""Inertia added to all nodes in the matrix only, relative to the greatest: slivers of domains give
their nodes almost dependent masses."""


@dataclass(frozen=True)
class TimeIntegration:
    """Parameters of the method [-], see the module's description."""

    beta: float
    gamma: float
    alpha_m: float = 0.0
    alpha_f: float = 0.0

    @classmethod
    def newmark(cls) -> TimeIntegration:
        """The trapezoidal rule: no damping, of order 2."""
        return cls(beta=0.25, gamma=0.5)

    @classmethod
    def generalised_alpha(cls, spectral_radius: float) -> TimeIntegration:
        """The method of order 2 with this spectral radius at infinite frequency, 0 to 1."""
        alpha_m = (2.0 * spectral_radius - 1.0) / (spectral_radius + 1.0)
        alpha_f = spectral_radius / (spectral_radius + 1.0)
        gamma = 0.5 - alpha_m + alpha_f
        return cls(0.25 * (0.5 + gamma) ** 2, gamma, alpha_m, alpha_f)

    @classmethod
    def backward_euler(cls) -> TimeIntegration:
        """Backward Euler, if the algorithmic acceleration before the step is 0."""
        return cls(beta=1.0, gamma=1.0)

    def after(self, u: Floats, h: float, before: Motion) -> Motion:
        """Returns the motion at the end of a step of size h [time] with the displacement u."""
        v, a = before.velocity, before.algorithmic
        b, g = self.beta, self.gamma
        algorithmic = (u - h * v - h**2 * (0.5 - b) * a) / (h**2 * b)
        mean = (1.0 - self.alpha_m) * algorithmic + self.alpha_m * a
        acceleration = (mean - self.alpha_f * before.acceleration) / (1.0 - self.alpha_f)
        return Motion(v + h * ((1.0 - g) * a + g * algorithmic), acceleration, algorithmic)

    def displacement(self, acceleration: Floats, h: float, before: Motion) -> Floats:
        """Returns the displacement of a step of size h [time] that ends with an acceleration."""
        a, b = before.algorithmic, self.beta
        mean = (1.0 - self.alpha_f) * acceleration + self.alpha_f * before.acceleration
        algorithmic = (mean - self.alpha_m * a) / (1.0 - self.alpha_m)
        return np.asarray(h * before.velocity + h**2 * ((0.5 - b) * a + b * algorithmic))

    def derivatives(self, h: float) -> tuple[float, float]:
        """Returns the derivatives of velocity [1/time] and acceleration [1/time^2] after by u."""
        by_u = 1.0 / (h**2 * self.beta)
        return h * self.gamma * by_u, (1.0 - self.alpha_m) / (1.0 - self.alpha_f) * by_u


@dataclass(frozen=True)
class TimeStep:
    """A step of the equations of motion.

    Attributes:
        integration: the method.
        size: [time].
        from_rest: whether it begins without velocity and acceleration, whatever has been before.
        keeps_unseen: whether the points keep the velocities that the grid does not represent.
        settles: whether the points get the velocity of the grid at its end, and no acceleration:
            what the grid does not see of their velocities is gone.
    """

    integration: TimeIntegration
    size: float
    from_rest: bool = False
    settles: bool = False
    keeps_unseen: bool = True


class Inertia(Term):
    """Inertia of all material points in one step, and damping proportional to their mass.

    Where a displacement is prescribed the nodes begin the step with the velocity that the points
    have there, at fixed nodes at rest, and end it with the mean velocity of the step. A base whose
    acceleration is given follows the method as free nodes do.

    Args:
        soil: on the grid of the step.
        mass: of its points [mass], shape (n,).
        faces: of the ghost stabilisation.
        step: its size and method.
        damping: factor of the force damping * M v [1/time].
        constrained: prescribed components, shape (nodes, dim).
        increment: their displacement in the step [length], shape (nodes, dim).
        base: components with a given acceleration, shape (nodes, dim), and their motion before the
            step, shape (nodes, 3, dim); None without any.

    Attributes:
        mass, step: see above.
        in_matrix: this term in the pattern of the matrix, as soon as it is there.
    """

    def __init__(
        self,
        soil: Soil,
        mass: Floats,
        faces: Sequence[Faces],
        step: TimeStep,
        damping: float,
        constrained: Flags,
        increment: Floats,
        base: tuple[Flags, Floats] | None = None,
    ) -> None:
        self._soil, self.mass, self._faces = soil, mass, faces
        self.step, self._damping = step, damping
        self._constrained, self._increment, self._base = constrained, increment, base
        self.in_matrix: AssembledInertia | None = None

    def held_nodes(self) -> Flags:
        """As `Term.held_nodes`: mass holds all nodes."""
        return np.ones(len(self._constrained), dtype=bool)

    @property
    def coupled(self) -> list[Coupled]:
        """As `Term.coupled`: the nodes of faces with ghost mass."""
        return [Coupled(same_starts(each.node), each.node.ravel()) for each in self._faces]

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledInertia:
        """As `Term.assembled`."""
        ghost = [
            (each, faces.unit, faces.which, mass)
            for each, faces, mass in zip(elements, self._faces, self._ghost_masses(), strict=True)
        ]
        mass = ConsistentMass(self._soil, self.mass, space.active, ghost)
        self.in_matrix = AssembledInertia(
            self._soil, mass, space.active, self.step, self._damping, self._constrained,
            self._increment, self._base,
        )  # fmt: skip
        return self.in_matrix

    def _ghost_masses(self) -> list[Floats]:
        """Returns the factors of the unit matrices, which have h int [du/dn] [dw/dn], by faces.

        With the density of the soil at all nodes of a face together: those that soil touches with
        nothing but round-off do not matter. By its volume at the start, not today's, of which
        grains that fly may have next to nothing left.
        """
        if not self._faces:
            return []
        both = np.column_stack([self.mass, self._soil.points.initial_volume])
        mass, volume = self._soil.scatter(both).T
        return [
            GHOST_MASS
            * faces.size[:, faces.axis] ** 2
            * (mass[faces.node].sum(axis=1) / np.maximum(volume[faces.node].sum(axis=1), 1e-300))
            * faces.emptiness
            for faces in self._faces
        ]


class AssembledInertia(DisplacementTerm):
    """`Inertia` in the matrix's pattern: a force that is linear in the displacement.

    Attributes:
        before: motion of the nodes at the start of the step, shape (nodes, dim) each.
        from_rest: see `TimeStep`.
    """

    role = Role.INERTIA
    label = "inertia"

    def __init__(
        self,
        soil: Soil,
        mass: ConsistentMass,
        active: ActiveGrid,
        step: TimeStep,
        damping: float,
        constrained: Flags,
        increment: Floats,
        base: tuple[Flags, Floats] | None = None,
    ) -> None:
        self._soil, self._mass, self._damping = soil, mass, damping
        self._pattern = active
        self._integration, self._size, self._settles = step.integration, step.size, step.settles
        self._keeps_unseen = step.keeps_unseen
        self._constrained, self._prescribed = constrained, increment / step.size
        self._base, self.from_rest = base, step.from_rest
        if base is not None:
            self._constrained = constrained & ~base[0]
        self._largest_mass = active.comm.max(float(mass.blocks.max()))
        zero = np.zeros_like(increment)
        self.before = Motion(zero, zero, zero) if step.from_rest else self.motion_at_start()

    @property
    def motion(self) -> AssembledInertia:
        """As `AssembledTerm.motion`."""
        return self

    def motion_at_start(self) -> Motion:
        """Returns the motion of the nodes that the points have, shape (nodes, dim) each."""
        n, kinds, dim = self._soil.points.motion.shape
        known = np.tile(self._constrained, (1, kinds))
        known[:, :dim] &= self._prescribed == 0.0
        value = None
        if self._base is not None:
            moving = np.tile(self._base[0], (1, kinds))
            known |= moving
            value = np.where(moving, self._base[1].reshape(known.shape), 0.0)
        quantity = self._soil.points.motion.reshape(n, kinds * dim)
        nodal = self._mass.projected(quantity, known, value)
        return Motion(*(nodal[:, k * dim : (k + 1) * dim] for k in range(kinds)))

    def after(self, displacement: Floats) -> Motion:
        """Returns the motion of the nodes at the end of the step for their displacement in it."""
        found = self._integration.after(displacement, self._size, self.before)
        fixed, velocity = self._constrained, self._prescribed
        acceleration = (velocity - self.before.velocity) / self._size
        return Motion(
            np.where(fixed, velocity, found.velocity),
            np.where(fixed, acceleration, found.acceleration),
            np.where(fixed, acceleration, found.algorithmic),
        )

    def inertia_before(self) -> Floats:
        """As `AssembledTerm.inertia_before`."""
        before = self.before
        return self._mass.times(before.acceleration + self._damping * before.velocity)

    def force_at_start(self, damping: float) -> Floats:
        """Returns the force of the motion that the points have [force], shape (nodes, dim).

        damping: factor of the mass [1/time].
        """
        motion = self.motion_at_start()
        return self._mass.times(motion.acceleration + damping * motion.velocity)

    def guess(self) -> Floats:
        """Returns the displacement of the step without a change of the acceleration."""
        h, motion = self._size, self.before
        return np.asarray(h * motion.velocity + 0.5 * h**2 * motion.algorithmic)

    def force(self, displacement: Floats) -> Floats:
        """As `AssembledTerm.force`."""
        motion = self.after(displacement)
        return self._mass.times(motion.acceleration + self._damping * motion.velocity)

    def derivatives(self) -> tuple[float, float]:
        """Returns those of velocity and acceleration by the displacement of a free node."""
        return self._integration.derivatives(self._size)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """As `AssembledTerm.add_stiffness`."""
        of_velocity, of_acceleration = self.derivatives()
        factor = of_acceleration + self._damping * of_velocity
        scaled, shift = factor * self._mass.blocks, RELATIVE_SHIFT * (factor * self._largest_mass)
        for k in range(displacement.shape[1]):
            blocks[:, k, k] += scaled
            blocks[self._pattern.diagonal, k, k] += shift

    def magnitude(self, x: Unknowns) -> dict[str, Floats]:
        """As `AssembledTerm.magnitude`."""
        _, factor = self._integration.derivatives(self._size)
        moved = np.abs(x.u) + self._size * np.abs(self.before.velocity)
        return {DISPLACEMENT: np.asarray(factor * self._mass.times(moved))}

    def outcome(self, x: Unknowns) -> Outcome:
        """As `AssembledTerm.outcome`: what damping, time integration and ghost mass take."""
        work = Work(
            damping=self.damping_work(x.u),
            integration=self.integration_work(x.u),
            stabilisation=self.ghost_energy(x.u),
        )
        return Outcome(work=work, ghost_force=self.ghost_force(x.u))

    def local_error(self, displacement: Floats) -> Floats:
        """Returns the local error of the points' displacements [length], shape (n, dim).

        It is (beta - 1/6) h^2 (a' - a): what Newmark's formula lacks of Taylor's series
        (Zienkiewicz and Xie 1991).
        """
        change = self.after(displacement).algorithmic - self.before.algorithmic
        factor = (self._integration.beta - 1.0 / 6.0) * self._size**2
        return factor * self._soil.interpolate(change)

    def damping_work(self, displacement: Floats) -> float:
        """Returns the work of the damping in the step [force length], by the trapezoidal rule."""
        if self._damping == 0.0:
            return 0.0
        velocity = self.before.velocity + self.after(displacement).velocity
        force = 0.5 * self._damping * self._mass.times(velocity)
        return self._pattern.work(force, displacement)

    def integration_work(self, displacement: Floats) -> float:
        """Returns what the time integration dissipates in the step [force length].

        The work of the forces of inertia, by the trapezoidal rule, less the change of the grid's
        kinetic energy: 0 with Newmark's average acceleration, for which both are the same.
        """
        before, after = self.before, self.after(displacement)
        force = self._mass.times(before.acceleration + after.acceleration)
        return 0.5 * self._pattern.work(force, displacement) - self.kinetic_change(displacement)

    def kinetic_change(self, displacement: Floats) -> float:
        """Returns the change of the grid's kinetic energy in the step [force length]."""
        before, after = self.before, self.after(displacement)
        change = self._mass.times(after.velocity - before.velocity)
        return 0.5 * self._pattern.work(change, after.velocity + before.velocity)

    def ghost_force(self, displacement: Floats) -> Floats:
        """Returns the force of the ghost mass at the end of the step [force], (nodes, dim)."""
        return self._mass.ghost_times(self.after(displacement).acceleration)

    def ghost_energy(self, displacement: Floats) -> float:
        """Returns the ghost mass's kinetic energy of the change of the velocity [force length].

        The points, which carry the motion, do not get it.
        """
        change = self.after(displacement).velocity - self.before.velocity
        return 0.5 * self._pattern.work(self._mass.ghost_times(change), change)

    def commit(self, x: Unknowns, checked: None) -> None:
        """As `AssembledTerm.commit`: the points get the nodes' velocities or their increments.

        The accelerations are those of the grid.
        """
        motion, after = self._soil.points.motion, self.after(x.u)
        if self._settles:
            motion[:, 0] = self._soil.interpolate(after.velocity)
            motion[:, 1:] = 0.0
            return
        n, kinds, dim = motion.shape
        velocity = after.velocity - self.before.velocity if self._keeps_unseen else after.velocity
        nodal = np.concatenate([velocity, after.acceleration, after.algorithmic], axis=1)
        found = self._soil.interpolate(nodal).reshape(n, kinds, dim)
        if self._keeps_unseen:
            found[:, 0] += motion[:, 0]
        motion[:] = found
