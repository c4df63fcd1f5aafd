# SPDX-License-Identifier: BSD-3-Clause
"""Balances of force, moment and energy of a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from metamorphic.bounds import (
    CONTACT_ENERGY,
    LARGEST_GAP,
    LEAST_DISSIPATION,
    LEAST_FRICTION,
    OF_WATER,
    STEP_ENERGY,
)
from metamorphic.models import CELL, TOLERANCE
from metamorphic.runs import Moment
from metamorphic.subject import Subject

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
            least = LEAST_FRICTION if name == "friction_dissipation" else LEAST_DISSIPATION
            if gain < -least * most and (
                name != "plastic_dissipation" or subject.choice["stages"] not in CHANGES_ENERGY
            ):
                yield f"{name} {gain / most:.1e} of the energy at time {moment.time:g}"
            before[name] = moment.energies[name]


def _energy(subject: Subject) -> Iterator[str]:
    """Work is stored, also in the aids of the solution, or dissipated.

    But for the error of the trapezoidal rule: it is of the order of the strain of a step, where
    soil yields, radiates or comes into contact of the work.
    """
    run = subject.run
    last = run.moments[-1].energies
    size = max(abs(energy) for m in run.moments for energy in m.energies.values())
    springs = sum(moment.spring_work for moment in run.moments)
    error = abs(last["numerical_dissipation"] - sum(last[kind] for kind in STATED) - springs)
    strain = max(float(np.abs(m.displacement).max()) for m in run.moments) / run.cell
    share = STEP_ENERGY * strain
    if subject.choice["water"] != "none" and subject.choice["initial"] == "none":
        share += OF_WATER
    if subject.choice["contact"] != "none":
        share = CONTACT_ENERGY
    gone = sum(abs(last[name]) for name in (*LOST, "radiation"))
    bound = share * size + gone + TOLERANCE * size
    if error > bound:
        yield f"energy {error / size:.1e} of {size:.1e} is not found, at most {bound / size:.1e}"
