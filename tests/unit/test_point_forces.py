# SPDX-License-Identifier: BSD-3-Clause
"""Point forces and line forces: resultant and moment at any place, before and after a motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import BASES, KINDS, affine, block_entries, dimension

from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.mpm.active_grid import Buffers, locate

FORCE = np.array([3.0, -7.0, 2.0])
PLACES = {
    "inside": [0.83, 1.21, 1.05],
    "middle of a cell": [0.5, 1.5, 0.5],
    "surface": [0.61, 2.0, 1.4],
    "edge": [2.0, 0.9, 2.0],
    "corner": [2.0, 2.0, 2.0],
    "above": [1.1, 2.6, 1.0],
}
"""In the block of 2 x 2 (x 2) cells, on its surface, and half a cell above."""
BENT = np.array([[1.2, 0.3, -0.1], [-0.2, 0.9, 0.15], [0.1, 0.05, 1.1]])


def held(kind: str, basis: str, *loads: dict[str, Any], **changed: Any) -> Simulation:
    return Simulation(Model.from_dict(block_entries(kind, basis, loads=[*loads], **changed)))


def nodal(simulation: Simulation) -> tuple[Floats, Floats]:
    """Positions of the nodes and the force on them at the end, padded to three components."""
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    force = simulation.soil_on(active).scatter(
        simulation.setup.loads.force(simulation.state.points, 1.0)
    )
    three = ((0, 0), (0, 3 - active.grid.dim))
    return np.pad(active.position, three), np.pad(force, three)


def require_force_at(simulation: Simulation, place: Floats, force: Floats) -> None:
    """The nodal forces have this resultant, and their first moments are those of the place."""
    position, found = nodal(simulation)
    dim = simulation.setup.model.dimension
    size = np.abs(force).max()
    np.testing.assert_allclose(found.sum(axis=0)[:dim], force[:dim], rtol=0, atol=1e-12 * size)
    moments = np.einsum("ni,nj->ij", position, found)[:dim, :dim]
    expected = np.outer(place[:dim], force[:dim])
    np.testing.assert_allclose(moments, expected, rtol=0, atol=1e-11 * size)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", KINDS)
def test_point_force_has_its_resultant_and_moment(kind: str, basis: str, place: str) -> None:
    at, force = (v[: dimension(kind)] for v in (PLACES[place], FORCE))
    load = {"type": "point_force", "body": "block", "at": at, "force": force.tolist()}
    require_force_at(held(kind, basis, load), np.array(at), force)


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("place", ["surface", "corner", "inside"])
def test_it_stays_at_the_same_soil(kind: str, place: str) -> None:
    """An affine motion through the cells moves the place as it moves the soil."""
    dim = dimension(kind)
    gradient = BENT[:dim, :dim]
    at, force = (np.array(v[:dim]) for v in (PLACES[place], FORCE))
    load = {"type": "point_force", "body": "block", "at": at.tolist(), "force": force.tolist()}
    simulation = held(
        kind, "linear", load, boundaries=[affine(gradient)], schedule={"steps": 4},
        grid={"cell_size": 0.5},
    )  # fmt: skip
    for k in range(4):
        simulation.advance(k / 4, (k + 1) / 4)
    require_force_at(simulation, gradient @ at, force)


LINE = {"type": "line_force", "body": "block", "force": FORCE.tolist()}


@pytest.mark.parametrize(
    ("start", "end"),
    [
        ([0.1, 0.3, 2.0], [1.9, 1.7, 2.0]),
        ([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
        ([0.4, 1.0, 2.0], [0.45, 1.0, 2.0]),
        ([2.0, 2.0, 2.0], [2.0, 0.0, 2.0]),
    ],
)
@pytest.mark.parametrize("basis", BASES)
def test_line_force_has_its_resultant_and_moment(
    basis: str, start: list[float], end: list[float]
) -> None:
    simulation = held("3d", basis, {**LINE, "start": start, "end": end})
    a, b = np.array(start), np.array(end)
    require_force_at(simulation, 0.5 * (a + b), float(np.linalg.norm(b - a)) * FORCE)


def test_line_force_is_even_along_the_line() -> None:
    """Its second moment along the line is that of a uniform one, but for that of the shares."""
    simulation = held(
        "3d", "linear", {**LINE, "start": [0.0, 1.0, 2.0], "end": [4.0, 1.0, 2.0]}, cells=4
    )
    (load,) = simulation.setup.loads.on_points
    x = simulation.state.points.position[simulation.state.points.index_of(load.point_id), 0]
    assert load.share.sum() == pytest.approx(4.0, rel=1e-13)
    for low in (1.0, 2.0):  # away from the ends, where shares extrapolate
        assert load.share[(x > low) & (x < low + 1.0)].sum() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_the_base_carries_force_and_moment(kind: str) -> None:
    """Equilibrium of a block that a force at its upper corner bends: about the moved corner."""
    dim = dimension(kind)
    corner, force = np.full(dim, 2.0), 0.01 * FORCE[:dim]
    up = "xyz"[dim - 1]
    entries = block_entries(
        kind, "gimp",
        loads=[{"type": "point_force", "body": "block", "at": [2.0] * dim,
                "force": force.tolist()}],
        boundaries=[
            {"type": "plane", "name": "base", "axis": up, "at": 0.0, "condition": "fixed"}
        ],
    )  # fmt: skip
    simulation = Simulation(Model.from_dict(entries))
    result: StepResult = simulation.advance(0.0, 1.0)
    np.testing.assert_allclose(result.resultant("base"), -force, rtol=1e-8)
    (load,) = simulation.setup.loads.on_points
    row = simulation.state.points.index_of(load.point_id)
    place = load.share @ simulation.state.points.position[row]
    assert np.linalg.norm(place - corner) > 1e-6
    moment = result.moment("base", place)
    np.testing.assert_allclose(moment, np.zeros(3), atol=1e-7 * np.abs(force).max())


def off_flamant(cell_size: float) -> float:
    """RMS difference of the stresses around a line load from Flamant's, over the greatest, 1 to 3.

    sigma_rr = -2 P sin(theta) / (pi r) with theta from the surface, all others 0: A. Flamant, in
    S. Timoshenko & J.N. Goodier, Theory of Elasticity, section 36. The rigid base is 16 deep and
    the sides are 16 away.
    """
    at = np.array([16.1, 16.0])
    entries = block_entries(
        "plane_strain", "gimp",
        loads=[{"type": "point_force", "body": "block", "at": at.tolist(), "force": [0.0, -1e-3]}],
        boundaries=[
            {"type": "plane", "name": "base", "axis": "y", "at": 0.0, "condition": "fixed"},
            {"type": "plane", "name": "left", "axis": "x", "at": 0.0, "condition": "roller"},
            {"type": "plane", "name": "right", "axis": "x", "at": 32.0, "condition": "roller"},
        ],
        grid={"cell_size": cell_size},
    )  # fmt: skip
    entries["bodies"][0]["shape"]["upper"] = [32.0, 16.0]
    simulation = Simulation(Model.from_dict(entries))
    simulation.advance(0.0, 1.0)
    offset = simulation.state.points.position - at
    radius = np.linalg.norm(offset, axis=1)
    ring = (radius > 1.0) & (radius < 3.0)
    direction = offset[ring] / radius[ring, None]
    radial = 2.0 * 1e-3 * direction[:, 1] / (np.pi * radius[ring])
    exact = radial[:, None, None] * np.einsum("ni,nj->nij", direction, direction)
    stress = simulation.state.points.stress[ring][:, [0, 3, 3, 1]].reshape(-1, 2, 2)
    difference = np.linalg.norm(stress - exact, axis=(1, 2))
    return float(np.sqrt((difference**2).mean()) / np.abs(radial).max())


def test_flamant_below_a_point_force() -> None:
    """Where base and sides are, this stress is 6 % of the greatest: so much they may change."""
    assert off_flamant(0.25) < 0.06


AT = {"type": "point_force", "body": "block", "force": [1.0, -1.0], "at": [1.0, 1.0]}
ALONG = {**LINE, "start": [0.0, 0.0, 2.0], "end": [2.0, 0.0, 2.0]}
QUAKE = {"type": "seismic", "coefficient": [0.1, 0.0]}
WEIGHT = {"type": "body_force", "acceleration": [0.0, -10.0]}


@pytest.mark.parametrize(
    ("kind", "loads", "words"),
    [
        ("plane_strain", [{**AT, "at": [5.0, 1.0]}], "loads[0].at = [5.0, 1.0]: the body 'block' "
         "cannot carry a force at (5, 1): no soil is within a cell"),
        ("axisymmetric", [{**AT, "at": [0.0, 1.0]}], "loads[0].force = [1.0, -1.0]: has a radial"),
        ("axisymmetric", [{**AT, "at": [-0.5, 1.0]}], "loads[0].at = [-0.5, 1.0]: lies at"),
        ("plane_strain", [{**ALONG, "force": [0.0, 1.0], "start": [0, 2], "end": [1, 2]}],
         'loads[0].type = "line_force": is for 3D'),
        ("3d", [{**ALONG, "end": ALONG["start"]}], "loads[0].end = [0.0, 0.0, 2.0]: is equal to"),
        ("3d", [{**ALONG, "end": [2.0, 0.0]}], "loads[0].end = [2.0, 0.0]: must have 3"),
        ("3d", [{**ALONG, "end": [2.0, 0.0, 5.0]}], "loads[0].end = [2.0, 0.0, 5.0]: the body"),
        ("3d", [{**ALONG, "start": [-9.0, 0.0, 2.0]}], "loads[0].start = [-9.0, 0.0, 2.0]: the"),
        ("3d", [{**ALONG, "body": "other"}], 'loads[0].body = "other": there is no'),
        ("plane_strain", [QUAKE], 'loads[0].type = "seismic": a seismic load is a part of gravity'),
        ("plane_strain", [{**QUAKE, "coefficient": [0.1]}, WEIGHT], "must have 2 components"),
        ("axisymmetric", [QUAKE, WEIGHT], "loads[0].coefficient = [0.1, 0.0]: a horizontal force"),
    ],
)  # fmt: skip
def test_what_cannot_act_is_refused(kind: str, loads: list[dict[str, Any]], words: str) -> None:
    with pytest.raises(BadInput) as caught:
        held(kind, "linear", *loads)
    assert words in str(caught.value)


def test_points_on_one_line_cannot_carry_a_force_beside_it() -> None:
    entries = block_entries("plane_strain", "linear", loads=[{**AT, "at": [1.0, 0.9]}])
    entries["bodies"][0] |= {"points_per_cell": 1, "shape": {
        "type": "box", "lower": [0.0, 0.0], "upper": [2.0, 1.0]}}  # fmt: skip
    with pytest.raises(BadInput, match="lie on one line or plane beside it"):
        Simulation(Model.from_dict(entries))
    entries["loads"][0]["at"] = [1.2, 0.5]
    require_force_at(Simulation(Model.from_dict(entries)), np.array([1.2, 0.5]), np.array([1, -1]))
