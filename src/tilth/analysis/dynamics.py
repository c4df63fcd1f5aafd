# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion in the steps of an analysis (docs/theory/inertia.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import PreparedStep
from tilth.analysis.wave_boundaries import WaveBoundaries
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.model import Inertia as DeclaredInertia
from tilth.model import Model
from tilth.mpm.soil import Soil
from tilth.mpm.water import PhreaticSurface
from tilth.mpm.wet_mass import total_mass
from tilth.terms.balance import Balance
from tilth.terms.ghost import Faces
from tilth.terms.inertia import Inertia, TimeIntegration, TimeStep
from tilth.terms.protocol import Term
from tilth.terms.stiffness_damping import StiffnessDamping

START = 1e-3
"""Size of the step that gives the accelerations at the start, relative to that of the first one."""


WITHIN, SAFETY = 0.95, 0.9
"""Possible relative size of a step from which it is accepted, and what of it is then tried."""


class Dynamics:
    """Inertia of the soil, and the accelerations at the start.

    Args:
        declared: the user's declaration.

    Attributes:
        begun: whether the accelerations at the start are known.
    """

    def __init__(self, declared: DeclaredInertia) -> None:
        radius = declared.spectral_radius
        self._integration = (
            TimeIntegration.newmark()
            if radius is None
            else TimeIntegration.generalised_alpha(radius)
        )
        self._largest_error = declared.largest_error or math.inf
        self._largest_motion = declared.largest_motion or math.inf
        damping = declared.damping
        self._damping = 0.0 if damping is None else damping.mass
        self._viscous = 0.0 if damping is None else damping.stiffness
        self._keeps_unseen = declared.velocity_update != "pic"
        self._start = 0.0
        self.begun = False

    @classmethod
    def of(cls, model: Model) -> Dynamics | None:
        """Returns that of a model; None if it is quasi-static."""
        stage = model.stage.declared
        if model.analysis.inertia is None or not (stage is None or stage.inertia):
            return None
        return cls(model.analysis.inertia)

    def step(self, before: float, after: float) -> TimeStep | None:
        """Returns the step between two times; None if they are the same: it has no inertia."""
        if self._start > 0.0:
            return TimeStep(TimeIntegration.backward_euler(), self._start, from_rest=True)
        if after <= before:
            return None
        return TimeStep(self._integration, after - before, keeps_unseen=self._keeps_unseen)

    def inertia(
        self,
        prepared: PreparedStep,
        soil: Soil,
        water: PhreaticSurface | None,
        faces: Sequence[Faces],
    ) -> Inertia | None:
        """Returns the inertia in a step; None in one of no size, a search for equilibrium.

        faces: of the ghost stabilisation in this step.
        """
        step = self.step(prepared.before, prepared.after)
        if step is None:
            return None
        mass = total_mass(soil.points, water, prepared.before)
        damping = 0.0 if step.from_rest else self._damping
        conditions = prepared.conditions
        return Inertia(
            soil, mass, faces, step, damping, conditions.constrained, conditions.increment,
            conditions.base,
        )  # fmt: skip

    def terms(
        self, inertia: Inertia, prepared: PreparedStep, soil: Soil, waves: WaveBoundaries
    ) -> list[Term]:
        """Returns the inertia in a step, and what else acts by the motion of the soil.

        waves: boundaries that absorb waves.
        """
        terms: list[Term] = [inertia, *waves.terms(prepared, soil, inertia.mass, inertia)]
        if self._viscous > 0.0 and not inertia.step.from_rest:
            terms.append(StiffnessDamping(soil, self._viscous, inertia.step.size))
        return terms

    @contextmanager
    def at_start(self, size: float) -> Iterator[None]:
        """Makes steps without size very short ones from rest; size: of the first step [time]."""
        self._start = START * size
        try:
            yield
        finally:
            self._start = 0.0

    def force_at_start(self, balance: Balance) -> Floats:
        """Returns inertia and damping of the motion that the points have [force], (nodes, dim)."""
        return balance.motion.force_at_start(self._damping)

    def start(self, found: Equilibrium, balance: Balance, soil: Soil, size: float) -> None:
        """Gives points and bodies the accelerations after the very short step from rest.

        size: of the first step [time].
        """
        after, motion = balance.motion.after(found.displacement), soil.points.motion
        acceleration = soil.interpolate(after.acceleration) - self._damping * motion[:, 0]
        motion[:, 1] = motion[:, 2] = acceleration
        balance.start(found.x.globals, size)
        self.begun = True

    @staticmethod
    def guess(balance: Balance) -> Floats:
        """Returns the displacement of a step without a change of the acceleration, (nodes, dim)."""
        return balance.motion.guess()

    def possible_size(
        self, balance: Balance, displacement: Floats, moved: Floats, cell_size: Floats
    ) -> tuple[float, str]:
        """Returns the size of a step, relative to this one, that keeps error and motion in limits.

        And which of them is nearer to its limit, in words.

        displacement: of the nodes (nodes, dim); moved: of the points, (n, dim).
        cell_size: of the cells that these are in [length], (n, dim).
        """
        share, reason, comm = math.inf, "", balance.comm
        if self._largest_motion < math.inf:
            most = comm.max(float(np.abs(moved / cell_size).max()))
            share = self._largest_motion / max(most, 1e-300)
            reason = f"a point moves by {most:.3g} cells in the step, but largest_motion"
            reason += f" = {self._largest_motion:g}"
        if self._largest_error < math.inf:
            error = balance.motion.local_error(displacement) / cell_size
            most = comm.max(float(np.linalg.norm(error, axis=1).max()))
            possible = (self._largest_error / max(most, 1e-300)) ** (1.0 / 3.0)
            if possible < share:
                share = possible
                reason = f"the local error in the step is {most:.3g} cells, but largest_error"
                reason += f" = {self._largest_error:g}"
        return share, reason

    def require_accurate(self, share: float, reason: str) -> None:
        """Checks that a step is short enough.

        Args:
            share: its possible relative size.
            reason: what limits it.

        Raises:
            StepFailed: it must be shorter.
        """
        if share < WITHIN:
            remedy = "give a smaller schedule.minimum_step, or a larger limit in analysis.inertia"
            raise StepFailed(reason, remedy, share=SAFETY * share)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"begun": np.array([self.begun])}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        if state["begun"].shape != (1,):
            raise ValueError("'begun' is not one flag")
        self.begun = bool(state["begun"][0])
