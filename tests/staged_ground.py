# SPDX-License-Identifier: BSD-3-Clause
"""Small models with stages: level ground in boxes, in kN, kPa and t."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from tilth import Model
from tilth.analysis.march import march_stages
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.mpm.points import MaterialPoints

UNIT_WEIGHT = 20.0
"""Of all soil here: density 2 t/m^3 times 10 m/s^2."""
WHOLE = [[0.0, 1.0], [1.0, 1.0]]
"""Table of a load that acts from the start."""


def elastic(young_modulus: float = 1e4, poisson_ratio: float = 0.25) -> dict[str, Any]:
    return {
        "model": "hencky_elastic",
        "young_modulus": young_modulus,
        "poisson_ratio": poisson_ratio,
        "density": 2.0,
    }


def box(name: str, lower: list[float], upper: list[float], **entries: Any) -> dict[str, Any]:
    return {
        "name": name,
        "material": "soil",
        "shape": {"type": "box", "lower": lower, "upper": upper},
        "basis": "gimp",
        "points_per_cell": 2,
        **entries,
    }


def plane(name: str, axis: str, at: float, **entries: Any) -> dict[str, Any]:
    """A roller on a grid line."""
    return {
        "name": name, "type": "plane", "axis": axis, "at": at, "condition": "roller", **entries,
    }  # fmt: skip


def wall(name: str, point: list[float], normal: list[float], **entries: Any) -> dict[str, Any]:
    """An implicit plane."""
    geometry = {"type": "plane", "point": point, "normal": normal}
    return {
        "name": name, "type": "implicit", "geometry": geometry, "condition": "roller", **entries,
    }  # fmt: skip


def gravity(dimension: int = 2, factor: Any = WHOLE) -> dict[str, Any]:
    down = [0.0] * (dimension - 1) + [-10.0]
    return {"type": "body_force", "name": "gravity", "acceleration": down, "factor": factor}


def at_rest(body: str, level: float, ratio: float = 1.0 / 3.0) -> dict[str, Any]:
    return {"type": "k0", "body": body, "K0": ratio, "ground": level}


def stage(name: str, steps: int = 1, **entries: Any) -> dict[str, Any]:
    return {"name": name, "schedule": {"steps": steps}, **entries}


def entries(**sections: Any) -> dict[str, Any]:
    """The entries of a model in plane strain on cells of 0.5 m, with an elastic soil."""
    return {
        "format": 1,
        "title": "stages",
        "units": {"force": "kN", "stress": "kPa", "mass": "t"},
        "analysis": {"kind": "plane_strain", "tolerance": 1e-11},
        "grid": {"cell_size": 0.5},
        "materials": {"soil": elastic()},
        "loads": [gravity()],
        **sections,
    }


def march(case: dict[str, Any]) -> tuple[StagedAnalysis, dict[str, Simulation], list[StepResult]]:
    """Runs a model; returns it at the end, with the starts of its stages and all results.

    The simulations are those of the stages, which go on to their ends.
    """
    starts: dict[str, Simulation] = {}
    results: list[StepResult] = []

    def at_start(analysis: StagedAnalysis) -> None:
        starts[analysis.simulation.setup.model.stage.name] = analysis.simulation

    analysis = march_stages(
        Model.from_dict(case), lambda _, result: results.append(result), at_start
    )
    return analysis, starts, results


class Reached(Exception):
    """The start of a stage."""


def at_start_of(case: dict[str, Any], name: str) -> tuple[StagedAnalysis, MaterialPoints]:
    """Returns the analysis at the start of a stage, and the points at the end of the one before."""
    points: dict[str, MaterialPoints] = {}

    def keep(analysis: StagedAnalysis) -> None:
        all_points = analysis.simulation.state.points
        points["end"] = all_points.selected(np.ones(len(all_points), dtype=bool))

    def reach(analysis: StagedAnalysis) -> None:
        if analysis.simulation.setup.model.stage.name == name:
            found.append(analysis)
            raise Reached

    found: list[StagedAnalysis] = []
    with suppress(Reached):
        march_stages(Model.from_dict(case), at_start=reach, at_end=keep)
    return found[0], points["end"]


def by_number(simulation: Simulation, name: str) -> Floats:
    """An array of the points in the order of their permanent numbers."""
    return np.asarray(getattr(simulation.state.points, name)[simulation.state.points.in_order])
