# SPDX-License-Identifier: BSD-3-Clause
"""Orders of convergence."""

from __future__ import annotations

import math


def log_slope(coarse: float, fine: float, ratio: float) -> float:
    """Returns the order p of two errors ~ h^p on grids whose cell sizes have this ratio."""
    return math.log(coarse / fine) / math.log(ratio)
