# SPDX-License-Identifier: BSD-3-Clause
"""How a load or a motion grows: its factor over the time of the schedule."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass


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
        after = bisect_left(table, time, key=lambda row: row[0])
        if after == 0:
            return table[0][1]
        if after == len(table):
            return table[-1][1]
        (t0, f0), (t1, f1) = table[after - 1], table[after]
        return f1 if time == t1 else f0 + (f1 - f0) * (time - t0) / (t1 - t0)
