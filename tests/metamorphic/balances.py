# SPDX-License-Identifier: BSD-3-Clause
"""Balances of force, moment and energy of a run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from metamorphic.bounds import (
    CONTACT_ENERGY,
    CROSSING_ENERGY,
    LARGEST_GAP,
    LEAST_DISSIPATION,
    OF_WATER,
    STEP_ENERGY,
)
from metamorphic.lines import come_into_other_cells, hang_over, motion
from metamorphic.models import CELL, TOLERANCE
from metamorphic.runs import Moment
from metamorphic.subject import Subject
from tilth.arrays import Floats

LOST = ("plastic_dissipation", "friction_dissipation", "damping_dissipation")
STATED = ("time_integration", "stabilisation", "contact_gaps")
"""What of numerical_dissipation has a formula of its own."""
CHANGES_ENERGY = ("excavate", "remove", "fill", "refill", "exchange")
"""Kinds of stages in which elastic energy comes or goes with soil or its stiffness."""


def faults(subject: Subject) -> Iterator[str]:
    """Yields the balances that do not hold after a step."""
    dynamic = "inertia" in subject.entries["analysis"]
    for moment in subject.run.moments:
        if not dynamic:
            yield from _forces(moment, subject.kind == "axisymmetric")
    yield from _dissipation(subject)
    if subject.choice["stages"] not in CHANGES_ENERGY:
        yield from _energy(subject)


def _forces(moment: Moment, axisymmetric: bool) -> Iterator[str]:
    """All forces on the soil and their moments: in equilibrium they sum to zero.

    The norm of the residual over the nodes is at most the tolerance times the size of the forces.
    """
    names = [name for name in moment.forces if name not in moment.between]
    force = moment.load + sum(moment.forces[name] for name in names)
    turning = moment.load_moment + sum(moment.moments[name] for name in names)
    if axisymmetric:  # along the radius, and round the ring, they balance in the soil
        force, turning = force[1:], 0.0 * turning
    left = np.sqrt(moment.nodes) * max(TOLERANCE, moment.residual) * moment.size
    if (found := float(np.abs(force).max())) > left:
        yield f"force {found / moment.size:.1e} of {moment.size:.1e} at time {moment.time:g}"
    gaps = sum(float(np.linalg.norm(moment.forces[name])) for name in moment.between)
    largest = left * moment.arm + LARGEST_GAP * CELL * gaps
    if (found := float(np.abs(turning).max())) > largest:
        yield f"moment {found / (moment.size * moment.arm):.1e} at time {moment.time:g}"


def _dissipation(subject: Subject) -> Iterator[str]:
    """What is dissipated does not come back."""
    before = dict.fromkeys(LOST, 0.0)
    for moment in subject.run.moments:
        most = max(abs(energy) for energy in moment.energies.values())
        for name in LOST:
            gain = moment.energies[name] - before[name]
            if gain < -LEAST_DISSIPATION * most and (
                name != "plastic_dissipation" or subject.choice["stages"] not in CHANGES_ENERGY
            ):
                yield f"{name} {gain / most:.1e} of the energy at time {moment.time:g}"
            before[name] = moment.energies[name]


def _energy(subject: Subject) -> Iterator[str]:
    """Work is stored, also in the aids of the solution, or dissipated, or lost between the steps.

    What is lost is kinetic energy that the grid has at the end of a step, and does not get back
    from the points. The rest holds but for the error of the trapezoidal rule: it is of the order of
    the strain of a step, where soil yields, radiates or comes into contact of the work.
    """
    run = subject.run
    last = run.moments[-1].energies
    size = max(abs(energy) for m in run.moments for energy in m.energies.values())
    springs = sum(moment.spring_work for moment in run.moments)
    lost = sum(moment.kinetic_change for moment in run.moments) - last["kinetic"]
    stated = sum(last[kind] for kind in STATED) + springs + lost
    error = abs(last["numerical_dissipation"] - stated)
    cell = run.cell * (0.5 if subject.choice["stages"] == "grid" else 1.0)
    strain = max(float(np.abs(m.displacement).max()) for m in run.moments) / cell
    share = STEP_ENERGY * strain
    if subject.choice["water"] != "none" and subject.choice["initial"] == "none":
        share += OF_WATER
    gone = sum(abs(last[name]) for name in (*LOST, "radiation"))
    bound = share * size + gone + TOLERANCE * size + CONTACT_ENERGY * _work_of_contact(subject)
    linear = subject.choice["basis"] == "linear"
    bound += CROSSING_ENERGY * _work_of_crossings(run.moments, linear)
    if error > bound:
        yield f"energy {error / size:.1e} of {size:.1e} is not found, at most {bound / size:.1e}"


def _work_of_contact(subject: Subject) -> float:
    """The sum over steps of the changes of forces of contact times the greatest motion."""
    choice, total = subject.choice, 0.0
    names = {"driver": choice["driver"].startswith("rigid"), "pair": True}
    names["base"] = choice["base"] == "contact"
    force: dict[str, Floats] = {}
    place: dict[str, Floats] = {}
    for moment in subject.run.moments:
        now = {"soil": moment.displacement, **moment.bodies}
        motion = max(
            float(np.abs(x - place.get(name, np.zeros_like(x))).max()) for name, x in now.items()
        )
        for name in (each for each in moment.forces if names.get(each)):
            change = moment.forces[name] - force.get(name, np.zeros_like(moment.forces[name]))
            total += float(np.linalg.norm(change)) * motion
        force, place = moment.forces, now
    return total


def _work_of_crossings(moments: list[Moment], linear: bool) -> float:
    """The sum of forces times motion over the steps that begin out of balance at lines of the grid.

    With linear functions those after which points are in other cells.
    """
    over, total = hang_over(moments), 0.0
    for (before, after), begins in zip(pairwise(moments), over, strict=True):
        if begins or (linear and come_into_other_cells([before, after])):
            total += after.size * motion(before, after)
    return total
