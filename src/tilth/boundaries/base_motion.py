# SPDX-License-Identifier: BSD-3-Clause
"""A rigid base that moves by a given acceleration, as in an earthquake (docs/theory/inertia.md).

The displacement of a step is that with which the method of time integration comes to the given
acceleration at its end. So the nodes of the base have this acceleration, and soil that moves with
the base as a rigid body has no strain.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.boundaries.nodal import Nodal
from tilth.boundaries.protocol import Prescribed
from tilth.model import Model, PlaneBoundary
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.inertia import TimeStep
from tilth.terms.motion import Motion
from tilth.variation.record import Record

StepOf = Callable[[float, float], TimeStep | None]
"""Returns the step of the equations of motion between two times; None if it has no inertia."""


class BaseMotion(Nodal):
    """All nodes of a grid line or plane with the acceleration of a record.

    Args:
        declared: the user's declaration.
        model: of the stage.
        record: the acceleration.
        step_of: step of the equations of motion between two times of the stage.

    Attributes:
        record: the acceleration.
    """

    def __init__(
        self, declared: PlaneBoundary, model: Model, record: Record, step_of: StepOf
    ) -> None:
        super().__init__(declared, model.dimension, model.load_curve(declared))
        self.record, self._step_of = record, step_of
        self._stage_start = model.stage.start
        first = record.acceleration[0]
        self._motion = np.stack([np.zeros_like(first), first, first])
        self._begin = model.stage.start

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """As `Boundary.prescribe`."""
        prescribed = super().prescribe(active, before, after)
        step = self._step_of(before, after)
        if step is None:
            return prescribed
        motion = np.zeros_like(self._motion) if step.from_rest else self._motion
        increment = np.where(prescribed.constrained, self._displacement(step, motion, after), 0.0)
        nodal = np.where(prescribed.constrained[:, None], motion, 0.0)
        return replace(prescribed, increment=increment, motion=nodal)

    def _displacement(self, step: TimeStep, motion: Floats, after: float) -> Floats:
        acceleration = self.record.acceleration_at(self._stage_start + after - self._begin)
        return step.integration.displacement(acceleration, step.size, Motion(*motion))

    def commit(self, before: float, after: float) -> None:
        """Ends a step between two times of the stage."""
        if (step := self._step_of(before, after)) is not None:
            moved = self._displacement(step, self._motion, after)
            found = step.integration.after(moved, step.size, Motion(*self._motion))
            self._motion = np.stack([found.velocity, found.acceleration, found.algorithmic])

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"motion": self._motion, "begin": np.array([self._begin])}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        if state["motion"].shape != self._motion.shape or state["begin"].shape != (1,):
            raise ValueError("'motion' has another shape")
        self._motion, self._begin = state["motion"], float(state["begin"][0])
