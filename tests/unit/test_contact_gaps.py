# SPDX-License-Identifier: BSD-3-Clause
"""The gap of surface points at the start of a step, and how the area in contact spreads with it."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contact_terms import DRIVEN, next_contact
from contact_terms import pressed as pressed_block

from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.boundaries.contact.patches import (
    INEXACT_DRIFT,
    LARGEST_DRIFT,
    SCATTER_OF_MEANS,
    frames,
)
from tilth.boundaries.contact.smoothness import smoothness
from tilth.boundaries.contact.surface import AWAY, NEVER, OPEN, CarriedContact, Touch
from tilth.grid.background import Grid
from tilth_verification.cases import example, varied
from tilth_verification.contact_runs import ContactRun, run_contact

CELL = 2.0


def touch(state: float, carried: float, measured: float, scatter: float) -> Touch:
    """The contact of one point of a rigid body, in plane strain; lengths in cells."""
    surface: Any = SimpleNamespace(
        carried=np.array([[0.0, 0.0, state, 0.0, carried * CELL, 0.0, 0.0]]),
        cell=CELL,
        full=False,
        touches_nearly=False,
        has_inertia=False,
    )
    gaps = np.array([measured]) * CELL, np.array([scatter]) * CELL
    return CarriedContact.touch(surface, np.array([0]), *gaps)


@pytest.mark.parametrize(
    ("state", "carried", "measured", "scatter", "expected"),
    [
        (OPEN, 0.011, 0.005, 0.02, 0.011),
        (OPEN, 0.030, 0.005, 0.02, 0.015),
        (OPEN, 0.001, 0.050, 0.02, 0.040),
        (OPEN, 0.030, 0.005, 0.00, 0.005),
        (OPEN, 0.011, 0.005, 0.03, 0.005),
        (AWAY, 0.000, 0.005, 0.02, 0.005),
        (NEVER, 0.000, 0.005, 0.02, 0.005),
    ],
    ids=["carried", "upper end", "lower end", "exactly known", "steep", "away", "never near"],
)
def test_gap_without_contact(
    state: float, carried: float, measured: float, scatter: float, expected: float
) -> None:
    """The carried one within half the scatter of the measured one, or the measured one."""
    found = touch(state, carried, measured, scatter)
    assert not found.closed[0]
    assert found.gap[0] / CELL == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    ("state", "carried", "measured", "expected"),
    [
        (1.0, 0.07, -0.05, 0.07),
        (OPEN, -0.002, 0.005, -0.002),
        (OPEN, -0.008, -0.005, -0.003),
        (AWAY, 0.0, -0.005, 0.0),
        (NEVER, 0.0, -0.005, 0.0),
    ],
    ids=["was in contact", "overlaps", "overlaps far", "away", "never near"],
)
def test_gap_in_contact(state: float, carried: float, measured: float, expected: float) -> None:
    found = touch(state, carried, measured, 0.02)
    assert found.closed[0]
    assert found.gap[0] / CELL == pytest.approx(expected, abs=1e-15)


def pressed(changes: dict[str, Any]) -> ContactRun:
    """The sphere of examples/hertz in soil of 0.6 m."""
    small = {
        "bodies.0.shape.upper": [0.6, 0.6],
        "boundaries.0.at": 0.6,
        "rigid_bodies.0.geometry.centre": [0.0, 5.6],
        "rigid_bodies.0.centre": [0.0, 5.6],
    }
    return run_contact(varied(example("hertz", "sphere.toml"), small | changes))


def force(run: ContactRun) -> Floats:
    return np.asarray(-run.force["sphere"][:, 1])


@pytest.mark.slow
def test_an_elastic_contact_depends_on_neither_steps_nor_control() -> None:
    """Without friction the force belongs to the depth, however it was reached."""
    runs = [pressed({"schedule.steps": steps}) for steps in (5, 10, 20)]
    last = [float(force(run)[-1]) for run in runs]
    assert last[0] == pytest.approx(last[2], rel=1e-3)
    assert last[1] == pytest.approx(last[2], rel=1e-3)
    control = {"rigid_bodies.0.displacement": None, "rigid_bodies.0.force": {"y": -last[1]}}
    depth = -float(pressed(control).displacement[-1, 1])
    assert depth == pytest.approx(0.002, rel=1e-3)


@pytest.mark.parametrize(("flat", "turns"), [(False, False), (True, True), (True, False)])
def test_gaps_follow_what_is_measured_since_contact_closed(
    flat: bool, turns: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a hundredth of a cell a step, beyond what is inexact; not on flat faces that only move."""
    simulation = pressed_block("plane_strain", "friction", DRIVEN)
    simulation.advance(0.0, 0.25)
    _, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    patch = max(term._patches, key=lambda each: int(each.part.touch.closed.sum()))
    touch, cell = patch.part.touch, patch.part.boundary.cell
    assert touch.closed.any()
    assert patch.part.boundary.is_flat  # the bottom of the box
    monkeypatch.setattr(type(patch.part.boundary), "is_flat", flat)
    patch.part.pose.gradient[:] = np.array([[0.0, -0.003], [0.003, 0.0]]) * turns
    most = 0.0 if flat and not turns else LARGEST_DRIFT * cell
    inexact = (INEXACT_DRIFT + SCATTER_OF_MEANS * touch.scatter.max() / cell) * cell
    for drift, expected in (
        (0.0, 0.0),
        (-0.9 * INEXACT_DRIFT * cell, 0.0),
        (-inexact - cell, -most),
        (inexact + cell, most),
    ):
        touch.moved[:] = touch.gap + drift
        patch.restart()
        present = touch.closed & (patch.part.pose.weight > 0.0)
        followed = (patch.first_gap - touch.gap)[present]
        np.testing.assert_allclose(followed, expected, rtol=0, atol=1e-12 * cell)
        assert not (patch.first_gap - touch.gap)[~touch.closed].any()


def test_a_step_that_failed_leaves_gaps_of_supports_to_the_next_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of carried gaps of 0.05 cells what is beyond the motion in the step."""
    simulation = pressed_block("plane_strain", "friction", DRIVEN)
    simulation.advance(0.0, 0.25)
    _, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    patch = max(term._patches, key=lambda each: int(each.part.touch.closed.sum()))
    part, touch, cell = patch.part, patch.part.touch, patch.part.boundary.cell
    touch.gap[touch.closed] = 0.05 * cell
    touch.moved[:] = touch.gap
    whole = np.array([touch.closed[part.multiplier == k].all() for k in range(patch.count)])
    whole &= patch.area > 0.0
    assert whole.any()
    patch.restart(cautious=True)
    np.testing.assert_allclose(patch.gap[whole], 0.05 * cell, rtol=1e-12)
    for motion in (0.0, 0.01, 0.1):
        part.pose.increment[:] = [motion * cell, 0.0]
        patch.restart(cautious=True, deferring=True)
        left = max(0.05 - motion, 0.0) * cell
        np.testing.assert_allclose(patch.gap[whole], 0.05 * cell - left, rtol=0, atol=1e-14)
        present = touch.closed & (part.pose.weight > 0.0)
        np.testing.assert_allclose(patch.left[present], left, rtol=0, atol=1e-14)
        assert not patch.left[~touch.closed].any()


def test_what_is_left_to_the_next_step_is_carried(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gap at the end of a step in which the soil does not move."""
    simulation = pressed_block("plane_strain", "friction", DRIVEN)
    simulation.advance(0.0, 0.25)
    _, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    patch = max(term._patches, key=lambda each: int(each.part.touch.closed.sum()))
    part, touch = patch.part, patch.part.touch
    touch.gap[touch.closed] = 0.05 * part.boundary.cell
    touch.moved[:] = touch.gap
    part.pose.increment[:] = 0.0
    patch.restart(cautious=True, deferring=True)
    stored: list[Floats] = []
    monkeypatch.setattr(type(part.boundary), "store", lambda own, *rest: stored.append(rest[-2]))
    still = np.zeros((term._active.nodes, 2))
    term.forces(still, np.zeros(0))
    pushed = np.einsum("ni,ni->n", part.pose.normal, term._moved(patch, np.zeros(0)))
    term.commit(Unknowns({"u": still}), None)
    closed = touch.closed & ~term._is_small(patch)[part.multiplier]
    kept = stored[term._patches.index(patch)] + pushed
    np.testing.assert_allclose(kept[closed], touch.gap[closed], rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
def test_gaps_of_small_supports_are_tolerated_and_forgotten(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of up to a twentieth of a cell's face; others close to 1e-4 cells, and keep what is left.

    What is tolerated in contact must not act on the traction: the next step's mean gap begins at 0.
    """
    _, term = next_contact(pressed_block(kind, "friction"), 0.0, 0.25, monkeypatch)
    patch = max(term._patches, key=lambda each: float(each.area.max()))
    part, touch, cell = patch.part, patch.part.touch, patch.part.boundary.cell
    number, dim = int(patch.area.argmax()), part.pose.position.shape[1]
    own, weight = part.multiplier == number, part.pose.weight
    spread = np.random.default_rng(1).uniform(-0.01, 0.01, own.sum()) * cell
    spread -= np.average(spread, weights=weight[own])
    touch.closed[own] = True
    still, at_rest = np.zeros((term._active.nodes, dim)), np.zeros(len(term.scale))
    stored: list[Floats] = []
    monkeypatch.setattr(type(part.boundary), "store", lambda own, *rest: stored.append(rest[-2]))
    for share, of_cell in product((0.049, 0.051), (-0.9e-4, -1.1e-4, -0.02, 0.02)):
        gap, is_small, is_closed = of_cell * cell, share < 0.05, of_cell < 0.0
        is_wide = is_closed and not is_small and of_cell < -1e-4
        weight[own] *= share * cell ** (dim - 1) / part.area[own].sum()
        touch.gap[own] = touch.moved[own] = gap + spread
        patch.restart()
        term.forces(still, at_rest)
        term.revise(Unknowns({"u": still}, at_rest))
        added = patch.stiffness[number, 0] * gap if is_wide else 0.0
        assert patch.added[number, 0] == pytest.approx(added, rel=1e-9)
        stored.clear()
        term.commit(Unknowns({"u": still}, at_rest), None)
        kept = stored[term._patches.index(patch)][own]
        expected = spread if is_closed and is_small else gap + spread
        np.testing.assert_allclose(kept, expected, rtol=0, atol=1e-12 * cell)


def test_supports_without_weight_have_directions() -> None:
    """Of slivers, whose points have no weight, in space."""
    normal = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [1.0, 0.0, 0.0]])
    found = frames(normal, np.array([0.0, 0.0, 1e-4]), np.array([0, 0, 1]), 2)
    products = np.einsum("ani,bni->nab", found, found)
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-14)


def test_what_was_measured_when_contact_closed_is_kept() -> None:
    """Over steps in which the soil slides, until the contact is lost."""
    simulation = pressed_block("plane_strain", "friction", DRIVEN)
    simulation.advance(0.0, 0.25)
    before = [each.carried.copy() for each in simulation.state.contact_surfaces]
    simulation.advance(0.25, 0.5)
    kept = 0
    for surface, was in zip(simulation.state.contact_surfaces, before, strict=True):
        both = (surface.carried[:, 2] == 1.0) & (was[:, 2] == 1.0)
        kept += int(both.sum())
        np.testing.assert_allclose(surface.carried[both, 5], was[both, 5], rtol=0, atol=1e-15)
    assert kept > 0


def test_the_smooth_surface_of_soil_does_not_depend_on_the_origin() -> None:
    """Points are fitted in the grid's cells, which are where the grid begins."""
    angle = np.linspace(-0.9, 0.9, 60)
    normal = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    gap = 1e-3 * np.cos(9.0 * angle) ** 2
    found = []
    for shift in ([0.0, 0.0], [0.37, -2.11]):
        lines = (np.array([0.0, 0.4, 0.8, 1.3, 1.9]), np.zeros(0))
        grid = Grid(np.array([-0.8, -1.0]) + shift, np.array([0.4, 0.5]), lines=lines)
        found.append(smoothness(normal + shift, normal, gap, grid))
    assert np.allclose(found[0].scatter, found[1].scatter, atol=1e-12)
    assert np.allclose(found[0].normal, found[1].normal, atol=1e-9)
    assert len(np.unique(found[0].scatter)) > 2
