# SPDX-License-Identifier: BSD-3-Clause
"""A fixed-free elastic bar in its first mode: period, order, energy, damping of the schemes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tilth.analysis.energies import Energies
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.terms.inertia import TimeIntegration
from tilth.terms.motion import Motion
from tilth_verification.cases import example, folder_of_cases, varied
from tilth_verification.comparison import Comparison, absolute, relative, vanishing

PROBLEM = "elastic_bar"
LENGTH, SPEED = 1.0, 100.0
"""Of the bar [m] and of waves in it [m/s]."""
PERIOD = 4.0 * LENGTH / SPEED
"""[s]"""
CELLS, STEPS = 40, 80
"""Of the case file; steps of a period."""
RADII = (1.0, 0.8, 0.5, 0.0)
COARSE = 20
"""Steps of a period where damping is compared."""


@dataclass(frozen=True)
class Vibration:
    """A free vibration of the bar.

    Attributes:
        eigenvalue: of the tip's displacement from step to step, complex.
        size: of the steps [s].
        drift: greatest change of kinetic and elastic energy over that at the start [-].
    """

    eigenvalue: complex
    size: float
    drift: float

    @property
    def period(self) -> float:
        """Period [s]."""
        return 2.0 * math.pi * self.size / math.atan2(self.eigenvalue.imag, self.eigenvalue.real)


def comparisons(long: bool) -> Iterator[Comparison]:
    """Period, order and damping; long: the energy over ten periods, and finer grids."""
    run = vibrate(CELLS, STEPS, 10 if long else 2)
    label = f"{CELLS} cells, {STEPS} steps a period"
    yield relative(f"period, {label}", run.period, PERIOD, 2e-3, "4 L / c", "s")
    exact = period_of_the_method(CELLS, STEPS)
    source = "eigenvalues of the discrete mass, stiffness and time integration"
    yield relative(f"period, {label}", run.period, exact, 1e-6, source, "s")
    quantity = f"change of the energy over {10 if long else 2} periods, Newmark"
    yield vanishing(quantity, run.drift, 1e-6, "nothing is lost")
    yield from orders((10, 20, 40, 80) if long else (10, 20, 40))
    for radius in RADII:
        found = vibrate(10, COARSE, 3, radius)
        wanted = amplification(TimeIntegration.generalised_alpha(radius), 10, COARSE)
        quantity = f"amplitude after a step over that before, spectral radius {radius:g}"
        source = "eigenvalue of the amplification matrix"
        yield absolute(quantity, abs(found.eigenvalue), abs(wanted), 1e-6, source)


def orders(cells: tuple[int, ...]) -> Iterator[Comparison]:
    """The orders of the error of the frequency in space and of the period in time."""
    exact = 2.0 * math.pi / PERIOD
    space = [abs(frequency(vibrate(n, STEPS, 1)) / exact - 1.0) for n in cells]
    steps = tuple(2 * n for n in cells)
    semi_discrete = 2.0 * math.pi / frequency_of_the_method(cells[0])
    time = [abs(vibrate(cells[0], n, 1).period / semi_discrete - 1.0) for n in steps]
    for where, errors, numbers in (("space", space, cells), ("time", time, steps)):
        for coarse, fine, n in zip(errors, errors[1:], numbers[1:], strict=False):
            unit = "cells" if where == "space" else "steps a period"
            quantity = f"order of the period in {where}, to {n} {unit}"
            yield absolute(quantity, math.log2(coarse / fine), 2.0, 0.05, "the method's order")


def frequency(run: Vibration) -> float:
    """Returns the circular frequency [1/s] of a run without the error of the trapezoidal rule."""
    return 2.0 / run.size * math.tan(math.pi * run.size / run.period)


def frequency_of_the_method(cells: int) -> float:
    """Returns the lowest circular frequency [1/s] of the grid with two points per cell.

    The mass of a cell m is m [[5, 3], [3, 5]] / 16: points at a quarter and three quarters.
    """
    h = LENGTH / cells
    cosine = math.cos(0.5 * math.pi * h / LENGTH)
    return SPEED / h * math.sqrt(2.0 * (1.0 - cosine) / (0.625 + 0.375 * cosine))


def period_of_the_method(cells: int, steps: int) -> float:
    """Returns the period [s] with the trapezoidal rule."""
    size = PERIOD / steps
    return math.pi * size / math.atan(0.5 * size * frequency_of_the_method(cells))


def amplification(method: TimeIntegration, cells: int, steps: int) -> complex:
    """Returns the principal eigenvalue of the method's amplification matrix, from step to step."""
    size, stiffness = PERIOD / steps, frequency_of_the_method(cells) ** 2
    _, by_u = method.derivatives(size)
    columns = []
    for u, v, w, a in np.eye(4):  # displacement, velocity, acceleration, algorithmic acceleration
        before = Motion(np.array([v]), np.array([w]), np.array([a]))
        constant = method.after(np.zeros(1), size, before).acceleration
        moved = -(constant + stiffness * u) / (by_u + stiffness)
        after = method.after(moved, size, before)
        motion = (after.velocity, after.acceleration, after.algorithmic)
        columns.append([float(u + moved[0]), *(float(each[0]) for each in motion)])
    values = np.linalg.eigvals(np.array(columns).T)
    oscillating = values[values.imag > 1e-6]
    return complex(oscillating[np.abs(oscillating).argmax()])


def vibrate(cells: int, steps: int, periods: int, radius: float | None = None) -> Vibration:
    """Runs periods of the bar; radius: spectral radius of generalised-alpha, None for Newmark."""
    scheme: dict[str, object] = {"scheme": "newmark"}
    if radius is not None:
        scheme = {"scheme": "generalised_alpha", "spectral_radius": radius}
    mode: Path = folder_of_cases() / PROBLEM / "mode.py"
    changes = {
        "analysis.inertia": scheme,
        "grid.cell_size": LENGTH / cells,
        "bodies.0.shape.upper": [LENGTH, LENGTH / cells],
        "initial.velocity.0.x": f"{mode}:velocity",
        "schedule": {"end": periods * PERIOD, "steps": periods * steps},
    }
    model = varied(example(PROBLEM), changes)
    simulation = Simulation(model)
    simulation.check()
    points, energies = (
        simulation.state.points,
        Energies.at_start(simulation.setup, simulation.state),
    )
    tip = points.point_id[[points.position[:, 0].argmax()]]
    moved, stored = [0.0], [energies.start]
    for number in range(periods * steps):
        schedule = model.schedule
        simulation.advance(schedule.regular_time(number), schedule.regular_time(number + 1))
        moved.append(float(points.displacement[points.index_of(tip)[0], 0]))
        kinetic = energies.value("kinetic", simulation.setup, simulation.state, 0.0)
        stored.append(kinetic + energies.value("elastic", simulation.setup, simulation.state, 0.0))
    drift = float(np.abs(np.array(stored) / energies.start - 1.0).max())
    return Vibration(eigenvalue_of(np.array(moved)), PERIOD / steps, drift)


def eigenvalue_of(values: Floats) -> complex:
    """Returns lambda of values Re(A lambda^n): least squares of their recurrence.

    The first half, in which other eigenvalues of the time integration decay, is left out.
    """
    kept = values[len(values) // 2 :]
    table = np.column_stack([kept[1:-1], kept[:-2]])
    (first, second), *_ = np.linalg.lstsq(table, kept[2:], rcond=None)
    return complex(0.5 * first, math.sqrt(max(-second - 0.25 * first**2, 0.0)))
