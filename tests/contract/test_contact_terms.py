# SPDX-License-Identifier: BSD-3-Clause
"""The term of contact: derivatives by displacement and global unknowns, units, motion, reaction."""

from __future__ import annotations

import numpy as np
import pytest
from contact_terms import (
    DRIVEN,
    FREE,
    LAWS,
    branches_compared,
    next_contact,
    pressed,
    quarter_turn,
)
from readings import some_of
from small_problems import KINDS

from tilth.boundaries.contact.rotation import left_jacobian, rotation_by

every_kind = pytest.mark.parametrize("kind", KINDS)
every_law = pytest.mark.parametrize("law", LAWS)

BRANCHES = {
    "smooth": {"open", "slip"}, "held smooth": {"slip"}, "glued": {"stick"},
    "held friction": {"slip", "stick"}, "held adhesion": {"slip", "stick"},
}  # fmt: skip
"""Of the laws that have not all three."""


@pytest.mark.slow
@every_kind
@every_law
def test_derivatives(kind: str, law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of nodal forces and of the body's equations, by nodal displacement and the body's motion.

    In each branch of each law. The body in axisymmetry has one patch, which stays closed while
    the body is free.
    """
    seen: set[str] = set()
    for way in (FREE, DRIVEN) if kind == "axisymmetric" else (FREE,):
        simulation = pressed(kind, law, way)
        simulation.advance(0.0, 0.25)
        balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
        seen |= branches_compared(balance, term)
        monkeypatch.undo()
    assert seen == BRANCHES.get(law, {"open", "slip", "stick"})


@pytest.mark.slow
@every_kind
@pytest.mark.parametrize("basis", ["cpdi1", "cpdi2"])
def test_derivatives_on_domains_with_corners(
    kind: str, basis: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They couple the nodes of all cells in which the domains' corners lie."""
    simulation = pressed(kind, "friction", DRIVEN, basis=basis)
    simulation.advance(0.0, 0.25)
    assert "stick" in branches_compared(*next_contact(simulation, 0.25, 0.5, monkeypatch))


@pytest.mark.slow
@some_of(1, kind=KINDS, law=list(LAWS))
def test_results_do_not_depend_on_the_units(
    kind: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lengths and stresses with other numbers: powers of 2, for soil ends on the grid's lines."""
    length, stress = 1024.0, 8.0
    found = []
    for units in ((1.0, 1.0), (length, stress)):
        simulation = pressed(kind, law, FREE, *units)
        simulation.advance(0.0, 0.25)
        found.append(next_contact(simulation, 0.25, 0.5, monkeypatch))
    (one, term), (other, scaled) = found
    force = stress * length ** (1 if kind == "plane_strain" else 2)
    random = np.random.default_rng(5)
    u = 1e-4 * random.normal(size=(one.active.nodes, one.active.grid.dim))
    assert term.body is not None
    turns = np.array([slot >= term.body.dim for slot in term.body._axis[term.body.free]])
    unit = np.where(turns, 1.0, length)
    g = 1e-4 * random.normal(size=len(term.scale))
    nodal, own = term.forces(u, g)
    in_units = scaled.forces(length * u, unit * g)
    size = np.abs(nodal).max()
    np.testing.assert_allclose(in_units[0] / force, nodal, rtol=0, atol=1e-6 * size)
    expected = own * np.where(turns, length, 1.0)
    np.testing.assert_allclose(
        in_units[1] / force, expected, rtol=0, atol=1e-6 * np.abs(expected).max()
    )
    assert other.active.nodes == one.active.nodes


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@every_law
def test_soil_that_moves_with_the_body_does_not_slip(
    kind: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the rotation: the tractions are those of the start of the step."""
    simulation = pressed(kind, law)
    simulation.advance(0.0, 0.25)
    balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    body = term.body
    assert body is not None
    turn = np.array([0.3]) if body.dim == 2 else np.array([0.2, -0.3, 0.1])
    shift = np.array([0.1, -0.2, 0.05])[: body.dim]
    arm = balance.active.position - body.centre
    u = shift + arm @ (rotation_by(turn) - np.eye(body.dim)).T
    for patch in term._patches:
        patch.activate(patch.part.touch.closed)
        patch.gap[:] = 0.0  # that of the last step, on other patches
    term.forces(u, np.concatenate([shift, turn]))
    for patch, _, each in term._each():
        assert patch.active[patch.part.touch.closed].all()
        taking_part = patch.area > 0.0
        assert taking_part.any()
        np.testing.assert_allclose(each.slip[taking_part], 0.0, rtol=0, atol=1e-14)
        closed = taking_part & each.response.closed
        before = patch.before[closed]
        np.testing.assert_allclose(
            each.response.traction[closed], before, rtol=0, atol=1e-6 * np.abs(before).max()
        )


@pytest.mark.slow
@some_of(2, kind=KINDS, law=list(LAWS), way=[FREE, DRIVEN])
def test_action_is_reaction(kind: str, law: str, way: str) -> None:
    """The nodal forces' resultant is that on the body, and its moment that of the same tractions.

    The tractions act on the body at its points and on the soil where its points have moved to, with
    the same normal but apart by what slipped in the step.
    """
    simulation = pressed(kind, law, way)
    for step in range(3):
        result = simulation.advance(0.0625 * step, 0.0625 * (step + 1))
        (body,) = simulation.state.rigid_bodies.values()
        force = result.resultant("body")
        if kind == "axisymmetric":  # radial forces have no resultant
            force, other = force[1:], body.force[1:]
        else:
            other = body.force
        size = np.abs(result.forces["body"]).sum()
        assert size > 0.0
        np.testing.assert_allclose(force, -other, rtol=0, atol=1e-13 * size)
        if way == FREE:  # it balances what is declared
            moving = simulation.state.bodies[0]
            left = np.concatenate([body.force, moving.moment]) + moving._declared_load(moving.time)
            turn = left_jacobian(moving._increments[moving.dim :])
            left[moving.dim :] = turn.T @ left[moving.dim :]
            total = np.concatenate([moving.displacement, moving.turn])
            held = moving.springs * total[moving._axis]
            np.testing.assert_allclose(left[moving._axis], held, rtol=0, atol=1e-8 * size)


@pytest.mark.slow
@every_law
@pytest.mark.parametrize("way", [FREE, DRIVEN])
def test_forces_turn_with_soil_and_body(law: str, way: str) -> None:
    """By a quarter of a turn about the origin, with a shift by whole cells."""
    one = pressed("plane_strain", law, way)
    other = quarter_turn(one, (1.5, -2.0))
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    for step in range(2):
        for simulation in (one, other):
            simulation.advance(0.0625 * step, 0.0625 * (step + 1))
        (body,), (turned,) = one.state.rigid_bodies.values(), other.state.rigid_bodies.values()
        size = np.abs(body.force).max()
        assert size > 0.0
        np.testing.assert_allclose(turned.force, turn @ body.force, rtol=0, atol=1e-6 * size)
        np.testing.assert_allclose(turned.moment, body.moment, rtol=0, atol=1e-6 * size)
        moved = np.abs(body.displacement).max()
        expected = turn @ body.displacement
        np.testing.assert_allclose(turned.displacement, expected, rtol=0, atol=1e-6 * moved)
        np.testing.assert_allclose(turned.rotation, body.rotation, rtol=0, atol=1e-6 * moved)
