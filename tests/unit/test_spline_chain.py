# SPDX-License-Identifier: BSD-3-Clause
"""Redistribution of the points of a chain, and chains that cross."""

import time

import numpy as np
import pytest

from tilth.curves import Chain, LocalCubicSpline
from tilth.curves.crossing import find_crossings
from tilth.surface.redistribution import redistribute_points

SQUARE = Chain([[0, 0], [1, 0], [1, 1], [0, 1]], True, np.ones(4, dtype=bool))


def circle(n, radius=1.0, centre=(0.0, 0.0), turn=0.0):
    angle = 2.0 * np.pi * np.arange(n) / n + turn
    return np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def lengths(chain):
    return np.linalg.norm(chain.chord, axis=1)


def on_old_curve(new, chain):
    """The new points are the places on the old spline that they say they are."""
    place = LocalCubicSpline(chain).position(new.segment, new.parameter)
    np.testing.assert_allclose(new.chain.points, place, atol=1e-15)
    assert ((new.parameter >= 0.0) & (new.parameter <= 1.0)).all()


def test_a_chain_with_good_distances_stays_as_it_is():
    for chain in (Chain(circle(40), True), Chain(circle(40)[:30], False)):
        new = redistribute_points(chain, 0.2, 0.09)
        assert (new.inserted, new.merged) == (0, 0)
        np.testing.assert_array_equal(new.chain.points, chain.points)
        on_old_curve(new, chain)


@pytest.mark.parametrize("closed", [True, False])
def test_long_chords_are_divided_on_the_curve(closed):
    chain = Chain(circle(40)[np.r_[0:10, 11:20, 23:40]], closed)
    new = redistribute_points(chain, 0.2, 0.05)
    assert lengths(new.chain).max() <= 0.2
    assert (new.inserted, new.merged) == (1 + 3, 0)
    on_old_curve(new, chain)
    # a chord up to twice the limit is divided in the middle of its parameter
    np.testing.assert_array_equal(new.segment[:12], [*range(10), 9, 10])
    assert new.parameter[10] == 0.5
    off = np.abs(np.linalg.norm(new.chain.points, axis=1) - 1.0)
    assert off.max() < 5e-4
    assert off.max() > 0.0
    assert new.chain.closed == closed


def test_crowded_points_merge_on_the_curve():
    points = circle(40)
    chain = Chain(np.insert(points, [10, 20], circle(40, turn=1e-2)[[9, 19]], axis=0), True)
    new = redistribute_points(chain, 0.4, 0.05)
    assert (new.inserted, new.merged) == (0, 2)
    on_old_curve(new, chain)
    assert (new.segment[9], new.parameter[9]) == (9, 0.5)
    np.testing.assert_allclose(new.chain.points[9], circle(40, turn=5e-3)[9], atol=1e-6)
    assert lengths(new.chain).min() >= 0.05


def test_merging_thins_a_crowd_but_not_more():
    points = circle(1000)
    new = redistribute_points(Chain(points, True), 0.2, 0.05)
    assert lengths(new.chain).min() >= 0.05
    assert lengths(new.chain).max() <= 0.2
    assert new.merged > 800
    np.testing.assert_array_equal(new.chain.points[0], points[0])
    area = LocalCubicSpline(new.chain).area
    assert abs(area - np.pi) < 1e-5


def test_corners_never_merge_and_new_points_are_none():
    step = np.array([0.0, 0.01, 0.5, 0.99])
    sides = [p + step[:, None] * q for p, q in zip(SQUARE.points, SQUARE.chord, strict=True)]
    corner = np.tile([True, False, False, False], 4)
    chain = Chain(np.concatenate(sides), True, corner)
    new = redistribute_points(chain, 0.3, 0.05)
    assert (new.merged, new.inserted) == (8, 8)
    np.testing.assert_array_equal(new.chain.points[new.chain.corner], SQUARE.points)
    assert abs(LocalCubicSpline(new.chain).area - 1.0) < 1e-15
    crowded = redistribute_points(SQUARE, 9.0, 2.0)
    assert crowded.merged == 0
    np.testing.assert_array_equal(crowded.chain.points, SQUARE.points)


def test_the_ends_of_an_open_chain_stay():
    way = np.sort(np.random.default_rng(5).uniform(0.0, 1.0, 50))
    way[[0, -1]] = 0.0, 1.0
    chain = Chain(np.stack([way, 0.1 * np.sin(3.0 * way)], axis=1), False)
    new = redistribute_points(chain, 0.2, 0.05)
    np.testing.assert_array_equal(new.chain.points[[0, -1]], chain.points[[0, -1]])
    assert lengths(new.chain).min() >= 0.05
    assert lengths(new.chain).max() <= 0.2
    on_old_curve(new, chain)


def test_a_chain_is_never_merged_away():
    new = redistribute_points(Chain(circle(12, 1e-3), True), 1.0, 0.25)
    assert len(new.chain) == 4


def test_limits_that_would_insert_and_merge_by_turns_are_refused():
    with pytest.raises(ValueError, match=r"shortest = 0\.15 must be below half of longest = 0\.2"):
        redistribute_points(SQUARE, 0.2, 0.15)


def test_a_simple_chain_does_not_cross():
    rng = np.random.default_rng(1)
    radius = 1.0 + 0.3 * rng.uniform(size=400)
    star = circle(400) * radius[:, None]
    for closed in (True, False):
        assert len(find_crossings([Chain(star, closed)])) == 0
    assert len(find_crossings([SQUARE])) == 0
    assert len(find_crossings([Chain(SQUARE.points[:3], True)])) == 0
    ring = [Chain(circle(100), True), Chain(circle(80, 0.9)[::-1], True)]
    assert len(find_crossings(ring)) == 0


def test_a_figure_of_eight_crosses_at_its_middle():
    angle = 2.0 * np.pi * (np.arange(99) + 0.3) / 99
    chain = Chain(np.stack([np.sin(angle), np.sin(2.0 * angle)], axis=1), True)
    found = find_crossings([chain])
    assert len(found) == 1
    np.testing.assert_allclose(found.position, [[0.0, 0.0]], atol=1e-3)
    for chord in found.chord[0]:
        a, ahead = chain.points[chord], chain.chord[chord]
        arm = found.position[0] - a
        assert abs(arm[0] * ahead[1] - arm[1] * ahead[0]) < 1e-15
        assert 0.0 <= arm @ ahead <= ahead @ ahead
    np.testing.assert_array_equal(found.chain, [[0, 0]])


def test_chains_that_cross_each_other_are_told():
    chains = [Chain(circle(60), True), Chain(circle(50, centre=(1.0, 0.0)), True)]
    found = find_crossings(chains)
    order = np.argsort(found.position[:, 1])
    np.testing.assert_allclose(
        found.position[order], [[0.5, -np.sqrt(0.75)], [0.5, np.sqrt(0.75)]], atol=5e-3
    )
    np.testing.assert_array_equal(found.chain, [[0, 1], [0, 1]])


def test_touching_counts():
    touches = Chain([[0, 0], [2, 0], [2, 1], [1, 0], [0, 1]], True)
    found = find_crossings([touches])
    np.testing.assert_array_equal(found.chord, [[0, 2], [0, 3]])
    np.testing.assert_allclose(found.position, [[1.0, 0.0], [1.0, 0.0]])
    folded = Chain([[0, 0], [2, 0], [1, 0], [1, 1]], False)
    found = find_crossings([folded])
    assert [0, 1] in found.chord.tolist()
    shared = find_crossings([Chain([[0, 0], [2, 0]], False), Chain([[1, 0], [3, 0]], False)])
    np.testing.assert_allclose(shared.position, [[1.5, 0.0]])


def test_crossings_are_those_of_all_pairs():
    points = np.random.default_rng(8).uniform(size=(70, 2))
    points[10] = [8.0, 3.0]  # one chord much longer than the others
    found = find_crossings([Chain(points, True)])
    start, ahead = points, Chain(points, True).chord
    expected = []
    for i in range(70):
        for j in range(i + 2, 70 - (i == 0)):
            share = np.linalg.solve(np.stack([ahead[i], -ahead[j]], axis=1), start[j] - start[i])
            if ((share >= 0.0) & (share <= 1.0)).all():
                expected.append([i, j])
    assert len(expected) > 100
    assert sorted(np.sort(found.chord, axis=1).tolist()) == expected


def test_thousands_of_points_are_quick():
    angle = 2.0 * np.pi * (np.arange(20000) + 0.3) / 20000
    radius = 1.0 + 0.2 * np.sin(40.0 * angle)
    curve = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    began = time.perf_counter()
    assert len(find_crossings([Chain(curve, True)])) == 0
    assert time.perf_counter() - began < 2.0
