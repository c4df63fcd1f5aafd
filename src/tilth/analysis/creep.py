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

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tilth.analysis.residual import Newton, Refinement, Residual
from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import PreparedStep
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.mpm.soil import Soil
from tilth.terms.drag import Drag

if TYPE_CHECKING:
    from tilth.analysis.simulation import Simulation

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

TOLERANCE, TIGHTER = 1e-5, 0.1
"""Relative residual of a pseudo-step [-], which only has to lead on, and its factor where it is met
without a motion."""

LARGEST_CREEP, LARGEST_SLUMP = 0.1, 1.0
"""Motion of a point, beyond what is prescribed, from which on soil does not come to rest in a step
[cells]; the latter where boundaries or bodies drive it, beside which soil crumbles and slumps."""

FALLING, PATIENCE = 1e-4, 6
"""Residual without the drag, relative to the forces, with which soil may go on to fall beside what
drives it [-], and the number of pseudo-steps after which that is tried."""

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
    some = newton.refinement if newton.refinement is Refinement.NONE else Refinement.SOME
    loose = replace(newton, tolerance=max(TOLERANCE, newton.tolerance), refinement=some)
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
            if found.iterations == 0 and loose.tolerance > newton.tolerance:
                loose = replace(loose, tolerance=max(TIGHTER * loose.tolerance, newton.tolerance))
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


def crept_to_rest(
    simulation: Simulation,
    step: PreparedStep,
    soil: Soil,
    solve: Solve,
    drag: Drag,
    newton: Newton,
    displacement: Floats,
    residual: Residual,
) -> Equilibrium | None:
    """Returns the equilibrium to which the soil creeps in a step; None if it does not come to rest.

    Where boundaries or bodies drive the soil, a little of it may still fall at the end: that of
    which the drag bears less than `FALLING`. In a pseudo-step of size 1 the drag is as stiff as a
    bar of all soil, E times its area over its length.

    Args:
        simulation: whose step it is.
        step, soil: the step.
        solve, drag, newton: see `creep`.
        displacement: of the nodes to begin with, prescribed motion included [length], (nodes, dim).
        residual: of the balance.
    """
    comm, own, owned = simulation.comm, simulation.owned_points, soil.active.owned
    young = comm.sum(float((own.elastic_moduli().young * own.volume).sum()))
    extent = [
        comm.max(float(x.max(initial=-math.inf))) + comm.max(float((-x).max(initial=-math.inf)))
        for x in own.position.T
    ]
    around = {
        "plane_strain": 1.0, "axisymmetric": 2.0 * math.pi * min(extent), "3d": min(extent)
    }  # fmt: skip
    whole = comm.sum(float(own.volume.sum()))
    shares = soil.nodal_volume / comm.sum(float(soil.nodal_volume[owned].sum()))
    drag.stiffness = shares * (young / whole) * around[simulation.kind]
    driven = step.driven
    most = LARGEST_SLUMP if driven > 0.0 else LARGEST_CREEP
    bound = driven + most * float(step.active.grid.cell_size.min())
    path = creep(solve, drag, newton, displacement, None)
    for number, (found, at_rest) in enumerate(path, start=1):
        if at_rest:
            return found
        moved = np.linalg.norm(soil.interpolate(found.displacement), axis=1)
        if comm.max(float(moved.max(initial=0.0))) > bound:
            return None
        if driven == 0.0 or number < PATIENCE:
            continue
        size, drag.size = drag.size, np.inf
        borne = residual.at(found.displacement, found.global_unknowns).relative
        drag.size = size
        if borne <= FALLING:
            simulation.run_warnings.falls(borne, step.after)
            return replace(found, residuals=[*found.residuals, borne])
    return None
