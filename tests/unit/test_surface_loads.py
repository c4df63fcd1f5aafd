# SPDX-License-Identifier: BSD-3-Clause
"""Loads on surfaces: their derivative against differences, and what a wrong input gets."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from balances import blocks_at
from small_problems import BASES

from tilth import BadInput, Model, SurfaceLoad
from tilth.analysis.memory import memory_of
from tilth.analysis.setup_picture import setup_of
from tilth.analysis.simulation import Simulation
from tilth.analysis.tracker import Tracker
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.report.summary import print_summary
from tilth.solvers.system import LinearSystem
from tilth.surface.loads import SurfaceLoads, declared_loads
from tilth.terms.balance import Balance

OCTAGON = [
    [2.0 + 1.13 * np.cos(a), 2.1 + 1.13 * np.sin(a)] for a in (np.arange(8) + 0.3) * np.pi / 4.0
]
LOADS: dict[str, dict[str, Any]] = {
    "pressure": {"pressure": 30.0},
    "shear": {"shear": -20.0, "start": [3.1, 2.1], "end": [1.0, 2.1]},
    "hydrostatic": {"hydrostatic": {"level": 2.4, "unit_weight": 12.0}},
    "profile": {"pressure_along": [[0.0, 5.0], [1.3, 40.0], [9.0, -10.0]]},
    "together": {
        "pressure": 10.0,
        "shear": 7.0,
        "hydrostatic": {"level": [[0.0, 1.0], [1.0, 2.5]], "unit_weight": 9.0},
        "traction": [3.0, -4.0],
        "factor": [[0.0, 0.2], [1.0, 1.7]],
    },
    "dead": {"pressure": 30.0, "shear": 4.0, "follower": False},
}


def blob(
    load: dict[str, Any], kind: str = "plane_strain", basis: str = "linear", **surface: Any
) -> dict[str, Any]:
    """A smooth body off the grid lines with a load on its surface."""
    return {
        "analysis": {"kind": kind},
        "grid": {"cell_size": 0.5},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 1000.0, "poisson_ratio": 0.3}
        },
        "bodies": [
            {
                "name": "blob",
                "material": "soil",
                "basis": basis,
                "shape": {"type": "polygon", "vertices": OCTAGON},
                "points_per_cell": 3,
                "surface": {"corner_angle": 60.0, **surface},
            }
        ],
        "boundaries": [
            {"type": "plane", "name": "base", "axis": "y", "at": 2.0, "condition": "fixed"}
        ],
        "loads": [{"type": "surface", "body": "blob", **load}],
        "schedule": {"steps": 4},
    }


def loads_of(entries: dict[str, Any]) -> tuple[SurfaceLoads, ActiveGrid]:
    """The loads of the second half of the schedule on the initial surface."""
    simulation = Simulation(Model.from_dict(entries))
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    loads = SurfaceLoads(
        declared_loads(simulation.setup.model),
        simulation.setup.kind,
        simulation.state.surfaces,
        active,
        0.5,
        1.0,
    )
    return loads, active


def require_derivative(
    loads: SurfaceLoads, active: ActiveGrid, size: float
) -> npt.NDArray[np.float64]:
    """The stiffness at random displacements [length] agrees with central differences.

    Returns its blocks.
    """
    random = np.random.default_rng(4)
    u = size * random.normal(size=(active.nodes, active.grid.dim))
    direction = random.normal(size=u.shape)
    step = 1e-5
    ahead, behind = (loads.force(u + sign * step * direction) for sign in (1.0, -1.0))
    balance = Balance(active, [loads])
    system = LinearSystem(balance.active, np.zeros(u.shape, dtype=bool))
    system.blocks[:] = blocks_at(balance, u)
    scale = np.abs(loads.force(u)).max()
    assert scale > 0.1
    expected = (behind - ahead) / (2.0 * step)
    np.testing.assert_allclose(system.times(direction), expected, rtol=0, atol=1e-7 * scale)
    return system.blocks


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("name", LOADS)
def test_derivative_against_differences(kind: str, basis: str, name: str) -> None:
    blocks = require_derivative(*loads_of(blob(LOADS[name], kind, basis)), 0.03)
    if name == "dead":
        assert not blocks.any()


def refused(load: dict[str, Any], **surface: Any) -> str:
    with pytest.raises(BadInput) as caught:
        Simulation(Model.from_dict(blob(load, **surface)))
    return str(caught.value)


WHOLE = {"pressure": 1.0}


@pytest.mark.parametrize(
    ("load", "surface", "words"),
    [
        ({}, {}, ["loads[0].pressure", "missing"]),
        ({"pressure": 1.0, "start": [1, 2]}, {}, ["loads[0].end", "give both or none"]),
        ({"pressure": 1.0, "part": "z+"}, {}, ["loads[0].part", "give `start` and `end`"]),
        ({"traction": [1.0, 2.0, 3.0]}, {}, ["loads[0].traction", "must have 2 components"]),
        (
            {"hydrostatic": {"level": 1.0, "unit_weight": 1.0}, "follower": False},
            {},
            ["loads[0].follower", "water follows the surface"],
        ),
        (WHOLE, {"vertices": [[1, 1], [1, 1], [2, 2]]}, ["surface.vertices", "points 0, 1"]),
        (WHOLE, {"vertices": [[1, 1], [2, 2]]}, ["surface.vertices", "too few", "at least 3"]),
        (
            WHOLE,
            {"vertices": [[1, 1], [3, 3], [3, 1], [1, 3]]},
            ["surface.vertices", "crosses itself at (2, 2)"],
        ),
        (WHOLE, {"corners": [1]}, ["surface.corners", "is for `vertices` only"]),
        (
            WHOLE,
            {"vertices": [[1, 1], [3, 1], [3, 3]], "corners": [3]},
            ["surface.corners", "numbered from 0 to 2"],
        ),
        (
            {"pressure": 1.0, "start": [1, 3], "end": [3, 1]},
            {"vertices": [[3, 1], [3, 3], [1, 3]], "closed": False},
            ["loads[0].start", "exchange `start` and `end`"],
        ),
    ],
)
def test_wrong_input(load: dict[str, Any], surface: dict[str, Any], words: list[str]) -> None:
    message = refused(load, **surface)
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    ("zero", "said"),
    [
        ({"pressure": 0.0}, "pressure 0 "),
        ({"shear": 0}, "pressure 0 "),
        ({"traction": [0.0, 0.0]}, "traction [0, 0]"),
        ({"pressure_along": [[0, 0], [1, 0]]}, "pressure along"),
    ],
)
def test_a_load_of_zero_is_given(
    zero: dict[str, Any], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first of a series, say: it runs, also from its stored model, and has no force."""
    loads, active = loads_of(blob(zero))
    assert loads
    assert not loads.force(np.zeros((active.nodes, 2))).any()
    model = Model.from_dict(Model.from_dict(blob(zero)).to_dict())
    print_summary(model, setup_of(model), memory_of(model), None)
    assert said in capsys.readouterr().out


def test_keys_of_none_are_not_given() -> None:
    with pytest.raises(BadInput, match="pressure: missing"):
        SurfaceLoad(body="blob", traction=None, hydrostatic=None)


def test_a_load_on_a_body_without_boundary_points() -> None:
    entries = blob(WHOLE)
    del entries["bodies"][0]["surface"]
    with pytest.raises(BadInput, match="no tracked surface that could carry a load") as caught:
        Model.from_dict(entries)
    assert "add `surface = {}` to bodies[0]" in str(caught.value)


def test_an_open_chain_encloses_nothing() -> None:
    entries = blob(WHOLE, vertices=[[1.0, 1.0], [3.0, 1.0], [3.0, 2.0]], closed=False)
    entries["track"] = [{"name": "area", "quantity": "enclosed", "body": "blob"}]
    with pytest.raises(BadInput, match="needs a closed chain") as caught:
        Simulation(Model.from_dict(entries))
    assert "track[0].body" in str(caught.value)
    del entries["bodies"][0]["surface"], entries["loads"]
    with pytest.raises(BadInput, match="no tracked surface that could enclose anything"):
        Model.from_dict(entries)


def test_enclosed_area_and_volume_are_tracked() -> None:
    entries = blob({"pressure": 1.0, "factor": [[0.0, 0.0], [1.0, 1.0]]})
    entries["track"] = [{"name": "inside", "quantity": "enclosed", "body": "blob"}]
    model = Model.from_dict(entries)
    simulation = Simulation(model)
    tracker = Tracker(model, simulation.state.points)
    octagon = 0.5 * 8.0 * 1.13**2 * np.sin(np.pi / 4.0)  # the spline rounds its corners
    (area,) = tracker.values(simulation.setup, simulation.state, None, 0.0)
    assert octagon < area < np.pi * 1.13**2 * 1.01
    assert tracker.columns == [("inside", "m^2")]
    entries = shell({"pressure": 1.0})
    entries["track"] = [{"name": "inside", "quantity": "enclosed", "body": "blob"}]
    model = Model.from_dict(entries)
    simulation = Simulation(model)
    tracker = Tracker(model, simulation.state.points)
    (volume,) = tracker.values(simulation.setup, simulation.state, None, 0.0)
    assert volume == pytest.approx(np.pi / 6.0 * 7.0, rel=0.1)


def test_the_ends_of_an_open_chain_are_not_joined() -> None:
    entries = blob(WHOLE, vertices=[[1.0, 1.0], [3.0, 1.0]], closed=False)
    loads, active = loads_of(entries)
    force = loads.force(np.zeros((active.nodes, 2)))
    np.testing.assert_allclose(force.sum(axis=0), [0.0, 2.0], atol=1e-12)


def shell(load: dict[str, Any], basis: str = "linear") -> dict[str, Any]:
    """An eighth of a hollow sphere."""
    entries = blob(load, "3d", basis)
    entries["bodies"][0]["shape"] = {
        "type": "sphere",
        "centre": [0.0, 0.0, 0.0],
        "radius": 2.0,
        "inner_radius": 1.0,
        "sides": ["x+", "y+", "z+"],
    }
    entries["bodies"][0]["surface"] = {"spacing": 0.6}
    entries["boundaries"][0]["at"] = 0.0
    return entries


@pytest.mark.parametrize("name", ["pressure", "hydrostatic", "dead", "traction"])
@pytest.mark.parametrize("part", [None, "inner"])
@pytest.mark.parametrize("basis", BASES)
def test_derivative_in_space(name: str, part: str | None, basis: str) -> None:
    load = {"traction": [1.0, 2.0, 3.0]} if name == "traction" else dict(LOADS[name])
    load.pop("shear", None)
    if name == "hydrostatic":
        load = {"hydrostatic": {"level": 0.8, "unit_weight": 12.0}}
    require_derivative(*loads_of(shell({**load, **({"part": part} if part else {})}, basis)), 0.01)


def test_resultants_in_space() -> None:
    """A pressure inside an eighth of a sphere of radius 1: pi / 4 on each plane, but for chords."""
    loads, active = loads_of(shell({"pressure": -5.0, "part": "inner"}))
    force = loads.force(np.zeros((active.nodes, 3))).sum(axis=0)
    simulation = Simulation(Model.from_dict(shell({"pressure": 1.0})))
    triangles = simulation.state.surfaces["blob"].triangles.current  # type: ignore[attr-defined]
    expected = -5.0 * triangles.area_vector[triangles.in_part("inner")].sum(axis=0)
    np.testing.assert_allclose(force, expected, rtol=1e-12)
    np.testing.assert_allclose(force, 5.0 * np.pi / 4.0 * np.array([-1, -1, -1]), rtol=0.1)


def test_an_unknown_part() -> None:
    with pytest.raises(BadInput, match="middle") as caught:
        Simulation(Model.from_dict(shell({"pressure": 1.0, "part": "middle"})))
    assert "outer" in str(caught.value)
