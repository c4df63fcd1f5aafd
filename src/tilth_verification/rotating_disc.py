# SPDX-License-Identifier: BSD-3-Clause
"""A free elastic disc that turns about its centre: angular momentum and energy over ten turns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.comparison import Comparison, vanishing

PROBLEM = "rotating_disc"
TURNS = 10
STEPS = 100
"""Of a turn, which takes a second."""
RADIUS = 0.5
"""[m]"""
BEST = "gimp"
"""The basis that keeps the angular momentum best."""
SOURCE = "no moment acts on the disc"


@dataclass(frozen=True)
class Kept:
    """What a turning disc lost, relative to what it had at the start [-].

    Attributes:
        momentum: change of the angular momentum.
        energy: change of the kinetic and elastic energy.
        drift: distance of the centre of mass from where its velocity at the start takes it, over
            the radius. The points of a round body have their centre a little beside its own.
    """

    momentum: float
    energy: float
    drift: float


def comparisons(long: bool) -> Iterator[Comparison]:
    """Ten turns with the best basis; long: with each basis."""
    for basis in BASES if long else (BEST,):
        kept = turned(with_basis(example(PROBLEM), basis), TURNS)
        tolerance = 1e-3 if basis == BEST else 2e-3
        quantity = f"change of the angular momentum, {TURNS} turns, {basis}"
        yield vanishing(quantity, kept.momentum, tolerance, SOURCE)
        quantity = f"drift of the centre of mass over the radius, {TURNS} turns, {basis}"
        yield vanishing(quantity, kept.drift, 1e-8, "no force acts on the disc")


def table() -> Iterator[tuple[str, str, Kept]]:
    """Yields basis, scheme and what was kept over ten turns: the table of the example's README."""
    for basis in BASES:
        for scheme in ("newmark", "generalised_alpha"):
            inertia: dict[str, object] = {"scheme": scheme}
            if scheme == "generalised_alpha":
                inertia["spectral_radius"] = 0.8
            model = varied(with_basis(example(PROBLEM), basis), {"analysis.inertia": inertia})
            yield basis, scheme, turned(model, TURNS)


def turned(model: Model, turns: int) -> Kept:
    """Turns the disc of a model, with `STEPS` steps a turn."""
    simulation = Simulation(model)
    simulation.check()
    points = simulation.state.points
    first, energy, centre = momentum(points), energy_of(points), centre_of(points)
    velocity = points.mass @ points.motion[:, 0] / points.mass.sum()
    for number in range(STEPS * turns):
        simulation.advance(number / STEPS, (number + 1) / STEPS)
    way = float(np.linalg.norm(centre_of(points) - centre - turns * velocity)) / RADIUS
    return Kept(momentum(points) / first - 1.0, energy_of(points) / energy - 1.0, way)


def centre_of(points: MaterialPoints) -> Floats:
    """Returns the centre of mass [m], shape (2,)."""
    return np.asarray(points.mass @ points.position / points.mass.sum())


def momentum(points: MaterialPoints) -> float:
    """Returns the angular momentum about the centre of mass [kg m^2/s per m]."""
    arm, velocity = points.position - centre_of(points), points.motion[:, 0]
    return float(points.mass @ (arm[:, 0] * velocity[:, 1] - arm[:, 1] * velocity[:, 0]))


def energy_of(points: MaterialPoints) -> float:
    """Returns the kinetic and elastic energy [J/m]."""
    return points.kinetic_energy(points.mass) + points.stored_energy()
