# SPDX-License-Identifier: BSD-3-Clause
"""Blocks and discs on implicit boundaries, and all their load steps, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from small_problems import block_entries, dimension

from tilth import Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats

MODULUS, DENSITY, GRAVITY = 1000.0, 2.0, 9.0
"""Young's modulus [stress], density and acceleration of the soil."""

CELL = {"plane_strain": 0.25, "axisymmetric": 0.25, "3d": 0.5}
SQUARE = {"type": "box", "lower": [0.1, 0.2], "upper": [1.1, 1.2], "angle": 20.0}
BRICK = {
    "type": "box", "lower": [0.1, 0.2, 0.3], "upper": [1.1, 1.2, 1.3], "angle": 25.0, "axis": "x",
}  # fmt: skip
DISC = {"type": "circle", "centre": [0.1, 0.2], "radius": 1.0}
TURN = np.radians(20.0)
ALONG = np.array([np.cos(TURN), np.sin(TURN)])
ACROSS = np.array([-np.sin(TURN), np.cos(TURN)])
"""Directions of the sides of `SQUARE`."""


def implicit(name: str, geometry: dict[str, Any], condition: str = "roller", **more: Any) -> Any:
    declared = {"type": "implicit", "name": name, "condition": condition, "geometry": geometry}
    return {**declared, **more}


def flat(point: Any, normal: Any) -> dict[str, Any]:
    return {"type": "plane", "point": list(point), "normal": list(normal)}


def gravity(dim: int, **more: Any) -> dict[str, Any]:
    return {"type": "body_force", "acceleration": [0.0] * (dim - 1) + [-GRAVITY], **more}


def model_of(
    kind: str, basis: str, shape: dict[str, Any], boundaries: list[Any], steps: int = 4, **more: Any
) -> Model:
    """A body of Young's modulus `MODULUS` and nu = 0.3."""
    entries = block_entries(
        kind, basis, boundaries=boundaries, schedule={"steps": steps, "outputs": 1}, **more
    )
    entries["analysis"]["tolerance"] = 1e-11
    entries["grid"]["cell_size"] = CELL[kind]
    entries["bodies"][0]["shape"] = shape
    if basis == "gimp":
        entries["bodies"][0]["domain_update"] = "right_stretch"
    return Model.from_dict(entries)


def steps_of(model: Model) -> tuple[Simulation, list[StepResult]]:
    """All steps; none may have been cut."""
    results: list[StepResult] = []
    simulation = march(model, lambda simulation, result, time: results.append(result))
    assert len(results) == model.schedule.number_of_steps
    return simulation, results


def by_number(simulation: Simulation) -> Floats:
    points = simulation.state.points
    return points.position[points.index_of(np.arange(len(points)))]


def squeezed(kind: str, basis: str, condition: str, delta: float, **more: Any) -> Model:
    """A block off the grid lines between rollers that a platen squeezes to half its height."""
    dim = dimension(kind)
    h = CELL[kind]
    lower = np.full(dim, 0.3 * h)
    if kind == "axisymmetric":
        lower[0] = 0.0
    upper, unit = lower + 1.0, np.eye(dim)
    sides = []
    for k in range(dim):
        if kind != "axisymmetric" or k > 0:
            sides.append(implicit(f"low {k}", flat(lower, unit[k]), delta=delta * h))
        if k < dim - 1:
            sides.append(implicit(f"high {k}", flat(upper, -unit[k]), delta=delta * h))
    sides.append(
        implicit(
            "platen", flat(upper, -unit[-1]), condition, delta=delta * h,
            displacement={"xyz"[dim - 1]: -0.5},
        )
    )  # fmt: skip
    shape = {"type": "box", "lower": lower.tolist(), "upper": upper.tolist()}
    return model_of(kind, basis, shape, sides, **{"steps": 8, **more})
