# SPDX-License-Identifier: BSD-3-Clause
"""Soil that meets an implicit boundary within a step does not pass through it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import plane

from tilth import Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.mpm.domains import half_edges

CELL = 0.25
PLANE = flat([0.0, -0.3], [0.0, 1.0])
CIRCLE = {"type": "circle", "centre": [6.0, -1.3], "radius": 1.0, "soil": "outside"}
REACTION = {"plane": 78.7e3, "circle": 69.8e3}
"""Of the roller [N], of the beam's 100 kN: the same however many steps there are."""


def beam(steps: int, roller: dict[str, Any], basis: str = "gimp") -> Model:
    """A cantilever 10 m long and 1 m high, clamped on its left, that sags onto a roller."""
    return Model.from_dict(
        {
            "format": 1,
            "analysis": {"kind": "plane_strain"},
            "grid": {"cell_size": CELL},
            "materials": {
                "elastic": {
                    "model": "hencky_elastic", "young_modulus": 1e6, "poisson_ratio": 0.2,
                    "density": 1000.0,
                }
            },
            "bodies": [
                {
                    "name": "beam", "material": "elastic", "basis": basis, "points_per_cell": 2,
                    "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [10.0, 1.0]},
                }
            ],
            "boundaries": [
                plane("wall", "x", 0.0, condition="fixed"), implicit("roller", roller),
            ],
            "loads": [{"type": "body_force", "acceleration": [0.0, -10.0]}],
            "schedule": {"steps": steps},
        }
    )  # fmt: skip


def depth_of_lower_face(simulation: Simulation) -> float:
    """Mean depth behind the roller of the domains that are there, in cells."""
    points = simulation.state.points
    (roller,) = simulation.state.implicit
    edges = half_edges(points)
    half = points.half_length[:, 1] if edges is None else np.abs(edges[:, :, 1]).sum(axis=1)
    depth = half - roller.distance(points.position, 1.0)
    deep = depth[depth > 0.0]
    return float(deep.mean()) / CELL if len(deep) else 0.0


@pytest.mark.parametrize("roller", ["plane", "circle"])
@pytest.mark.parametrize("steps", [1, 2, 5, pytest.param(20, marks=pytest.mark.long),
                                   pytest.param(80, marks=pytest.mark.long)])  # fmt: skip
def test_a_beam_that_sags_onto_a_roller_stays_in_front(roller: str, steps: int) -> None:
    reactions: list[float] = []

    def keep(simulation: Simulation, result: StepResult, time: float) -> None:
        reactions.append(result.resultant("roller")[1])

    simulation = march(beam(steps, PLANE if roller == "plane" else CIRCLE), keep)
    assert len(reactions) > steps or steps > 5  # the step in which it is reached was cut
    assert depth_of_lower_face(simulation) < 0.02
    assert reactions[-1] == pytest.approx(REACTION[roller], rel=0.01)


@pytest.mark.parametrize("basis", ["gimp", "cpdi2"])
@pytest.mark.parametrize("corner", ["point", "edge"])
def test_a_polygon_that_is_dropped_on_a_corner_stays_in_front(basis: str, corner: str) -> None:
    """Pushed down by its upper face: a square on its tip, and on the tip of a polyline."""
    tip = np.array([2.0, 0.35])
    if corner == "point":
        shape = tip + np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 2.0], [-1.0, 1.0]])
        geometry = flat([0.0, 0.0], [0.0, 1.0])
    else:
        shape = tip + np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]])
        geometry = {
            "type": "polyline", "vertices": [[0.0, -2.0], [2.0, 0.0], [4.0, -2.0]], "soil": "left",
        }  # fmt: skip
    top = float(shape[:, 1].max())
    entries = beam(2, geometry, basis).to_dict()
    body = entries["bodies"][0]
    body["shape"] = {"type": "polygon", "vertices": shape.tolist()}
    entries["loads"] = []
    entries["boundaries"] = [
        implicit("platen", flat([2.0, top - 0.1], [0.0, -1.0]), "fixed",
                 displacement={"y": -0.6}),
        entries["boundaries"][1],
    ]  # fmt: skip
    simulation = march(Model.from_dict(entries))
    roller = simulation.state.implicit[1]
    distance = roller.distance(simulation.state.points.position, 1.0)
    assert distance.min() > 0.15 * CELL  # a quarter is half a domain's width
