# SPDX-License-Identifier: BSD-3-Clause
"""Bodies of different displacement fields in one grid move as in analyses of their own."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from small_problems import BASES, KINDS, dimension, material_entries, plane, weight

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.grid import Buffers, Grid, locate
from tilth.solvers import linear_solver
from tilth.verification.march import march, march_stages

TOLERANCE = 1e-12
"""Largest difference relative to the largest value."""

NAMES = ("one", "two")


@pytest.fixture(autouse=True)
def _own_fields(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each body has a field of its own, without contact between them."""

    def fields(model: Model) -> dict[str, int]:
        return {body.name: number for number, body in enumerate(model.bodies)}

    monkeypatch.setattr(Model, "fields", fields)
    monkeypatch.setattr("tilth.model.placement.field_problems", lambda model: [])


def soils(
    kind: str, basis: str, gap: float, boundaries: list[dict[str, Any]], **body: Any
) -> dict[str, Any]:
    """Two blocks in the same cells, `gap` apart or, if it is negative, one in the other."""
    dim = dimension(kind)
    middle = [0.0] * (dim - 2), [1.5] * (dim - 2)
    boxes = [(0.0, 2.3), (2.3 + gap, 4.2 + gap)]
    heights = 1.8, 2.3
    return {
        "analysis": {"kind": kind, "solver": "superlu", "tolerance": 1e-13},
        "grid": {"cell_size": 1.0},
        "materials": {
            "one": material_entries("von_mises"), "two": material_entries("hencky_elastic"),
        },
        "bodies": [
            {
                "name": name,
                "material": name,
                "shape": {
                    "type": "box",
                    "lower": [low, *middle[0], 0.0],
                    "upper": [high, *middle[1], height],
                },
                "basis": basis,
                "spacing": 0.5,
                **body,
            }
            for name, (low, high), height in zip(NAMES, boxes, heights, strict=True)
        ],
        "boundaries": boundaries,
        "loads": [weight(kind, 5.0)],
        "schedule": {"steps": 2},
    }  # fmt: skip


def grid_lines(kind: str) -> list[dict[str, Any]]:
    up = "xyz"[dimension(kind) - 1]
    return [plane("base", up, 0.0, condition="fixed")]


def alone(entries: dict[str, Any], name: str) -> dict[str, Any]:
    """The same problem with one of the bodies."""
    entries = copy.deepcopy(entries)
    entries["bodies"] = [body for body in entries["bodies"] if body["name"] == name]
    entries["loads"] = [x for x in entries["loads"] if x.get("body", name) == name]
    for load in entries["loads"]:
        load.pop("name", None)
    return entries


def of_body(simulation: Simulation, name: str) -> list[Floats]:
    """Displacement, stress and domains of a body's points, in the order of their numbers."""
    own = simulation.points.of_body(name)
    order = np.argsort(simulation.points.point_id[own])
    points = simulation.points
    return [a[own][order] for a in (points.displacement, points.stress, points.half_length)]


def assert_as_alone(entries: dict[str, Any], tolerance: float = TOLERANCE) -> list[Simulation]:
    """Checks that each body moves as in an analysis of its own; returns all final states."""
    forces: list[dict[str, Floats]] = []

    def keep(simulation: Simulation, result: Any, time: float) -> None:
        forces[-1] = {name: result.resultant(name) for name in result.forces}

    found = []
    for each in (entries, *(alone(entries, name) for name in NAMES)):
        forces.append({})
        found.append(march(Model.from_dict(each), keep))
    for name, single in zip(NAMES, found[1:], strict=True):
        for a, b in zip(of_body(found[0], name), of_body(single, name), strict=True):
            assert np.abs(a - b).max() <= tolerance * np.abs(b).max()
            assert np.abs(b).max() > 0.0
    largest = max(np.abs(force).max() for force in forces[0].values())
    assert largest > 0.0
    for name, force in forces[0].items():
        alone_both = forces[1][name] + forces[2][name]
        assert np.abs(force - alone_both).max() <= 100.0 * tolerance * largest
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("gap", [0.5, -0.4])
def test_each_body_moves_as_if_it_were_alone(kind: str, basis: str, gap: float) -> None:
    assert_as_alone(soils(kind, basis, gap, grid_lines(kind)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", ["gimp", "cpdi2"])
def test_f_bar_and_ghost_stabilisation(kind: str, basis: str) -> None:
    entries = soils(kind, basis, -0.4, grid_lines(kind), anti_locking="f_bar")
    entries["analysis"]["ghost_stabilisation"] = 0.1
    assert_as_alone(entries)
