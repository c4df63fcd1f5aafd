# SPDX-License-Identifier: BSD-3-Clause
"""Published run times of AMPLE, which needs MATLAB and is not run here."""

from __future__ import annotations

SOURCE = (
    "W.M. Coombs, C.E. Augarde: AMPLE: a material point learning environment, Advances in "
    "Engineering Software 139, 102748, 2020"
)

COLUMN_SECONDS = {4: 1.2, 8192: 2500.0}
"""Cells of the self-weight column -> run time [s], GIMP with 2 x 2 points a cell, 40 steps; read
off the published figure, which does not name the machine."""

SECONDS_PER_POINT_AND_ITERATION = 180e-6
"""From the column of 64 to 1024 cells (version 1.1) [s]."""


def cantilever_seconds(points: int, iterations: int) -> float:
    """What the end-loaded cantilever takes by that time per point [s]."""
    return SECONDS_PER_POINT_AND_ITERATION * points * iterations


def citation() -> str:
    fine = max(COLUMN_SECONDS)
    return (
        f"AMPLE (MATLAB; not run here, machine not named): self-weight column of {fine} cells "
        f"{COLUMN_SECONDS[fine]:.0f} s, about "
        f"{1e6 * SECONDS_PER_POINT_AND_ITERATION:.0f} us per point and iteration.\n{SOURCE}"
    )
