# SPDX-License-Identifier: BSD-3-Clause
"""Bodies of different overlays in one grid move as in analyses of their own."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import BASES, KINDS, dimension, material_entries, plane, weight

from tilth import Model
from tilth.analysis.march import march, march_stages
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.grid.background import Grid
from tilth.mpm.active_grid import Buffers, locate
from tilth.solvers import linear_solver

TOLERANCE = 1e-12
"""Largest difference relative to the largest value."""

NAMES = ("one", "two")


@pytest.fixture(autouse=True)
def _own_overlays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each body has an overlay of its own, without contact between them."""

    def overlays(model: Model) -> dict[str, int]:
        return {body.name: number for number, body in enumerate(model.bodies)}

    monkeypatch.setattr(Model, "overlays", overlays)
    monkeypatch.setattr("tilth.mpm.initial_points.require_apart", lambda *_: None)


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
    own = simulation.state.points.of_body(name)
    order = np.argsort(simulation.state.points.point_id[own])
    points = simulation.state.points
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


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", ["gimp", "cpdi1"])
def test_implicit_boundaries(kind: str, basis: str) -> None:
    """A base and a side that turn no grid line; the axis of symmetry lies between grid lines."""
    dim = dimension(kind)
    up, side = np.eye(dim)[dim - 1], np.eye(dim)[0]
    base = implicit("base", flat([0.0] * dim, up), condition="fixed")
    wall = implicit("wall", flat([4.7] + [0.0] * (dim - 1), -side))
    entries = soils(kind, basis, 0.5, [base, wall])
    entries["grid"]["origin"] = [-0.3] * dim
    assert_as_alone(entries, 1e-10)


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_rigid_body_and_contact_with_a_boundary(kind: str) -> None:
    """A rigid body presses each block, out of reach of the other; both stick to a base.

    Friction that grows with the pressure has not one solution only."""
    law = {"normal": "unilateral", "tangential": "smooth"}
    plates = [
        {"type": "box", "lower": [low, height], "upper": [high, height + 1.0], "soil": "outside"}
        for low, high, height in ((0.3, 1.7, 1.8), (3.2, 4.4, 2.3))
    ]
    base = {
        "type": "implicit", "name": "base", "geometry": flat([0.0, 0.0], [0.0, 1.0]),
        "contact": {"normal": "bilateral", "tangential": "bonded"},
    }  # fmt: skip
    entries = soils(kind, "gimp", 0.5, [base])
    entries["grid"]["origin"] = [0.0, -0.3]
    sides = {} if kind == "axisymmetric" else {"x": 0.01}
    rotation = {} if kind == "axisymmetric" else {"rotation": 0.0}
    entries["rigid_bodies"] = [
        {
            "name": f"plate {i}", "geometry": plate, "contact": law,
            "centre": [0.0 if kind == "axisymmetric" else 2.0, 3.0],
            "displacement": {"y": -0.04, **sides}, **rotation,
        }
        for i, plate in enumerate(plates)
    ]  # fmt: skip
    assert_as_alone(entries, 1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_loads_on_tracked_surfaces(kind: str) -> None:
    entries = soils(kind, "gimp", -0.4, grid_lines(kind), surface={"spacing": 0.4})
    top = [0.3, 0.7] + ([0.0] if kind == "3d" else [])
    for name, x in zip(NAMES, (1.0, 3.0), strict=True):
        entries["loads"].append(
            {"type": "surface", "name": name, "body": name, "pressure": 2.0}
            if kind != "3d"
            else {"type": "surface", "name": name, "body": name, "pressure": 2.0, "part": "z+"}
        )
        at = [x, *top[1 : dimension(kind)]]
        force = [0.0] * (dimension(kind) - 1) + [-0.5]
        entries["loads"].append({"type": "point_force", "body": name, "at": at, "force": force})
    both, *single = assert_as_alone(entries)
    for name, other in zip(NAMES, single, strict=True):
        moved = both.state.surfaces[name].shape().position
        expected = other.state.surfaces[name].shape().position
        assert np.abs(moved - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_multigrid(kind: str) -> None:
    """The Krylov method with levels of each field finds the direct solution."""
    entries = soils(kind, "gimp", -0.4, grid_lines(kind))
    entries["grid"]["cell_size"], entries["schedule"] = 0.5, {"steps": 1}
    for body in entries["bodies"]:
        body["spacing"] = 0.25
    model = Model.from_dict(entries)
    exact = march(model)
    found = Simulation(model)
    reasons: list[str] = []
    found.services.solver = linear_solver(
        "multigrid", dimension(kind), len(found.state.points), reasons.append
    )
    found.advance(0.0, 1.0)
    assert not reasons
    assert 0 < max(found.services.solver.iterations, default=0) < 40
    for name in NAMES:
        for a, b in zip(of_body(found, name), of_body(exact, name), strict=True):
            assert np.abs(a - b).max() <= 1e-8 * np.abs(b).max()


@pytest.mark.parametrize("kind", KINDS)
def test_resumed_in_the_same_bits(kind: str) -> None:
    entries = soils(kind, "gimp", -0.4, grid_lines(kind), surface={})
    entries["analysis"]["ghost_stabilisation"] = 0.1
    entries["grid"]["origin"] = [-0.4] + [0.0] * (dimension(kind) - 1)
    model = Model.from_dict(entries)
    whole = Simulation(model)
    whole.advance(0.0, 0.5)
    again = Simulation.restored(model, copy.deepcopy(whole.state.arrays()))
    for simulation in (whole, again):
        simulation.advance(0.5, 1.0)
    expected = whole.state.arrays()
    for name, array in again.state.arrays().items():
        assert array.tobytes() == expected[name].tobytes(), name


@pytest.mark.parametrize("kind", KINDS)
def test_stages(kind: str) -> None:
    """The second body is placed beside the first, and later the base of both turns into a roller.

    What was out of balance is released to the soil of the field to which it belonged.
    """
    up = "xyz"[dimension(kind) - 1]
    boundaries = [
        *grid_lines(kind), plane("roller", up, 0.0), plane("side", "x", 0.0),
        *([plane("front", "y", 0.0)] if kind == "3d" else []),
    ]  # fmt: skip
    entries = soils(kind, "gimp", 0.2, boundaries)
    del entries["schedule"]
    entries["loads"][0]["name"] = "weight"
    entries["loads"][0]["factor"] = [[0.0, 1.0], [1.0, 1.0]]
    entries["boundaries"][2]["at"] = 2.0 if kind != "axisymmetric" else 0.0
    stages = [
        {"name": "first", "schedule": {"steps": 1}},
        {"name": "second", "schedule": {"steps": 1}, "activate": ["two"]},
        {
            "name": "third", "schedule": {"steps": 2}, "deactivate": ["base"],
            "activate": ["roller"],
        },
    ]  # fmt: skip
    entries["boundaries"] = [b for b in boundaries if b["name"] != "side" or kind != "axisymmetric"]
    entries["stages"] = stages
    both = march_stages(Model.from_dict(entries)).simulation
    assert both.state.points.ranges[1].overlay == 1
    for name in NAMES:
        single = alone(entries, name)
        single["stages"] = copy.deepcopy(stages)
        if name == "one":
            del single["stages"][1]["activate"]
        else:
            single["stages"] = single["stages"][1:]
            del single["stages"][0]["activate"]
        found = march_stages(Model.from_dict(single)).simulation
        for a, b in zip(of_body(both, name), of_body(found, name), strict=True):
            assert np.abs(a - b).max() <= 1e-11 * np.abs(b).max()


def test_nodes_of_the_overlays() -> None:
    """Both fields have all nodes of their bodies, at the same places where these overlap."""
    for kind in KINDS:
        simulation = Simulation(Model.from_dict(soils(kind, "gimp", -0.4, grid_lines(kind))))
        active = simulation.locate(0.0)
        singles = [
            locate(
                simulation.state.points.part(body),
                Grid(simulation.state.grid.origin, simulation.state.grid.cell_size),
                Buffers(),
            )
            for body in simulation.state.points.ranges[:1]
        ]
        assert active.overlays == 2
        assert (np.diff(active.overlay) >= 0).all()
        own = active.overlay == 0
        assert np.array_equal(active.position[own], singles[0].position)
        places = {tuple(x) for x in active.position[own]}
        common = [x for x in active.position[~own] if tuple(x) in places]
        assert 0 < len(common) < own.sum()
        for number in range(2):
            of_overlay = active.of_overlay(number)
            assert (active.overlay[of_overlay.nodes] == number).all()
        cells = active.cells()
        assert (active.overlay[cells] == active.overlay[cells[:, :1]]).all()
        low, high = active.position[cells].min(axis=1), active.position[cells].max(axis=1)
        assert np.allclose(high - low, 1.0, rtol=0.0, atol=1e-12)


def test_too_far_along_z() -> None:
    """Keys of several fields have a smaller range along z, which is told."""
    entries = soils("3d", "gimp", -0.4, grid_lines("3d"))
    entries["boundaries"][0]["at"] = 40_000.0
    for body in entries["bodies"]:
        for corner in ("lower", "upper"):
            body["shape"][corner][2] += 40_000.0
    with pytest.raises(StepFailed, match="32,768 cells from the grid's origin along z"):
        Simulation(Model.from_dict(entries)).locate(0.0)
    Simulation(Model.from_dict(alone(entries, "one"))).locate(0.0)
