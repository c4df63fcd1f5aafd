# SPDX-License-Identifier: BSD-3-Clause
"""Force-displacement curves of driven boundaries, their roughness and largest difference."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import ImplicitBoundary, Model


@dataclass(frozen=True)
class Curve:
    """displacement: of the boundary [length], ascending; force: in n steps; shape (n,) each."""

    displacement: Floats
    force: Floats

    def at(self, displacement: float | Floats) -> Floats:
        """Returns the force at a displacement, linear between the steps."""
        return np.asarray(np.interp(displacement, self.displacement, self.force))

    def after(self, start: float) -> Curve:
        """Returns the part of the curve from the displacement `start` on."""
        part = self.displacement >= start * (1.0 - 1e-9)
        return Curve(self.displacement[part], self.force[part])

    def roughness(self, increments: int, start: float) -> float:
        """Returns the RMS of the second difference of the force over its mean [-].

        Args:
            increments: number of equal increments of the whole displacement.
            start: displacement from which on the curve is evaluated.
        """
        even = np.linspace(0.0, self.displacement[-1], increments + 1)
        force = self.at(even)[even >= start * (1.0 - 1e-9)]
        return float(np.sqrt((np.diff(force, 2) ** 2).mean()) / force.mean())


def largest_difference(curve: Curve, reference: Curve, start: float) -> tuple[float, float, float]:
    """Returns the displacement of the largest relative difference, and the two forces there.

    start: displacement from which on the curves are compared; the steps of `curve` are compared up
    to the smaller of the two final displacements.
    """
    curve = curve.after(start)
    common = curve.displacement <= reference.displacement[-1] * (1.0 + 1e-9)
    exact = reference.at(curve.displacement[common])
    worst = int(np.abs(curve.force[common] / exact - 1.0).argmax())
    return float(curve.displacement[worst]), float(curve.force[worst]), float(exact[worst])


def reaction_curve(model: Model) -> Curve:
    """Returns the curve of a model's only moving boundary, whose reaction is tracked first.

    Runs the model. The displacement is the magnitude of that of the boundary [length]; the force
    has the scale of the tracked quantity.
    """
    track = model.track[0]
    moving = next(boundary for boundary in model.boundaries if boundary.name == track.boundary)
    assert isinstance(moving, ImplicitBoundary)
    assert moving.displacement is not None
    assert track.component is not None
    axis = "xyz".index(track.component)
    whole = math.hypot(*moving.displacement.values())
    rows: list[tuple[float, float]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        force = track.scale * result.resultant(moving.name)[axis]
        rows.append((whole * model.load_curve(moving).factor(time), force))

    march(model, after_step)
    displacement, force = np.array(rows).T
    return Curve(displacement, force)
