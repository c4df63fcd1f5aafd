# SPDX-License-Identifier: BSD-3-Clause
"""A perfectly plastic hollow sphere, widened from inside at its limit pressure."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import CircleGeometry, ImplicitBoundary
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, relative

PROBLEM = "hollow_sphere_limit"
OUTER = 2.0
"""Outer radius at the start [m]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """The pressure at a widening of 3 % with 5 and 10 cells through the wall."""
    del long
    for cells, tolerance in ((5, 0.03), (10, 0.01)):
        widening, pressure, exact = widen(1.0 / cells)
        quantity = f"pressure, inner face widened by {widening[-1]:.0%}, {cells} cells"
        yield relative(quantity, pressure[-1], exact[-1], tolerance, "2 Y ln(b / a)", "Pa")


def widen(h: float) -> tuple[npt.NDArray[np.float64], ...]:
    """Widens the sphere on cells of `h` [m].

    Returns widening of the inner face over its radius [-], pressure and limit pressure [stress]
    after each step, shape (steps,) each. The limit pressure is that of the current radii; the outer
    one follows from the inner one, as plastic flow keeps the volume.
    """
    model = varied(example(PROBLEM), {"grid.cell_size": h})
    face = next(b for b in model.boundaries if isinstance(b, ImplicitBoundary))
    assert isinstance(face.geometry, CircleGeometry)
    assert face.radius_change is not None
    inner, change = face.geometry.radius, face.radius_change
    yield_stress = model.materials["steel"].parameter("yield_stress")
    rows: list[tuple[float, ...]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        a = inner + change * model.load_curve(face).factor(time)
        b = (OUTER**3 + a**3 - inner**3) ** (1.0 / 3.0)
        pressure = result.resultant(face.name)[1] / (math.pi * a**2)
        rows.append((a / inner - 1.0, pressure, 2.0 * yield_stress * math.log(b / a)))

    march(model, after_step)
    return tuple(np.array(rows).T)
