# SPDX-License-Identifier: BSD-3-Clause
"""The motion of nodes or rigid bodies in a step with inertia."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tilth.arrays import Floats


@dataclass(frozen=True)
class Motion:
    """Velocity, acceleration and algorithmic acceleration of nodes, or of a rigid body.

    Arrays of the same shape [length/time, length/time^2].
    """

    velocity: Floats
    acceleration: Floats
    algorithmic: Floats


class NodalMotion(Protocol):
    """The motion of the nodes over a step, by the method that integrates it over time."""

    def guess(self) -> Floats:
        """Returns the displacement of the step without a change of the acceleration, (nodes, dim).

        In [length].
        """

    def after(self, displacement: Floats) -> Motion:
        """Returns the motion of the nodes at the end of the step for their displacement in it.

        Arrays of shape (nodes, dim), as the displacement [length].
        """

    def local_error(self, displacement: Floats) -> Floats:
        """Returns the local error of the points' displacements [length], shape (n, dim).

        displacement: of the nodes in the step [length], shape (nodes, dim).
        """

    def force_at_start(self, damping: float) -> Floats:
        """Returns the force of the motion that the points have [force], shape (nodes, dim).

        damping: factor of the mass [1/time].
        """
