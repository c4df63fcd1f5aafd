# SPDX-License-Identifier: BSD-3-Clause
"""How a load or a motion grows: its factor over the time of the schedule."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True)
class LoadCurve:
    """A table of factors over time: piecewise linear, constant beyond its rows.

    Attributes:
        table: rows (time, factor [-]), times ascending, shape (n, 2).
    """

    table: Sequence[Sequence[float]]

    def factor(self, time: float) -> float:
        """Returns the factor [-] at a time of the schedule."""
        table = self.table
        if time <= table[0][0]:
            return table[0][1]
        for (t0, f0), (t1, f1) in pairwise(table):
            if time == t1:
                return f1
            if time < t1:
                return f0 + (f1 - f0) * (time - t0) / (t1 - t0)
        return table[-1][1]
