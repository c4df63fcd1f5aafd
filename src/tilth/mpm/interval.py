# SPDX-License-Identifier: BSD-3-Clause
"""The time that a step takes, for laws that depend on rates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats


@dataclass(frozen=True)
class Interval:
    """The time of a step [time].

    Attributes:
        in_stage: at its start, since the stage began.
        total: at its start, since the analysis began.
        size: of the step; 0 where nothing takes time: strength reduction, the equilibrium at the
            start and at the change of stages, states that are checked.
    """

    in_stage: float = 0.0
    total: float = 0.0
    size: float = 0.0

    @property
    def array(self) -> Floats:
        """The numbers in the order of the attributes, shape (3,)."""
        return np.array([self.in_stage, self.total, self.size])


INSTANT = Interval()
"""That of a step that takes no time."""
