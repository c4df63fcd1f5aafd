# SPDX-License-Identifier: BSD-3-Clause
"""Balances of force, moment and energy of a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from metamorphic.models import CELL, TOLERANCE, Tree
from metamorphic.runs import Moment, Run
from tilth.arrays import Floats

LARGEST_GAP = 0.25
"""Largest gap between two bodies that is carried in contact [cells]: the moments of the forces on the
two differ by it (docs/theory/contact.md)."""


def faults(run: Run, entries: Tree) -> Iterator[str]:
    """Yields the balances that do not hold after a step, the first of each kind."""
    dynamic = "inertia" in entries["analysis"]
    axisymmetric = entries["analysis"]["kind"] == "axisymmetric"
    for moment in run.moments:
        if not dynamic:
            yield from _forces(moment, axisymmetric)


def sums(moment: Moment) -> tuple[Floats, Floats]:
    """Sum of all forces on the soil and of their moments."""
    names = [name for name in moment.forces if name not in moment.between]
    force = moment.load + sum(moment.forces[name] for name in names)
    return force, moment.load_moment + sum(moment.moments[name] for name in names)


def _forces(moment: Moment, axisymmetric: bool) -> Iterator[str]:
    """The residual is at most the tolerance times the size of the forces in its norm over nodes."""
    force, turning = sums(moment)
    if axisymmetric:
        force, turning = force[1:], 0.0 * turning
    left = np.sqrt(moment.nodes) * max(TOLERANCE, moment.residual) * moment.size
    if (found := float(np.abs(force).max())) > left:
        yield f"force {found / moment.size:.1e} of {moment.size:.1e} at time {moment.time:g}"
    gaps = sum(float(np.linalg.norm(moment.forces[name])) for name in moment.between)
    carried = LARGEST_GAP * CELL * gaps
    if (found := float(np.abs(turning).max())) > left * moment.arm + carried:
        size = moment.size * moment.arm
        yield f"moment {found / size:.1e} at time {moment.time:g}"
