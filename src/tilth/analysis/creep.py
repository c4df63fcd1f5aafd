# SPDX-License-Identifier: BSD-3-Clause
"""Soil creeps against a drag, in pseudo-time, to its equilibrium or without end.

Where Newton's iteration finds no equilibrium, the motion says whether there is one. With a drag D
on the nodes the soil moves by D du/ds + r(u) = 0, r the residual of the balance without drag. Steps
of backward Euler in the pseudo-time s,

    r(u) + D (u - u_before) / s = 0,

converge the better the shorter they are, however little holds the soil. Soil that has an
equilibrium slows down and comes to rest in it; soil that has none moves on, at a speed at which the
drag bears what its strength does not. There is no inertia that could overshoot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from tilth.analysis.residual import Newton
from tilth.analysis.step import Equilibrium
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.terms.drag import Drag

PSEUDO_STEPS = 60
"""Pseudo-steps that are tried, at most."""

LEAST_SIZE = 1e-4
"""Least size of a pseudo-step; in one of size 1 the drag is as stiff as all soil."""

GROWTH = 2.0
"""Ratio of a pseudo-step's size to that of the one before, if that was found."""

CUT = 0.25
"""Ratio of its size to that of one that was not found."""

FIRST_REST = 3
"""Pseudo-steps before the first search for an equilibrium without drag; before each later one there
are twice as many, since such a search takes long where it fails."""

TOLERANCE = 1e-5
"""Relative residual of a pseudo-step [-]: it only has to lead on."""

Solve = Callable[[Newton, Floats, Floats | None], Equilibrium]
"""Solves the balance by Newton's iteration from a displacement (nodes, dim) and global unknowns
(m,), None for those at the start of the step; raises `StepFailed`."""


def creep(
    solve: Solve, drag: Drag, newton: Newton, displacement: Floats, unknowns: Floats | None
) -> Iterator[tuple[Equilibrium, bool]]:
    """Lets the soil creep from a displacement (nodes, dim) and global unknowns (m,).

    Args:
        solve: the balance with the drag.
        drag: its stiffness is set.
        newton: the iteration for the equilibrium without drag.
        displacement, unknowns: where the soil is: in equilibrium with another load or strength.

    Yields:
        Where the soil is after each pseudo-step, and False; last of all its equilibrium without
        drag, and True, if it comes to rest within `PSEUDO_STEPS`.
    """
    loose = replace(newton, tolerance=max(TOLERANCE, newton.tolerance))
    size, taken, rest = 1.0, 0, FIRST_REST
    try:
        for _ in range(PSEUDO_STEPS):
            drag.before, drag.size = displacement, size
            try:
                found = solve(loose, displacement, unknowns)
            except StepFailed:
                size *= CUT
                if size < LEAST_SIZE:
                    return
                continue
            displacement, unknowns = found.displacement, found.global_unknowns
            size, taken = GROWTH * size, taken + 1
            yield found, False
            if taken == rest:
                rest *= 2
                drag.size = np.inf
                try:
                    at_rest = solve(newton, displacement, unknowns)
                except StepFailed:
                    continue
                yield at_rest, True
                return
    finally:
        drag.size = np.inf
