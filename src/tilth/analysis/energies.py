# SPDX-License-Identifier: BSD-3-Clause
"""Energies of an analysis, and what of the work done on the soil is not found again in them."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.mpm.wet_mass import total_mass

ENERGY_KINDS = (
    "external_work",
    "elastic",
    "kinetic",
    "plastic_dissipation",
    "friction_dissipation",
    "damping_dissipation",
    "radiation",
    "numerical_dissipation",
    "time_integration",
    "stabilisation",
    "contact_gaps",
)
"""Kinds of energy, in the order of the columns of energies.csv: all but "seepage"."""


@dataclass
class Energies:
    """Energies that are sums over the steps [force length].

    Attributes:
        start: elastic and kinetic energy before the first step.
        work: work of loads, boundaries and rigid bodies: of a body in contact its force times its
            own motion.
        friction: what friction dissipated of it.
        damping: what Rayleigh damping dissipated of it.
        radiated: what left through absorbing boundaries less what came in.
        integration: what the time integration dissipated of it, by its own formula.
        stabilisation: what ghost stabilisation took of it, by its own formula.
        gaps: what contact took of it where gaps closed or opened, by its own formula.
        seepage: what flowing water dissipated of it.
    """

    start: float = 0.0
    work: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    radiated: float = 0.0
    integration: float = 0.0
    stabilisation: float = 0.0
    gaps: float = 0.0
    seepage: float = 0.0

    @classmethod
    def at_start(cls, setup: Setup, state: State) -> Energies:
        """Returns those before the first step."""
        return cls(start=stored_energy(state) + kinetic_energy(setup, state, 0.0))

    def add(self, result: StepResult) -> None:
        """Adds those of a converged step."""
        self.work += result.work
        self.friction += result.friction_work
        self.damping += result.damping_work
        self.radiated += result.radiated_work
        self.integration += result.integration_work
        self.stabilisation += result.stabilisation_work
        self.gaps += result.gap_work
        self.seepage += result.seepage_work

    def value(self, kind: str, setup: Setup, state: State, time: float) -> float:
        """Returns an energy after the steps to a time of the stage, by its kind as in `Track`."""
        if kind == "elastic":
            return stored_energy(state)
        if kind == "kinetic":
            return kinetic_energy(setup, state, time)
        return self.values(setup, state, time)[kind]

    def values(self, setup: Setup, state: State, time: float) -> dict[str, float]:
        """Returns all energies after the steps to a time of the stage, by their kinds."""
        points, comm = state.owned_points, state.comm
        stored = {"elastic": stored_energy(state), "kinetic": kinetic_energy(setup, state, time)}
        lost = {
            "plastic_dissipation": comm.sum(float(points.plastic[:, 1] @ points.initial_volume)),
            "friction_dissipation": self.friction,
            "damping_dissipation": self.damping,
            "radiation": self.radiated,
            "seepage": self.seepage,
        }
        found = sum(stored.values()) + sum(lost.values())
        numerical = self.start + self.work - found
        return {
            "external_work": self.work, **stored, **lost, "numerical_dissipation": numerical,
            "time_integration": self.integration, "stabilisation": self.stabilisation,
            "contact_gaps": self.gaps,
        }  # fmt: skip


def stored_energy(state: State) -> float:
    """Returns the elastic energy of the soil of all processes [force length]."""
    return state.comm.sum(state.owned_points.stored_energy())


def kinetic_energy(setup: Setup, state: State, time: float) -> float:
    """Returns the kinetic energy of all soil, with the water in it [force length]."""
    points = state.owned_points
    mass = total_mass(points, setup.water, time)
    return state.comm.sum(points.kinetic_energy(mass))
