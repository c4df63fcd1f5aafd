# SPDX-License-Identifier: BSD-3-Clause
"""Soil creeps against a drag, in pseudo-time, to its equilibrium or without end.

Where Newton's iteration finds no equilibrium, the motion says whether there is one. With a drag D
on nodes and strains the soil moves by D du/ds + r(u) = 0, r the residual of the balance without
drag. Steps of backward Euler in the pseudo-time s,

    r(u) + D (u - u_before) / s = 0,

converge the better the shorter they are, however little holds the soil. Soil that has an
equilibrium slows down and comes to rest in it; soil that has none moves on, at a speed at which the
drag bears what its strength does not. There is no inertia that could overshoot. Steps of double
length each have half the drag, so that the soil is led to its equilibrium as by a viscosity that
vanishes; where flow without associated dilation snaps from one mechanism to another, it follows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from tilth.analysis.residual import Equations, Guess, Newton, Refinement
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import PreparedStep
from tilth.errors import StepFailed
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.terms.drag import Drag

PSEUDO_STEPS = 100
"""Pseudo-steps that are tried, at most."""

CIRCLING = 30
"""Pseudo-steps after which the soil goes round in a circle. From there on the plastic flow of each
is past: what the soil has done it cannot undo, and so it comes to rest."""

LEAST_SIZE = 1e-4
"""Least size of a pseudo-step; in one of size 1 the drag is as stiff as all soil."""

GROWTH, EASY = 2.0, 20
"""Ratio of a pseudo-step's size to that of the one before, if that took no more than so many
iterations; else they are of one size."""

CUT = 0.25
"""Ratio of its size to that of one that was not found."""

REST, LATER_REST, LAST = 1e-4, 0.1, 10
"""Share of the forces that the drag bears from which on the equilibrium is searched for without it
[-]; by what factor it falls before each later search; and the iterations of a search, at most."""

TOLERANCE, TIGHTER = 1e-5, 0.1
"""Relative residual of a pseudo-step [-], and its ratio to what the drag bears, at most."""

LARGEST_CREEP, LARGEST_SLUMP = 0.1, 1.0
"""Motion of a point, beyond what is prescribed, from which on soil does not come to rest in a step
[cells]; the latter where boundaries or bodies drive it, beside which soil crumbles and slumps."""

FALLING, PATIENCE = 1e-4, 6
"""Share of the forces that are not in equilibrium, with which soil may go on to fall beside what
drives it [-], and the number of pseudo-steps that it has to do so."""

Solve = Callable[[Newton, Guess], Equilibrium]
"""Solves the balance by Newton's iteration from a guess; raises `StepFailed`."""


@dataclass(frozen=True)
class Crept:
    """Where soil is after a pseudo-step, or its equilibrium.

    Attributes:
        found: its motion.
        borne: force that the drag bears, relative to all forces [-]; 0 in the equilibrium.
    """

    found: Equilibrium
    borne: float

    @property
    def at_rest(self) -> bool:
        """Whether it is in equilibrium without drag."""
        return self.borne == 0.0


def creep(
    solve: Solve,
    drag: Drag,
    newton: Newton,
    equations: Equations,
    guess: Guess,
    soil: Soil,
) -> Iterator[Crept]:
    """Lets the soil creep from where it is.

    Args:
        solve: the balance with the drag.
        drag: its stiffness is set.
        newton: the iteration for the equilibrium without drag.
        equations: of the balance.
        guess: where the soil is: in equilibrium with another load or strength.
        soil: that creeps.

    Yields:
        Where the soil is after each pseudo-step; last of all its equilibrium without drag if it
        comes to rest within `PSEUDO_STEPS`.
    """
    some = newton.refinement if newton.refinement is Refinement.NONE else Refinement.SOME
    last = replace(newton, maximum_iterations=LAST)
    size, rest, tolerance = 1.0, REST, TOLERANCE
    try:
        for number in range(PSEUDO_STEPS):
            drag.before, drag.size = guess.u, size
            loose = replace(newton, tolerance=max(tolerance, newton.tolerance), refinement=some)
            try:
                found = solve(loose, guess)
            except StepFailed:
                size *= CUT
                if size < LEAST_SIZE:
                    return
                continue
            guess = Guess(found.x.of, found.x.globals)
            if number >= CIRCLING:
                soil.flow(found.displacement)
            if found.iterations <= EASY:
                size *= GROWTH
            drag.size = np.inf
            borne = equations.at(found.x).relative
            tolerance = min(TOLERANCE, TIGHTER * borne)
            yield Crept(found, borne)
            if borne > rest:
                continue
            rest = LATER_REST * borne
            try:
                at_rest = solve(last, guess)
            except StepFailed:
                continue
            yield Crept(at_rest, 0.0)
            return
    finally:
        drag.size = np.inf


def crept_to_rest(
    step: PreparedStep,
    soil: Soil,
    own: MaterialPoints,
    warnings: RunWarnings,
    solve: Solve,
    drag: Drag,
    newton: Newton,
    guess: Guess,
    equations: Equations,
    reason: str,
) -> Equilibrium | None:
    """Returns the equilibrium to which the soil creeps in a step; None if it does not come to rest.

    Where boundaries or bodies drive the soil, a little of it may still fall at the end: that of
    which the drag bears less than `FALLING`. In a pseudo-step of size 1 the drag on the nodes is
    as stiff as a bar of all soil, E times its area over its length.

    Args:
        step, soil: the step.
        own: the points that this process owns.
        warnings: of the run.
        solve, drag, newton: see `creep`.
        guess: where it begins, with what is prescribed.
        equations: of the balance.
        reason: why Newton's iteration failed.
    """
    comm, owned = soil.active.comm, soil.active.owned
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
    drag.stiffness = shares * (young / whole) * around[soil.kind]
    driven = step.driven
    most = LARGEST_SLUMP if driven > 0.0 else LARGEST_CREEP
    bound = driven + most * float(step.active.grid.cell_size.min())
    slow = 0
    for each in creep(solve, drag, newton, equations, guess, soil):
        if each.at_rest:
            warnings.crept(reason, step.after)
            return each.found
        moved = np.linalg.norm(soil.interpolate(each.found.displacement), axis=1)
        if comm.max(float(moved.max(initial=0.0))) > bound:
            break
        slow = slow + 1 if each.borne <= FALLING else 0
        if driven > 0.0 and slow == PATIENCE:
            warnings.falls(each.borne, step.after)
            return replace(each.found, residuals=[*each.found.residuals, each.borne])
    soil.past = None
    return None
