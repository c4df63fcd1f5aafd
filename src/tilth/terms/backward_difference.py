# SPDX-License-Identifier: BSD-3-Clause
"""Backward difference formulas of order 1 and 2 for steps of any size."""

from __future__ import annotations

from dataclasses import dataclass

LARGEST_RATIO = 2.0
"""Of a step to the last one, up to which the formula of order 2 is taken; it is stable up to 2.41
(Grigorieff 1983)."""

ROUND_OFF = 1e-6
"""Relative difference of ratios that are the same but for round-off."""


@dataclass(frozen=True)
class BackwardDifference:
    """The formula by which a step integrates y' = f:

        (y - y_n) - w (y_n - y_{n-1}) = theta h f,
        theta = (1 + r) / (1 + 2 r),  w = r^2 / (1 + 2 r),

    f at its end. It is of order 2; with r = 0 it is backward Euler.

    Attributes:
        size: h of the step [time].
        ratio: r, of its size to that of the last step; 0 without this.
    """

    size: float
    ratio: float = 0.0

    @classmethod
    def after(cls, last: float, size: float) -> BackwardDifference:
        """Returns that of a step of a size [time] after one of the size `last`; 0: after none."""
        ratio = size / last if last > 0.0 else 0.0
        return cls(size, 0.0 if ratio > LARGEST_RATIO * (1.0 + ROUND_OFF) else ratio)

    @property
    def of_rate(self) -> float:
        """theta h [time]."""
        return self.size * ((1.0 + self.ratio) / (1.0 + 2.0 * self.ratio))

    @property
    def of_last_change(self) -> float:
        """w [-]."""
        return self.ratio**2 / (1.0 + 2.0 * self.ratio)
