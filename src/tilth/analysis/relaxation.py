# SPDX-License-Identifier: BSD-3-Clause
"""Through a collapse to the next equilibrium, by damped inertia (docs/theory/relaxation.md).

The soil has inertia and the damping force a M v, with the load held constant. It moves in steps of
backward Euler, whose size follows from the way that the points move in them: as the soil slows down
they grow, and inertia vanishes from the balance. A last step without inertia ends in equilibrium.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.analysis.dynamics import SAFETY, WITHIN
from tilth.analysis.step_result import PreparedStep, Relaxing, StepResult
from tilth.analysis.wave_boundaries import WaveBoundaries
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.model import Model
from tilth.mpm.distribution import Distribution
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.mpm.water import PhreaticSurface
from tilth.mpm.wet_mass import total_mass
from tilth.terms.balance import Balance
from tilth.terms.ghost import Faces
from tilth.terms.inertia import Inertia, TimeIntegration, TimeStep
from tilth.terms.protocol import Role, Term

LARGEST_MOTION = 0.1
"""Largest displacement of a point in a step [cells]."""

GROWTH = 2.0
"""Most by which a step is longer than the one before."""

LEAST_STEP = 1e-6
"""Least step, relative to the first one."""

REST_ENERGY = 1e-3
"""Kinetic energy, relative to its peak, from which on the soil may be at rest."""

REST_FORCE = 1e-3
"""Force of inertia and damping, relative to load and reactions, from which on it may be at rest."""

NEXT_TRIAL = 0.25
"""Part of that force that is left when an equilibrium is sought again that was not found."""

MOST_STEPS = 1000
"""Steps of a relaxation if the user does not say otherwise."""


class Relaxation:
    """The motion of soil that comes to rest; of an analysis that may need several.

    Attributes:
        most_steps: after which soil that moves ends the analysis.
        active: whether the soil moves.
        settling: whether the step that is taken is the last one, without inertia.
        number: of the relaxation, from 1; 0 before the first.
        steps: taken in it.
        size: of the next step [time].
        unit: time in which a shear wave crosses the soil, the first step [time].
        damping: factor of the force damping * M v [1/time].
        peak: largest kinetic energy in it [force length].
        kinetic: kinetic energy now [force length].
        work: of loads and boundaries since its beginning [force length].
        trial: force of inertia and damping from which on an equilibrium is sought [-].
        force: of inertia and damping in the last step, relative to load and reactions [-].
    """

    def __init__(self, most_steps: int) -> None:
        self.most_steps = most_steps
        self.settling = self.active = False
        self.number = self.steps = 0
        self.size = self.unit = self.damping = self.peak = self.kinetic = self.work = 0.0
        self.trial = self.force = 0.0
        self._norm = 0.0

    @classmethod
    def of(cls, model: Model) -> Relaxation | None:
        """Returns that of a model; None if its analysis ends at a limit load."""
        analysis = model.analysis
        if analysis.beyond_limit == "stop":
            return None
        return cls(analysis.relaxation_steps or MOST_STEPS)

    def start(
        self,
        all_points: MaterialPoints,
        distribution: Distribution,
        water: PhreaticSurface | None,
        time: float,
    ) -> None:
        """Begins a relaxation of soil that is at rest, from an equilibrium at a time of the stage.

        The damping is critical for the slowest shear wave across the soil: pi c / L. The first step
        is as long as such a wave takes, so that what is driven in it is hardly a shock.
        """
        points, comm = distribution.owned(all_points), distribution.comm
        mass = comm.sum(float(total_mass(points, water, time).sum()))
        stiffness = comm.sum(float(points.elastic_moduli().shear @ points.volume))
        speed = math.sqrt(stiffness / mass)
        lower = (points.position - points.half_length).min(axis=0, initial=math.inf)
        upper = (points.position + points.half_length).max(axis=0, initial=-math.inf)
        ends = np.max(comm.gathered(np.stack([upper, -lower])), axis=0)
        length = float(ends.sum(axis=0).max())
        self.damping = math.pi * speed / length
        self.size = self.unit = length / speed
        self.peak = self.kinetic = self.work = 0.0
        self.trial, self.force, self.steps = REST_FORCE, math.inf, 0
        self.number += 1
        self.active = True

    @property
    def may_be_at_rest(self) -> bool:
        """Whether an equilibrium is worth seeking."""
        return self.force <= self.trial and self.kinetic <= REST_ENERGY * self.peak

    def not_at_rest(self) -> None:
        """Records that there was no equilibrium."""
        self.trial = NEXT_TRIAL * self.force

    @property
    def largest_share(self) -> float:
        """The largest kinetic energy over the work since the soil moves [-]."""
        return self.peak / self.work if self.work > 0.0 else 0.0

    def cut(self, share: float | None) -> bool:
        """Shortens the step that failed; returns whether it is still long enough to be tried."""
        self.size *= 0.5 if share is None else share
        return self.size >= LEAST_STEP * self.unit

    def accept(
        self,
        all_points: MaterialPoints,
        distribution: Distribution,
        water: PhreaticSurface | None,
        result: StepResult,
    ) -> Relaxing:
        """Records a step, the last one too; returns what is told of it."""
        if self.settling:
            all_points.motion[:] = 0.0
        points, active = distribution.owned(all_points), result.active
        mass = total_mass(points, water, result.time)
        self.kinetic = distribution.comm.sum(points.kinetic_energy(mass))
        self.peak = max(self.peak, self.kinetic)
        self.work += result.work
        self.steps += 1
        held = max(active.norm(result.equilibrium.load), active.norm(result.reaction))
        self.force = self._norm / max(held, 1e-300)
        if not self.settling:
            self.size *= min(GROWTH, SAFETY * result.possible_size)
        self.active = not self.settling
        return Relaxing(self.number, not self.active, self.kinetic, self.work)

    # what is asked of the motion in a step, as of `Dynamics`

    def step(self, before: float, after: float) -> TimeStep | None:
        """As `Dynamics.step`; the times are the same in all but the first one."""
        if self.settling:
            return None
        return TimeStep(TimeIntegration.backward_euler(), self.size, settles=True)

    def inertia(
        self,
        prepared: PreparedStep,
        soil: Soil,
        water: PhreaticSurface | None,
        faces: Sequence[Faces],
    ) -> Inertia | None:
        """As `Dynamics.inertia`."""
        step = self.step(prepared.before, prepared.after)
        if step is None:
            return None
        mass = total_mass(soil.points, water, prepared.before)
        constrained, increment = prepared.conditions.constrained, prepared.conditions.increment
        return Inertia(soil, mass, faces, step, self.damping, constrained, increment)

    def terms(
        self, inertia: Inertia, prepared: PreparedStep, soil: Soil, waves: WaveBoundaries
    ) -> list[Term]:
        """As `Dynamics.terms`; absorbing boundaries hold the soil."""
        return [inertia]

    def guess(self, balance: Balance) -> Floats | None:
        """As `Dynamics.guess`; none for the last step."""
        return None if self.settling else balance.motion.guess()

    def possible_size(
        self, balance: Balance, displacement: Floats, moved: Floats, cell_size: Floats
    ) -> tuple[float, str]:
        """As `Dynamics.possible_size`."""
        x = balance.at(displacement)
        forces = [term.evaluate(x).u for term in balance.of_role(Role.INERTIA)]
        self._norm = sum(balance.active.norm(each) for each in forces)
        most = balance.comm.max(float(np.abs(moved / cell_size).max()))
        return LARGEST_MOTION / max(most, 1e-300), "the soil moves too far in the step"

    def require_accurate(self, share: float, reason: str) -> None:
        """As `Dynamics.require_accurate`."""
        if share < WITHIN:
            raise StepFailed(reason, share=SAFETY * share)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {
            "counts": np.array([int(self.active), self.number, self.steps]),
            "values": np.array([getattr(self, name) for name in _VALUES]),
        }

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        counts, values = state["counts"], state["values"]
        if counts.shape != (3,) or values.shape != (len(_VALUES),) or min(counts) < 0:
            raise ValueError("'counts' or 'values' has not the numbers of a relaxation")
        self.active, self.number, self.steps = bool(counts[0]), int(counts[1]), int(counts[2])
        for name, value in zip(_VALUES, values, strict=True):
            setattr(self, name, float(value))


_VALUES = ("size", "unit", "damping", "peak", "kinetic", "work", "trial", "force")
"""Attributes of a relaxation, in the order of a checkpoint."""
