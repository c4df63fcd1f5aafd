# SPDX-License-Identifier: BSD-3-Clause
"""The multiplier space of implicit boundaries: vertices, patches, means."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from implicit_problems import implicit, line, locate_contacts, rotation
from small_problems import KINDS, block_entries, dimension

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries import ImplicitConstraints
from tilth.boundaries.implicit.constraint import SurfaceConstraint
from tilth.boundaries.surfaces.multipliers import Multipliers
from tilth.mpm.active_grid import ActiveGrid

every_angle = pytest.mark.parametrize("angle", [0.0, 10.0, 17.0, 30.0, 45.0, 70.0, 90.0])


def cut_by(
    kind: str, walls: list[dict[str, Any]], upper: float = 6.0
) -> tuple[ActiveGrid, ImplicitConstraints]:
    """Boundaries in a block of six cells a side that reaches over all of them."""
    entries = block_entries(kind, "gimp", boundaries=walls)
    dim = dimension(kind)
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0.0] * dim, "upper": [upper] * dim}
    return locate_contacts(Simulation(Model.from_dict(entries)))


def multipliers_of(constraints: ImplicitConstraints) -> list[Multipliers]:
    found = []
    for part in constraints.parts:
        assert isinstance(part, SurfaceConstraint)
        assert part.multipliers is not None
        found.append(part.multipliers)
    return found


def inclined(kind: str, angle: float, through: float = 3.1) -> dict[str, Any]:
    """A plane through the block's middle, its normal turned from the last axis."""
    turned = rotation(angle)[:, 1]
    normal = np.zeros(dimension(kind))
    normal[0], normal[-1] = turned
    return line(np.full(dimension(kind), through), normal)


@every_angle
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("condition", ["roller", "fixed", "tangential"])
def test_every_point_belongs_to_one_patch_near_it(kind: str, condition: str, angle: float) -> None:
    active, constraints = cut_by(
        kind, [implicit("cut", inclined(kind, angle), condition=condition)]
    )
    (constrained,) = multipliers_of(constraints)
    part = constraints.parts[0]
    rank = {"roller": 1, "fixed": dimension(kind), "tangential": dimension(kind) - 1}[condition]
    assert constrained.multiplier.shape == (rank, len(part.chosen))
    assert set(constrained.multiplier.ravel()) == set(range(len(constrained.area)))
    place = (part.pose.position - active.grid.origin) / active.grid.cell_size
    for multiplier in constrained.multiplier:
        away = np.abs(place - constrained.vertex[multiplier]).max(axis=1)
        assert away.max() < 2.0
    assert constrained.area.sum() == pytest.approx(rank * part.pose.weight.sum(), rel=1e-12)
    np.testing.assert_allclose(np.einsum("rni,sni->nrs", constrained.direction,
    constrained.direction),
                               np.broadcast_to(np.eye(rank), (len(part.chosen), rank, rank)),
                               atol=1e-12)  # fmt: skip


@every_angle
@pytest.mark.parametrize("kind", KINDS)
def test_no_more_multipliers_than_independent_nodes(kind: str, angle: float) -> None:
    """Linearly independent rows, and along the grid one for each node of a column."""
    _, constraints = cut_by(kind, [implicit("cut", inclined(kind, angle))])
    (constrained,) = multipliers_of(constraints)
    nodes = constrained.node.max() + 1
    rows = np.zeros((len(constrained.area), nodes, dimension(kind)))
    for number, (low, high) in enumerate(
        zip(constrained.node_start, constrained.node_start[1:], strict=False)
    ):
        rows[number, constrained.node[low:high]] = (
            constrained.row[low:high] / constrained.area[number]
        )
    value = np.linalg.svd(rows.reshape(len(rows), -1), compute_uv=False)
    assert value.min() > 0.1 * value.max()
    if angle in (0.0, 90.0):
        assert len(constrained.area) == 7 ** (dimension(kind) - 1)


def test_the_choice_does_not_depend_on_what_the_geometry_is_called() -> None:
    """A straight polyline and a plane: the same places give the same vertices."""
    flat = inclined("plane_strain", 17.0)
    along = np.array([flat["normal"][1], -flat["normal"][0]])
    ends = np.array([flat["point"]]) + np.outer([-20.0, 20.0], along)
    polyline = {"type": "polyline", "vertices": ends.tolist(), "soil": "left"}
    found = [
        multipliers_of(cut_by("plane_strain", [implicit("cut", geometry)])[1])[0].vertex
        for geometry in (flat, polyline)
    ]
    order = [np.lexsort(place.round(6).T) for place in found]
    np.testing.assert_allclose(found[0][order[0]], found[1][order[1]], atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_means_of_linear_fields_are_those_at_the_patches_centres(kind: str) -> None:
    active, constraints = cut_by(kind, [implicit("cut", inclined(kind, 25.0), condition="fixed")])
    (constrained,) = multipliers_of(constraints)
    part, random = constraints.parts[0], np.random.default_rng(3)
    dim = dimension(kind)
    gradient, offset = random.uniform(-1, 1, (dim, dim)), random.uniform(-1, 1, dim)
    field = active.position @ gradient.T + offset
    mean = constrained.mean(part.at.interpolate(field))
    by_rows = np.add.reduceat(
        np.einsum("ei,ei->e", constrained.row, field[constrained.node]), constrained.node_start[:-1]
    )
    np.testing.assert_allclose(by_rows / constrained.area, mean, atol=1e-12)
    for number in range(len(constrained.area)):
        slot, point = np.nonzero(constrained.multiplier == number)
        assert len(set(slot)) == 1
        centre = np.average(part.pose.position[point], axis=0, weights=constrained.weight[point])
        direction = constrained.direction[slot[0], point[0]]  # a plane: the same all over
        assert mean[number] == pytest.approx(direction @ (gradient @ centre + offset), abs=1e-12)


def test_conditions_that_meet_share_no_direction_of_a_node() -> None:
    """In a corner on the grid's lines: a fixed base, and a roller that leaves it the corner."""
    base = implicit("base", line(np.array([0.0, 1.0]), np.array([0.0, 1.0])), condition="fixed")
    wall = implicit("wall", line(np.array([1.0, 0.0]), np.array([1.0, 0.0])))
    for walls in ([base, wall], [wall, base]):
        _, constraints = cut_by("plane_strain", walls)
        found = dict(zip([w["name"] for w in walls], multipliers_of(constraints), strict=True))
        corner = np.array([1.0, 1.0])
        at_corner = {
            name: int((np.abs(constrained.vertex - corner).max(axis=1) < 1e-6).sum())
            for name, constrained in found.items()
        }
        first = walls[0]["name"]
        assert at_corner == ({"base": 2, "wall": 0} if first == "base" else {"base": 1, "wall": 1})


def test_rows_are_refused_where_sizes_disagree() -> None:
    from tilth import _core

    one = np.ones(1)
    with pytest.raises(ValueError, match="penalty has"):
        _core.multiplier_means(
            1, np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64),
            np.zeros(1, dtype=np.int64), np.zeros((1, 4), dtype=np.int32), one,
            np.ones((1, 2)), np.ones(2), np.ones((1, 4)),
        )  # fmt: skip


def test_a_mean_of_constant_vectors_is_their_component() -> None:
    _, constraints = cut_by("3d", [implicit("cut", inclined("3d", 40.0), condition="tangential")])
    (constrained,) = multipliers_of(constraints)
    vector = np.tile([0.3, -0.2, 0.5], (constrained.multiplier.shape[1], 1))
    mean: Floats = constrained.mean(vector)
    np.testing.assert_allclose(
        constrained.distribute(mean), vector - _across(constraints, vector), atol=1e-12
    )


def _across(constraints: ImplicitConstraints, vector: Floats) -> Floats:
    normal = constraints.parts[0].pose.normal
    return np.asarray(normal * np.einsum("ni,ni->n", normal, vector)[:, None])


def averaged(part: SurfaceConstraint, traction: Floats, share: Floats) -> Floats:
    """The tractions with which a step begins, for those stored and elastic shares of the soil."""
    part.boundary.carried = np.zeros_like(part.boundary.carried)
    part.boundary.carried[part.chosen] = traction
    return replace(part, elastic_share=share).before


@pytest.mark.parametrize("kind", KINDS)
def test_tractions_are_averaged_over_the_flowing_part_of_a_patch(kind: str) -> None:
    _, constraints = cut_by(kind, [implicit("cut", inclined(kind, 20.0))])
    (part,) = constraints.parts
    assert isinstance(part, SurfaceConstraint)
    assert part.multipliers is not None
    direction, patch = part.multipliers.direction[0], part.multipliers.multiplier[0]
    random = np.random.default_rng(5)
    traction = random.normal(size=(len(part.chosen), 1)) * direction
    flows = random.uniform(size=len(part.chosen)) < 0.5
    for share in (random.uniform(size=len(flows)), 1.0 - flows):
        found = averaged(part, traction, share)
        mean = part.multipliers.mean
        np.testing.assert_allclose(mean(found), mean(traction), rtol=0, atol=1e-13)
    np.testing.assert_array_equal(found[~flows], traction[~flows])
    along = np.einsum("ni,ni->n", found, direction)
    for number in range(len(part.multipliers.area)):
        own = along[flows & (patch == number)]
        assert len(own) == 0 or np.ptp(own) < 1e-13
    np.testing.assert_allclose(averaged(part, found, share), found, rtol=0, atol=1e-13)
