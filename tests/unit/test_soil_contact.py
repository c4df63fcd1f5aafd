# SPDX-License-Identifier: BSD-3-Clause
"""Where implicit boundaries act: what they touch, by which nodes, on and beside grid lines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_problems import implicit, line, locate_contacts, rotation, take_steps
from small_problems import BASES, KINDS, block_entries, dimension, plane

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.quadrature import locate_in_cells

pytestmark = pytest.mark.slow

GRAVITY, DENSITY = 10.0, 2.0


def filled_box(
    basis: str, points: int, shift: Floats, angle: float, size: float = 3.0
) -> Simulation:
    """A block that fills a smooth box, pulled down along the box's own axis at once, two steps."""
    box = {"lower": shift.tolist(), "upper": (shift + size).tolist(), "angle": angle}
    down = -GRAVITY * rotation(angle)[:, 1]
    wall = implicit("box", {"type": "box", "soil": "inside", **box})
    entries = block_entries(
        "plane_strain", basis, boundaries=[wall],
        loads=[
            {"type": "body_force", "acceleration": down.tolist(), "factor": [[0, 1], [1, 1]]}
        ],
        schedule={"steps": 2},
    )  # fmt: skip
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["points"] = [round(points * size)] * 2
    body["shape"] = {"type": "box", **box}
    entries["analysis"]["tolerance"] = 1e-12
    return Simulation(Model.from_dict(entries))


@pytest.mark.parametrize(("basis", "points"), [("linear", 1), *((basis, 2) for basis in BASES)])
@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_no_piece_of_a_box_is_lost(basis: str, points: int, angle: float) -> None:
    """50 positions through a cell: the whole perimeter acts, and carries the weight exactly."""
    size = 3.0
    total = DENSITY * GRAVITY * size**2
    for share in np.linspace(0.0, 1.0, 50):
        simulation = filled_box(basis, points, np.array([share, 0.37 * share]), angle)
        simulation.check()
        _, constraints = locate_contacts(simulation, 0.0, 0.5)
        (part,) = constraints.parts
        assert part.pose.weight.sum() == pytest.approx(4.0 * size, rel=1e-12)
        up = rotation(angle)[:, 1] * total
        for before, after in ((0.0, 0.5), (0.5, 1.0)):
            _, constraints = locate_contacts(simulation, before, after)
            result = simulation.advance(before, after)
            assert np.abs(result.resultant("box") - up).max() < 1e-10 * total
        # what the next step would begin with, where as much is touched
        (part,) = constraints.parts
        carried = -part.pose.weight @ part.boundary.carried[part.chosen]
        assert np.abs(carried - up).max() < 1e-10 * total


def walled_block(
    basis: str, walls: str, gap: float, delta: float, acceleration: float = 20.0
) -> Simulation:
    """A block between smooth walls, on grid lines or `gap` beyond them, under its weight."""
    if walls == "plane":
        boundaries = [
            plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", 2.0),
        ]  # fmt: skip
    else:
        boundaries = [
            implicit("base", line(np.array([0.0, gap]), np.array([0.0, 1.0])), delta=delta),
            implicit("left", line(np.array([gap, 0.0]), np.array([1.0, 0.0])), delta=delta),
            implicit("right", line(np.array([2.0 + gap, 0.0]), np.array([-1.0, 0.0])), delta=delta),
        ]
    entries = block_entries(
        "plane_strain", basis, boundaries=boundaries,
        loads=[{"type": "body_force", "acceleration": [5.0, -acceleration]}],
    )  # fmt: skip
    body = entries["bodies"][0]
    # no sliver at the free surface: what ghost stabilisation does there is not the walls' doing
    body["shape"] = {"type": "box", "lower": [gap, gap], "upper": [2.0 + gap, 2.0]}
    del body["points_per_cell"]
    body["points"] = [6, 6]
    entries["analysis"]["tolerance"] = 1e-12
    return Simulation(Model.from_dict(entries))


def answer(simulation: Simulation) -> tuple[Floats, Floats]:
    """Displacement and stress of the points, in the order of their numbers."""
    take_steps(simulation)
    order = np.argsort(simulation.state.points.point_id)
    return simulation.state.points.displacement[order], simulation.state.points.stress[order]


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("gap", [0.0, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3])
def test_beside_a_grid_line_as_by_elimination(basis: str, gap: float) -> None:
    """The difference is proportional to the band, but for the place in the cell itself."""
    exact = answer(walled_block(basis, "plane", 0.0, 0.0))
    differences = []
    for delta in (1e-2, 1e-3):
        found = answer(walled_block(basis, "implicit", gap, delta))
        differences.append(
            [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(found, exact, strict=True)]
        )
    wide, narrow = np.array(differences)
    assert (wide < 2e-2 + 2.0 * abs(gap)).all()
    assert (narrow < 2e-3 + 2.0 * abs(gap)).all()
    if abs(gap) < 1e-5:
        np.testing.assert_allclose(narrow / wide, 0.1, rtol=0.1)


def block_on_a_plane(kind: str, lower: float, angle: float = 0.0) -> Simulation:
    """A block of 16 or 64 points on a plane that goes on beside it."""
    dim = dimension(kind)
    up = np.eye(dim)[-1] if dim == 3 else rotation(angle)[:, 1]
    base = np.full(dim, lower)
    if kind == "axisymmetric":
        base[0] = 0.0
    wall = implicit("base", line(base, up), condition="fixed")
    entries = block_entries(kind, "linear", boundaries=[wall])
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["points"] = [4] * dim
    body["shape"] = {
        "type": "box", "lower": base.tolist(), "upper": (base + 2.0).tolist(),
    }  # fmt: skip
    if angle:
        body["shape"]["angle"] = angle
    return Simulation(Model.from_dict(entries))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("lower", [0.0, 0.25, 0.4])
def test_an_overhanging_plane_acts_as_far_as_the_block(kind: str, lower: float) -> None:
    """A plane and a place are touched on the block's own face, wherever that ends."""
    _, constraints = locate_contacts(block_on_a_plane(kind, lower))
    (part,) = constraints.parts
    boundary, dim = part.boundary, dimension(kind)
    assert boundary.quadrature is not None
    low = np.array([0.0 if kind == "axisymmetric" else lower] * (dim - 1))
    along = boundary.quadrature.reference[:, : dim - 1]
    beyond = np.maximum(low - along, along - low - 2.0).max(axis=1)
    touched = np.isin(np.arange(len(along)), part.chosen)
    assert touched[beyond < 1e-12].all()
    assert (~touched).sum() > 5
    length = np.pi * 4.0 if kind == "axisymmetric" else 2.0 ** (dim - 1)
    assert part.pose.weight.sum() == pytest.approx(length, rel=5e-3)


@pytest.mark.parametrize("angle", [10.0, 30.0, 45.0, 77.0])
def test_a_turned_block_is_touched_all_along(angle: float) -> None:
    """And hardly beyond: not by a point's spacing."""
    simulation = block_on_a_plane("plane_strain", 0.3, angle)
    _, constraints = locate_contacts(simulation)
    (part,) = constraints.parts
    quadrature = part.boundary.quadrature
    assert quadrature is not None
    along = (quadrature.reference - 0.3) @ rotation(angle)[:, 0]
    touched = np.isin(np.arange(len(along)), part.chosen)
    assert touched[(along > 0.0) & (along < 2.0)].all()
    assert not touched[(along < -0.5) | (along > 2.5)].any()


@pytest.mark.parametrize("distance", [0.3, 0.49, 0.51])
def test_a_plane_beside_the_points_touches_within_their_spacing(distance: float) -> None:
    """A point's box has the half length 0.25: it may stand half a box's width, 0.25, away."""
    simulation = block_on_a_plane("plane_strain", 0.0)
    simulation.state.points.position[:, 1] += distance - 0.25  # lowest points at `distance`
    _, constraints = locate_contacts(simulation)
    assert bool(constraints.parts) == (distance < 0.5)
    assert [b.name for b in constraints.without_contact] == ([] if constraints.parts else ["base"])


def test_a_boundary_that_the_soil_has_left_carries_nothing() -> None:
    """So that soil that comes back is not met by the traction of soil that was there before."""
    simulation = block_on_a_plane("plane_strain", 0.0)
    _, constraints = locate_contacts(simulation)
    constraints.commit([np.ones_like(part.before) for part in constraints.parts])
    (boundary,) = simulation.state.implicit
    assert np.abs(boundary.carried).max() == 1.0
    simulation.state.points.position[:, 1] += 2.0
    _, constraints = locate_contacts(simulation)
    assert constraints.without_contact == [boundary]
    constraints.commit([])
    assert not boundary.carried.any()


@pytest.mark.parametrize("kind", KINDS)
def test_places_in_cells_without_points(kind: str) -> None:
    """They act by a neighbouring cell: the sum is one, linear fields are exact."""
    random = np.random.default_rng(6)
    dim = dimension(kind)
    active, _ = locate_contacts(block_on_a_plane(kind, 0.0))  # cells 0 and 1 hold points
    place = random.uniform(-0.6, 2.6, (200, dim))
    order, at = locate_in_cells(active, place)
    place = place[order]
    np.testing.assert_allclose(at.value.sum(axis=1), 1.0, rtol=0, atol=1e-13)
    np.testing.assert_allclose(at.gradient.sum(axis=1), 0.0, atol=1e-13)
    np.testing.assert_allclose(at.interpolate(active.position), place, atol=1e-13)
    nodal = active.position[at.node[at.cell]]
    gradient = np.einsum("nak,nai->nki", at.gradient, nodal)
    np.testing.assert_allclose(gradient, np.tile(np.eye(dim), (200, 1, 1)), atol=1e-12)
    # the cell is that of the place, or else the nearest one with soil
    corner = nodal.min(axis=1)
    np.testing.assert_array_equal(corner, np.floor(place).clip(0.0, 1.0))
    outside = (place != place.clip(0.0, 2.0)).any(axis=1)
    assert outside.sum() > 50
    assert (at.value[outside].min(axis=1) < 0.0).all()


def test_a_corner_cell_without_points_is_reached_from_the_nearest_one() -> None:
    """A turned block of standard points: pieces of its base lie in cells that hold none."""
    simulation = block_on_a_plane("plane_strain", 0.3, 30.0)
    active, constraints = locate_contacts(simulation)
    (part,) = constraints.parts
    own = np.floor(part.pose.position)
    used = active.position[part.at.node[part.at.cell]].min(axis=1)
    elsewhere = (own != used).any(axis=1)
    assert elsewhere.any()
    filled = np.unique(np.floor(simulation.state.points.position), axis=0)
    for corner in np.unique(used, axis=0):
        assert (filled == corner).all(axis=1).any()
    field: Any = np.array([0.4, -0.7]) + active.position @ np.array([[1.0, 0.3], [-0.2, 2.0]])
    exact = np.array([0.4, -0.7]) + part.pose.position @ np.array([[1.0, 0.3], [-0.2, 2.0]])
    np.testing.assert_allclose(part.at.interpolate(field), exact, atol=1e-12)


@pytest.mark.parametrize("shape", ["plane", "circle"])
def test_nothing_acts_beyond_the_axis(shape: str) -> None:
    """The area in axisymmetry is that of the part at r >= 0, once."""
    geometry: dict[str, Any] = line(np.array([0.0, 0.8]), np.array([0.0, 1.0]))
    exact = np.pi * 2.0**2
    if shape == "circle":
        geometry = {"type": "circle", "centre": [0.0, 1.0], "radius": 0.7, "soil": "outside"}
        exact = 4.0 * np.pi * 0.7**2
    wall = implicit("wall", geometry, displacement={"y": 0.01})  # a moving one has more points
    entries = block_entries("axisymmetric", "linear", boundaries=[wall])
    _, constraints = locate_contacts(Simulation(Model.from_dict(entries)))
    pose = constraints.parts[0].pose
    assert pose.position[:, 0].min() > 0.0
    within = pose.position[:, 0] < 2.0  # inside a block the ellipsoids reach beyond its end
    # the arc's pieces are projected
    assert pose.weight[within].sum() == pytest.approx(exact, rel=1e-3)
