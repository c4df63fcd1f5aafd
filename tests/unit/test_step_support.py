# SPDX-License-Identifier: BSD-3-Clause
"""Nodes that soil hardly covers: the solve goes on and nothing leaps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from balances import space_of
from small_problems import AXES, BASES, KINDS, block_entries, by_number, dimension, plane, weight

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.terms.weak_springs import WeakSprings

every_kind = pytest.mark.parametrize("kind", KINDS)
every_domain = pytest.mark.parametrize("basis", [basis for basis in BASES if basis != "linear"])


def standing(kind: str, basis: str, overlap: float, **body: Any) -> Simulation:
    """A block of 4 points a side on a fixed base, its edges beyond the grid lines by `overlap`."""
    dim = dimension(kind)
    boundaries = [plane("base", AXES[dim - 1], 0.0, condition="fixed")]
    if kind == "axisymmetric":
        boundaries.append(plane("axis", "x", 0.0))
    entries = block_entries(kind, basis, boundaries=boundaries, loads=[weight(kind, 5.0)])
    declared = entries["bodies"][0]
    declared["shape"]["upper"] = [2.0 + overlap] * dim
    del declared["points_per_cell"]
    declared |= body or {"points": [4] * dim}
    return Simulation(Model.from_dict(entries))


@every_kind
@every_domain
@pytest.mark.parametrize(("overlap", "leap"), [(1e-2, 0.06), (1e-4, 0.03), (1e-7, 0.03)])
def test_slivers_change_little(kind: str, basis: str, overlap: float, leap: float) -> None:
    """Domains that reach a hair's breadth into further cells.

    Ghost stabilisation ties their nodes: against the aligned block of two cells a side stress
    changes by some per cent, without it by up to 40 %, however narrow the sliver.
    """
    aligned, sliver = standing(kind, basis, 0.0), standing(kind, basis, overlap)
    assert sliver.check().nodes > aligned.check().nodes
    for simulation in (aligned, sliver):
        residuals = simulation.advance(0.0, 1.0).equilibrium.residuals
        assert len(residuals) <= 5  # still Newton's pace
    one, other = by_number(aligned.state.points), by_number(sliver.state.points)
    for name, share in (("displacement", 0.5 * leap), ("stress", leap)):
        scale = np.abs(one[name]).max()
        assert np.abs(other[name] - one[name]).max() < share * scale


@every_kind
@every_domain
@pytest.mark.parametrize("overlap", [1e-9, 1e-12, 1e-14])
def test_overlaps_within_the_tolerance_are_none(kind: str, basis: str, overlap: float) -> None:
    aligned, sliver = standing(kind, basis, 0.0), standing(kind, basis, overlap)
    assert sliver.check().nodes == aligned.check().nodes
    for simulation in (aligned, sliver):
        simulation.advance(0.0, 1.0)
    one, other = by_number(aligned.state.points), by_number(sliver.state.points)
    for name in ("displacement", "stress"):
        scale = np.abs(one[name]).max()
        assert np.abs(other[name] - one[name]).max() < 20.0 * max(overlap, 1e-12) * scale


@every_kind
@every_domain
@pytest.mark.parametrize("overlap", [0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
def test_any_overlap_can_be_solved_and_carries_the_weight(
    kind: str, basis: str, overlap: float
) -> None:
    simulation = standing(kind, basis, overlap)
    simulation.check()
    result = simulation.advance(0.0, 1.0)
    assert result.equilibrium.residuals[-1] <= 1e-9
    up = dimension(kind) - 1
    expected = 5.0 * simulation.state.points.mass.sum()
    assert result.resultant("base")[up] == pytest.approx(expected, rel=1e-8)
    assert np.abs(simulation.state.points.displacement).max() < 0.05


@every_kind
def test_one_linear_point_a_cell_can_be_solved(kind: str) -> None:
    """The hour-glass motions of a cell with a single point have no strain there."""
    simulation = standing(kind, "linear", 0.0, points_per_cell=1)
    simulation.check()
    result = simulation.advance(0.0, 1.0)
    assert result.equilibrium.residuals[-1] <= 1e-9
    assert np.abs(result.equilibrium.displacement).max() < 0.1


@every_kind
def test_a_lone_point_in_a_cell_of_its_own_can_be_solved(kind: str) -> None:
    """A point drifts off into an empty neighbour cell: most motions of its nodes are free."""
    simulation = standing(kind, "linear", 0.0)
    top = simulation.state.points.position[:, 0].argmax()
    simulation.state.points.position[top, 0] = 2.0 + 1e-3
    result = simulation.advance(0.0, 0.1)
    assert result.equilibrium.residuals[-1] <= 1e-9


@every_kind
@every_domain
def test_springs_hold_hardly_covered_nodes_only(kind: str, basis: str) -> None:
    full = standing(kind, basis, 0.0)
    springs = WeakSprings.of(full.soil_on(full.check()))
    assert not springs.stiffness.any()
    sliver = standing(kind, basis, 1e-3)
    active = sliver.check()
    constrained = WeakSprings.of(sliver.soil_on(active)).stiffness > 0.0
    beyond = (active.position > 2.0).any(axis=1)
    assert np.array_equal(constrained, beyond)


@every_kind
def test_spring_stiffness_is_the_derivative_of_its_force(kind: str) -> None:
    sliver = standing(kind, "gimp", 1e-3)
    active = sliver.check()
    springs = WeakSprings.of(sliver.soil_on(active))
    dim = dimension(kind)
    blocks = np.zeros((len(active.column), dim, dim))
    term = springs.assembled(space_of(active), [])
    u = np.random.default_rng(0).normal(size=(active.nodes, dim))
    term.add_stiffness(u, blocks)
    for k in range(dim):
        blocks[active.diagonal, k, k] -= springs.shift  # in the matrix alone
    product = np.einsum("nij,nj->ni", blocks[active.diagonal], u)
    np.testing.assert_allclose(product, term.force(u), rtol=1e-14)
    blocks[active.diagonal] = 0.0
    assert not blocks.any()
