# SPDX-License-Identifier: BSD-3-Clause
"""How far domains with corners reach: boxes around them, boundaries beside them, the axis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from implicit_problems import implicit, line, locate_contacts
from small_problems import (
    CORNER_BASES,
    KINDS,
    Laboratory,
    block_entries,
    by_number,
    dimension,
    plane,
    weight,
)

from tilth import AnalysisFailed, Model, resume, run
from tilth.analysis.simulation import Simulation
from tilth.bodies.corners import corner_signs
from tilth.mpm.domains import half_edges, keep_off_axis, upper_edges
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.output import read_results
from tilth_verification.cases import example, varied

every_basis = pytest.mark.parametrize("basis", CORNER_BASES)
every_kind = pytest.mark.parametrize("kind", KINDS)


def slanted(kind: str, basis: str, steps: int = 3) -> MaterialPoints:
    """Points whose domains have been sheared and warped."""
    random = np.random.default_rng(3)
    laboratory = Laboratory.of(kind, basis, "hencky_elastic", random)
    for _ in range(steps):
        laboratory.step(laboratory.random_displacement(random, 0.1))
    return laboratory.points


@every_kind
@every_basis
def test_half_lengths_are_those_of_the_box_around_the_domain(kind: str, basis: str) -> None:
    points = slanted(kind, basis)
    np.testing.assert_array_equal(points.half_length, np.abs(points.corner).max(axis=1))
    highest = (points.position[:, None] + points.corner).max(axis=1)
    np.testing.assert_allclose(upper_edges(points), highest, rtol=0, atol=1e-15)
    assert (upper_edges(points) <= points.position + points.half_length + 1e-15).all()


def test_the_box_of_a_turned_domain_at_the_start() -> None:
    entries = block_entries("plane_strain", "cpdi1")
    entries["bodies"][0]["shape"] |= {"angle": 30.0}
    points = initial_points(Model.from_dict(entries))
    side = 0.25 * (np.cos(np.pi / 6) + np.sin(np.pi / 6))
    np.testing.assert_allclose(points.half_length, side, rtol=1e-14)
    np.testing.assert_allclose(points.initial_half_length, 0.25, rtol=1e-14)


@every_kind
def test_edges_of_domains_carried_by_f(kind: str) -> None:
    points = slanted(kind, "cpdi1")
    dim = dimension(kind)
    found = half_edges(points)
    carried = points.deformation_gradient[:, :dim, :dim].transpose(0, 2, 1) * 0.25
    own = 0.5 * np.stack([points.corner[:, 2**k] - points.corner[:, 0] for k in range(dim)], 1)
    np.testing.assert_allclose(found, own, rtol=1e-12, atol=1e-14)
    if kind != "axisymmetric":  # where the axis cuts domains short
        np.testing.assert_allclose(found, carried, rtol=1e-12, atol=1e-14)


@every_kind
def test_the_ellipsoid_of_a_warped_domain_holds_its_corners(kind: str) -> None:
    points = slanted(kind, "cpdi2")
    found = half_edges(points)
    assert found is not None
    place = np.einsum("nci,nik->nck", points.corner, np.linalg.inv(found))
    farthest = (place**2).sum(axis=2).max(axis=1)
    np.testing.assert_allclose(farthest, dimension(kind), rtol=1e-12)  # one is on it


def test_bodies_without_corners_have_boxes() -> None:
    entries = block_entries("plane_strain", "gimp")
    assert half_edges(initial_points(Model.from_dict(entries))) is None
    other = {**entries["bodies"][0], "name": "other", "basis": "cpdi2"}
    other["shape"] = {"type": "box", "lower": [2.0, 0.0], "upper": [4.0, 2.0]}
    entries["bodies"].append(other)
    points = initial_points(Model.from_dict(entries))
    points.half_length[:16] = [0.1, 0.2]
    corners, edges = points.all_corners(), half_edges(points)
    assert corners is not None
    assert edges is not None
    np.testing.assert_array_equal(corners[:16], np.tile(corner_signs(2) * [0.1, 0.2], (16, 1, 1)))
    np.testing.assert_array_equal(corners[16:], points.corner[16:])
    np.testing.assert_allclose(edges[:16], np.tile(np.diag([0.1, 0.2]), (16, 1, 1)), rtol=1e-14)


# --- boundaries --------------------------------------------------------------------------------


@every_basis
def test_thin_turned_domains_touch_what_is_beside_them(basis: str) -> None:
    """Domains four times as long as wide, turned by 90 degrees: a wall acts up to their width.

    Half lengths along the body's own axes, taken for those along the grid's, would be wrong here
    by a factor of four.
    """
    shape = {"type": "box", "lower": [2.0, 0.0], "upper": [4.0, 2.0], "angle": 90.0}  # [0,2]x[0,2]
    long, short = 0.5, 0.125
    middle = 2.0 - short  # of the points nearest to the wall
    for share, touches in ((0.99, True), (1.01, False)):  # of the width, see soil_contact.hpp
        wall = line(np.array([middle + share * 2.0 * short, 0.0]), np.array([-1.0, 0.0]))
        entries = block_entries(
            "plane_strain", basis,
            boundaries=[implicit("wall", wall), plane("base", "y", 0.0)],
        )  # fmt: skip
        body = entries["bodies"][0]
        del body["points_per_cell"]
        body |= {"shape": shape, "points": [2, 8]}
        simulation = Simulation(Model.from_dict(entries))
        points = simulation.state.points
        np.testing.assert_allclose(points.half_length, np.tile([short, long], (16, 1)), rtol=1e-12)
        assert points.position[:, 0].max() == pytest.approx(middle)
        _, constraints = locate_contacts(simulation, 0.0, 1.0)
        assert bool(constraints.parts) == touches
        if touches:
            assert constraints.parts[0].pose.weight.sum() == pytest.approx(2.0, rel=1e-12)


@every_basis
def test_a_wall_is_felt_by_domains_longer_than_its_cells(basis: str) -> None:
    """Domains whose ends lie more than a cell from the points: the nearest cells hold no point."""
    wall = implicit("wall", line(np.array([0.0, 0.0]), np.array([1.0, 0.0])))
    entries = block_entries(
        "plane_strain", basis, boundaries=[wall, plane("base", "y", 0.0)],
    )  # fmt: skip
    simulation = Simulation(Model.from_dict(entries))
    points = simulation.state.points
    # as after an extension by ten: in the columns of points a long way from the wall
    points.corner[:, :, 0] *= 10.0
    points.position[:, 0] *= 10.0
    points.update_bounding_boxes()
    _, constraints = locate_contacts(simulation, 0.0, 1.0)
    (part,) = constraints.parts
    assert part.pose.weight.sum() == pytest.approx(2.0, rel=1e-12)  # the whole face


# --- the axis of symmetry ----------------------------------------------------------------------


@every_basis
def test_turned_domains_beside_the_axis_are_whole(basis: str) -> None:
    """Long ones turned upright: their length is not one along the radius."""
    entries = block_entries("axisymmetric", basis)
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["shape"] = {"type": "box", "lower": [2.0, 0.0], "upper": [4.0, 2.0], "angle": 90.0}
    body["points"] = [2, 8]
    points = initial_points(Model.from_dict(entries))
    np.testing.assert_allclose(points.half_length, np.tile([0.125, 0.5], (16, 1)), rtol=1e-12)
    radius = points.position[:, None, 0] + points.corner[..., 0]
    assert radius.min() == pytest.approx(0.0, abs=1e-12)


def test_domains_that_lean_across_the_axis_end_at_it() -> None:
    entries = block_entries("axisymmetric", "cpdi1")
    points = initial_points(Model.from_dict(entries))
    points.deformation_gradient[:, 0, 1] = 0.4  # leans by 0.1 at its ends
    points.corner[:] = points.convected_corners()
    before = points.corner.copy()
    at_axis = points.position[:, 0] < 0.5
    assert (points.position[:, None, 0] + before[..., 0]).min() == pytest.approx(-0.1)
    keep_off_axis(points.part(points.ranges[0]))
    radius = points.position[:, None, 0] + points.corner[..., 0]
    assert radius[at_axis].min() == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_array_equal(points.corner[~at_axis], before[~at_axis])
    np.testing.assert_array_equal(points.corner[..., 1], before[..., 1])
    np.testing.assert_allclose(
        points.corner.sum(axis=1), 0.0, atol=1e-15
    )  # the point in its middle
    ratio = points.corner[at_axis, :, 0] / before[at_axis, :, 0]
    np.testing.assert_allclose(ratio, 0.25 / 0.35, rtol=1e-12)


@every_basis
def test_no_domain_crosses_the_axis_while_the_soil_is_sheared(basis: str) -> None:
    """A solid cylinder under its weight whose lower half is fixed: it leans about the axis."""
    entries: dict[str, Any] = block_entries(
        "axisymmetric", basis, loads=[weight("axisymmetric", 60.0)], schedule={"steps": 10},
        boundaries=[
            plane("axis", "x", 0.0),
            plane("base", "y", 0.0, condition="fixed"),
        ],
    )  # fmt: skip
    entries["bodies"][0]["points_per_cell"] = 3
    simulation = Simulation(Model.from_dict(entries))
    for k in range(10):
        simulation.advance(k / 10, (k + 1) / 10)
        points = simulation.state.points
        radius = points.position[:, None, 0] + points.corner[..., 0]
        assert radius.min() > -1e-12
        assert not (simulation.check().position[:, 0] < -0.5).any()  # no node beyond the axis
    box = corner_signs(2) * points.initial_half_length[:, None]
    carried = np.einsum("nij,ncj->nci", points.deformation_gradient[:, :2, :2], box)
    assert (points.position[:, None, 0] + carried[..., 0]).min() < -1e-4


def test_corners_that_would_cross_the_axis_stay_on_it() -> None:
    """CPDI2: the grid's nodes on the axis are moved across it."""
    laboratory = Laboratory.of("axisymmetric", "cpdi2", "hencky_elastic", np.random.default_rng(1))
    model = Model.from_dict(block_entries("axisymmetric", "cpdi2"))
    points = initial_points(model)
    laboratory = Laboratory("axisymmetric", points, Simulation(model, points).state.grid)
    u = np.zeros(laboratory.active.position.shape)
    u[:, 0] = -0.05
    before = by_number(points)
    laboratory.step(u)
    after = by_number(laboratory.points)
    place = before["position"][:, None] + before["corner"] + [-0.05, 0.0]
    place[..., 0] = np.maximum(place[..., 0], 0.0)
    np.testing.assert_allclose(
        after["position"][:, None] + after["corner"], place, rtol=0, atol=1e-14
    )
    at_axis = before["position"][:, 0] < 0.5
    np.testing.assert_allclose(after["position"][at_axis, 0], 0.225, rtol=1e-12)  # the middle


# --- folding -----------------------------------------------------------------------------------


def test_a_run_whose_domain_folds_says_so_and_can_be_resumed(tmp_path: Path) -> None:
    """A block between rough platens: the domains at their edges fold, however small the step."""
    changes = {
        "bodies.0.basis": "cpdi2", "bodies.0.domain_update": None, "bodies.0.points_per_cell": 2,
        "grid.cell_size": 0.25, "schedule.steps": 6, "schedule.outputs": 1,
        "schedule.minimum_step": 0.01, "output.report": False,
    }  # fmt: skip
    model = varied(example("upsetting"), changes)
    with pytest.raises(AnalysisFailed, match="the domain of a material point folded") as failure:
        run(model, tmp_path / "out", quiet=True)
    text = str(failure.value)
    assert "worst point: number" in text
    assert "residuals: none" not in text
    assert 'cpdi1" and "gimp" cannot fold: choose one of them for \'block\'' in text
    assert "smaller steps" not in text
    last = read_results(tmp_path / "out" / "results.vtkhdf").snapshot(-1)
    assert 0.5 < last.time < 0.95
    with pytest.raises(AnalysisFailed, match="folded"):  # in the same way
        resume(tmp_path / "out", quiet=True)
