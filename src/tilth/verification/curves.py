# SPDX-License-Identifier: BSD-3-Clause
"""Force of a driven boundary against the way that it has moved, and how two such curves compare."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tilth.analysis.simulation import Simulation, StepResult
from tilth.arrays import Floats
from tilth.model import ImplicitBoundary, Model
from tilth.verification.march import march


@dataclass(frozen=True)
class Curve:
    """way: of the boundary, ascending, shape (n,); force: after each of n steps, shape (n,)."""

    way: Floats
    force: Floats

    def at(self, way: float | Floats) -> Floats:
        """Returns the force at some way, linear between the steps."""
        return np.asarray(np.interp(way, self.way, self.force))

    def after(self, start: float) -> Curve:
        """Returns the part of the curve from a way on."""
        kept = self.way >= start * (1.0 - 1e-9)
        return Curve(self.way[kept], self.force[kept])

    def roughness(self, increments: int, start: float) -> float:
        """Returns the RMS of the second difference of the force over its mean [-].

        Args:
            increments: equal ones of the whole way.
            start: way from which on they count.
        """
        even = np.linspace(0.0, self.way[-1], increments + 1)
        force = self.at(even)[even >= start * (1.0 - 1e-9)]
        return float(np.sqrt((np.diff(force, 2) ** 2).mean()) / force.mean())


def farthest(curve: Curve, reference: Curve, start: float) -> tuple[float, float, float]:
    """Returns where two curves are farthest apart, relative, and both forces there.

    start: way from which on they count; the steps of `curve` are compared up to the shorter way.
    """
    curve = curve.after(start)
    common = curve.way <= reference.way[-1] * (1.0 + 1e-9)
    exact = reference.at(curve.way[common])
    worst = int(np.abs(curve.force[common] / exact - 1.0).argmax())
    return float(curve.way[worst]), float(curve.force[worst]), float(exact[worst])


def driven(model: Model) -> Curve:
    """Runs a model whose first tracked quantity is the reaction of the one boundary that moves.

    The way is that of its displacement [length]; the force has the scale of the tracked quantity.
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
    way, force = np.array(rows).T
    return Curve(way, force)
