# SPDX-License-Identifier: BSD-3-Clause
"""Essential conditions: which nodes they hold, contradictions, and rigid motions left free."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, logm
from small_problems import KINDS, affine, block_entries, plane, rollers

from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation
from tilth.boundaries import Conditions
from tilth.mpm.active_grid import Buffers, locate


def simulation(kind: str, boundaries: list[dict[str, Any]], **changed: Any) -> Simulation:
    return Simulation(
        Model.from_dict(block_entries(kind, "linear", boundaries=boundaries, **changed))
    )


def conditions(
    kind: str, boundaries: list[dict[str, Any]], before: float = 0.0, after: float = 1.0
) -> tuple[np.ndarray, Conditions]:
    """Node positions of a 2-cell block, and the conditions on them."""
    ready = simulation(kind, [*boundaries, *rollers(kind)])
    active = ready.check()
    return active.position, Conditions.gather(ready.state.boundaries, active, before, after)


def held_by(found: Conditions, number: int, component: int) -> np.ndarray:
    return found.boundary[:, component] == number


def test_plane_holds_its_nodes_only() -> None:
    position, found = conditions("plane_strain", [plane("top", "y", 2.0, condition="fixed")])
    for component in (0, 1):
        assert np.array_equal(held_by(found, 0, component), position[:, 1] == 2.0)
    assert not found.increment.any()


def test_range_ends_at_its_last_nodes() -> None:
    part = plane("part", "y", 2.0, condition="fixed", range={"x": [1.0, 2.0]})
    position, found = conditions("plane_strain", [part])
    expected = (position[:, 1] == 2.0) & (position[:, 0] >= 1.0)
    assert np.array_equal(held_by(found, 0, 1), expected)


def test_range_in_3d_is_a_patch() -> None:
    part = plane("patch", "z", 2.0, condition="fixed", range={"x": [0.0, 1.0], "y": [1.0, 1.0]})
    position, found = conditions("3d", [part])
    expected = (position[:, 2] == 2.0) & (position[:, 0] <= 1.0) & (position[:, 1] == 1.0)
    assert expected.sum() == 2
    assert np.array_equal(held_by(found, 0, 2), expected)


def test_components_and_nodes() -> None:
    node = {
        "type": "node", "name": "pin", "at": [1.0, 2.0], "condition": "fixed", "components": ["x"],
    }  # fmt: skip
    position, found = conditions("plane_strain", [node])
    assert np.array_equal(held_by(found, 0, 0), (position == [1.0, 2.0]).all(axis=1))
    assert not held_by(found, 0, 1).any()


def test_prescribed_motion_follows_its_table() -> None:
    moving = plane(
        "push", "y", 2.0, condition="prescribed", displacement={"y": -0.4},
        factor=[[0.0, 0.0], [0.5, 1.0], [1.0, 0.25]],
    )  # fmt: skip
    for before, after, change in ((0.0, 0.25, 0.5), (0.25, 0.75, 0.125), (0.5, 1.0, -0.75)):
        position, found = conditions("plane_strain", [moving], before, after)
        top = position[:, 1] == 2.0
        np.testing.assert_allclose(found.increment[top, 1], -0.4 * change, rtol=1e-15)
        assert not found.increment[~top].any()
        assert not held_by(found, 0, 0).any()  # components not named are free


def test_table_that_goes_back_ends_where_it_was() -> None:
    push = plane(
        "push", "y", 2.0, condition="prescribed", displacement={"y": -0.4},
        factor=[[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]],
    )  # fmt: skip
    ready = simulation("plane_strain", [push, *rollers("plane_strain")])
    ready.advance(0.0, 0.5)
    assert np.abs(ready.state.points.stress).max() > 100.0
    # the plane stays on its grid line while the points move: squeeze and release meet again
    ready.advance(0.5, 1.0)
    assert np.abs(ready.state.points.displacement).max() < 0.1


@pytest.mark.parametrize("path", ["linear", "exponential"])
def test_affine_increment_is_that_of_the_path(path: str) -> None:
    end = np.array([[1.5, 0.4], [0.1, 0.8]])
    ready = simulation("plane_strain", [affine(end, path)])
    active = ready.check()
    found = Conditions.gather(ready.state.boundaries, active, 0.3, 0.7)
    assert found.constrained.all()

    def gradient(time: float) -> np.ndarray:
        if path == "linear":
            return np.eye(2) + time * (end - np.eye(2))
        return np.asarray(expm(time * logm(end)))

    step = gradient(0.7) @ np.linalg.inv(gradient(0.3))
    exact = active.position @ (step - np.eye(2)).T
    np.testing.assert_allclose(found.increment, exact, rtol=0, atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_outer_nodes_are_those_that_two_cells_of_soil_do_not_surround(kind: str) -> None:
    dim = 3 if kind == "3d" else 2
    drive = affine(np.diag([1.5, 0.8, 0.8][:dim])) | {"nodes": "outer"}
    ready = simulation(kind, [drive], cells=5)
    active = ready.check()
    found = Conditions.gather(ready.state.boundaries, active, 0.0, 1.0)
    inner = ((active.position >= 2.0) & (active.position <= 3.0)).all(axis=1)
    assert inner.sum() == 2**dim
    np.testing.assert_array_equal(found.constrained, np.repeat(~inner[:, None], dim, axis=1))
    everywhere = simulation(kind, [drive | {"nodes": "all"}], cells=5)
    whole = Conditions.gather(everywhere.state.boundaries, active, 0.0, 1.0)
    assert np.array_equal(found.increment, np.where(found.constrained, whole.increment, 0.0))


def test_nodes_beside_a_hole_are_outer_ones() -> None:
    ready = simulation("plane_strain", [affine(np.eye(2)) | {"nodes": "outer"}], cells=7)
    place = ready.state.points.position
    place[(place < 1.0).all(axis=1)] += [6.0, 0.0]  # the soil of one cell at a corner is away
    active = ready.check()
    (outer,) = (
        b.prescribe(active, 0.0, 1.0).constrained.all(axis=1) for b in ready.state.boundaries
    )
    inner = ((active.position >= 2.0) & (active.position <= 5.0)).all(axis=1)
    corner = (active.position == 2.0).all(axis=1)
    assert np.array_equal(outer, ~inner | corner)


def test_contradiction_names_both_boundaries_and_the_node() -> None:
    up = plane("lift", "y", 2.0, condition="prescribed", displacement={"y": 0.2})
    down = plane("press", "y", 2.0, condition="prescribed", displacement={"y": -0.2})
    ready = simulation("plane_strain", [*rollers("plane_strain"), up, down])
    with pytest.raises(BadInput) as error:
        ready.check()
    text = str(error.value)
    assert "'lift' and 'press' prescribe different y displacements at the node (0, 2)" in text
    assert error.value.key == "boundaries[4]"


def test_boundaries_that_agree_share_a_node() -> None:
    """The corner belongs to both; its reaction counts for the one declared first."""
    side = plane("side", "x", 0.0, condition="fixed")
    base = plane("base", "y", 0.0, condition="fixed")
    for boundaries in ([side, base], [base, side]):
        position, found = conditions("plane_strain", boundaries)
        corner = (position == 0.0).all(axis=1)
        assert (found.boundary[corner] == 0).all()
        reaction = np.ones(position.shape)
        forces = found.forces(reaction)
        names = [b["name"] for b in boundaries]
        assert forces[names[0]].sum(axis=0).tolist() == [3.0, 3.0]
        assert forces[names[1]].sum(axis=0).tolist() == [2.0, 2.0]


def test_boundary_far_from_the_soil_is_reported_once() -> None:
    ready = simulation("plane_strain", [*rollers("plane_strain"), plane("far", "y", 50.0)])
    ready.check()
    ready.advance(0.0, 0.5)
    (far,) = (text for text in ready.services.warnings.texts if "'far'" in text)
    assert far.startswith("boundary 'far' touches no node of a cell with material: the nearest")


# --- rigid motions ---------------------------------------------------------------------------

PIN = {"type": "node", "name": "pin", "at": [0.0, 0.0], "condition": "fixed"}
FAR = {axis: plane(f"far {axis}", axis, 50.0) for axis in "xyz"}  # touches no soil
LOW = {axis: plane(f"low {axis}", axis, 0.0) for axis in "xyz"}

FREE = {
    "plane_strain: across": ("plane_strain", [LOW["y"], FAR["x"]], ["translation along x"]),
    "plane_strain: up": ("plane_strain", [LOW["x"], FAR["y"]], ["translation along y"]),
    "plane_strain: about a pin": ("plane_strain", [PIN], ["rotation in the xy plane"]),
    "axisymmetric: up": ("axisymmetric", [LOW["x"], FAR["y"]], ["translation along y"]),
    "3d: up": ("3d", [LOW["x"], LOW["y"], FAR["z"]], ["translation along z"]),
    "3d: on a base": (
        "3d",
        [LOW["z"], FAR["x"], FAR["y"]],
        ["translation along x", "translation along y", "rotation in the xy plane"],
    ),
    "3d: a hinge": (
        "3d",
        [plane("hinge", "z", 0.0, condition="fixed", range={"y": [0.0, 0.0]})],
        ["rotation in the yz plane"],
    ),
}


@pytest.mark.parametrize(("kind", "boundaries", "motions"), list(FREE.values()), ids=list(FREE))
def test_each_free_rigid_motion_is_named(
    kind: str, boundaries: list[dict[str, Any]], motions: list[str]
) -> None:
    with pytest.raises(BadInput, match="the system of equations is singular") as error:
        simulation(kind, boundaries).check()
    named = re.findall(r"(?:translation along|rotation in the) \w+(?: plane)?", str(error.value))
    assert set(motions) <= set(named)
    if "translation" in motions[0]:
        assert set(named) == set(motions)  # a rotation about a place elsewhere also translates
    assert error.value.key == "boundaries"
    assert error.value.exit_code == 2


ENOUGH = {
    "plane_strain": [
        {"type": "node", "name": "pin", "at": [0.0, 0.0], "condition": "fixed"},
        {
            "type": "node", "name": "slide", "at": [2.0, 0.0], "condition": "fixed",
            "components": ["y"],
        },
    ],
    "axisymmetric": [plane("base", "y", 0.0)],
    "3d": [plane(f"low {axis}", axis, 0.0) for axis in "xyz"],
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_just_enough_conditions_are_accepted_and_solvable(kind: str) -> None:
    pull = {"type": "body_force", "acceleration": [0.0] * (2 if kind == "3d" else 1) + [-5.0]}
    ready = simulation(kind, ENOUGH[kind], loads=[pull])
    ready.check()
    assert ready.advance(0.0, 1.0).equilibrium.residuals[-1] < 1e-9


@pytest.mark.parametrize("kind", KINDS)
def test_a_second_body_that_hangs_in_the_air_is_found(kind: str) -> None:
    entries = block_entries(kind, "gimp", boundaries=rollers(kind))
    dim = len(entries["bodies"][0]["shape"]["lower"])
    other = dict(entries["bodies"][0], name="other")
    lower = [4.0] * dim
    other["shape"] = {"type": "box", "lower": lower, "upper": [5.0] * dim}
    entries["bodies"].append(other)
    with pytest.raises(BadInput, match="not constrained against") as error:
        Simulation(Model.from_dict(entries)).check()
    assert "(" + ", ".join(["4.5"] * dim) + ")" in str(error.value)


def test_bodies_that_touch_hold_each_other() -> None:
    entries = block_entries("plane_strain", "linear", boundaries=rollers("plane_strain"))
    other = dict(entries["bodies"][0], name="other")
    other["shape"] = {"type": "box", "lower": [0.0, 2.0], "upper": [2.0, 3.0]}
    entries["bodies"].append(other)
    Simulation(Model.from_dict(entries)).check()


# --- domains that reach across a boundary -----------------------------------------------------


def holders(
    boundaries: list[dict[str, Any]], move: tuple[float, float]
) -> dict[tuple[float, float], str]:
    """Who holds the vertical displacement of each node under a GIMP block moved by `move`."""
    entries = block_entries("plane_strain", "gimp", boundaries=boundaries)
    ready = Simulation(Model.from_dict(entries))
    ready.state.points.position += move
    active = locate(ready.state.points, ready.state.grid, Buffers())
    found = Conditions.gather(ready.state.boundaries, active, 0.0, 1.0)
    names = [*found.names, "nobody"]
    return {
        (float(x), float(y)): names[number]
        for (x, y), number in zip(active.position, found.boundary[:, 1], strict=True)
    }


BASE = plane("base", "y", 0.0, condition="fixed")


def test_nodes_that_only_domains_reach_behind_a_plane_are_held_too() -> None:
    found = holders([BASE, FAR["x"]], (0.0, -0.01))
    assert {place: found[place] for place in found if place[1] < 0.0} == {
        (0.0, -1.0): "base", (1.0, -1.0): "base", (2.0, -1.0): "base",
    }  # fmt: skip
    assert {found[place] for place in found if place[1] > 0.0} == {"nobody"}


def test_nodes_behind_a_plane_with_soil_on_both_sides_are_free() -> None:
    found = holders([plane("middle", "y", 1.0, condition="fixed"), FAR["x"]], (0.0, -0.01))
    assert {place[1] for place in found if found[place] == "middle"} == {1.0}


@pytest.mark.parametrize(("side", "held"), [("lower", {-1.0, 0.0, 1.0}), ("upper", {1.0, 2.0})])
def test_all_nodes_on_a_solid_side_are_held(side: str, held: set[float]) -> None:
    """Whatever has got there."""
    middle = plane("middle", "y", 1.0, condition="fixed", solid_side=side)
    found = holders([middle, FAR["x"]], (0.0, -0.01))
    assert {place[1] for place in found if found[place] == "middle"} == held
    assert {place[1] for place in found if found[place] == "nobody"}.isdisjoint(held)


@pytest.mark.parametrize("height", [0.0, 1.0])
def test_slivers_beside_the_soil_are_free(height: float) -> None:
    """A free side face reaches into the next column of cells: no plane may hold that up."""
    across = plane("across", "y", height, condition="fixed")
    found = holders([across, FAR["x"]], (0.01, -0.01))
    beside = {place: found[place] for place in found if place[0] == 3.0 and place[1] > height}
    assert beside
    assert set(beside.values()) == {"nobody"}
