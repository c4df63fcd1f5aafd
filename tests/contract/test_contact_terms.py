# SPDX-License-Identifier: BSD-3-Clause
"""The term of contact: derivatives by displacement and global unknowns, units, motion, reaction."""

from __future__ import annotations

import numpy as np
import pytest
from contact_terms import (
    DRIVEN,
    FREE,
    LAWS,
    branches,
    linearised,
    next_contact,
    pressed,
    product,
)
from small_problems import KINDS

from tilth.arrays import Floats
from tilth.boundaries.contact.forces import AssembledContact
from tilth.boundaries.contact.rotation import rotation_by
from tilth.terms.balance import Balance

every_kind = pytest.mark.parametrize("kind", KINDS)
every_law = pytest.mark.parametrize("law", LAWS)

SIZES = {"tiny": (1e-9, 1e-9), "small": (1e-5, 1e-5), "large": (2e-3, 0.02), "turned": (2e-3, 0.6)}
"""Random displacements of the nodes, and of the body beyond the motion that it has them follow."""


def case(
    kind: str, law: str, size: str, monkeypatch: pytest.MonkeyPatch
) -> tuple[Balance, AssembledContact, Floats, Floats]:
    """Balance and term of the second step of a free body, and a state that it may come to."""
    simulation = pressed(kind, law)
    simulation.advance(0.0, 0.25)
    balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    random = np.random.default_rng([11, sorted(LAWS).index(law), sorted(SIZES).index(size)])
    nodes, body = SIZES[size]
    u = nodes * random.normal(size=(balance.active.nodes, balance.active.grid.dim))
    g = body * random.normal(size=len(term.scale))
    return balance, term, u, g


@every_kind
@every_law
@pytest.mark.parametrize("size", SIZES)
def test_derivatives(kind: str, law: str, size: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of nodal forces and of the body's equations, by nodal displacement and the body's motion."""
    balance, term, u, g = case(kind, law, size, monkeypatch)
    blocks = linearised(term, balance, u, g)
    border = term.border(u, g)
    random = np.random.default_rng(3)
    way, turn = random.normal(size=u.shape), random.normal(size=len(g))
    by_nodes = product(balance, blocks, way), np.einsum("mni,ni->m", border.rows, way)
    by_body = np.einsum("mni,m->ni", border.columns, turn), border.corner @ turn
    step = 1e-7 * min(1.0, SIZES[size][0] / 1e-5)
    for (forces, own), one, other in ((by_nodes, way, 0.0 * turn), (by_body, 0.0 * way, turn)):
        ahead = term.forces(u + step * one, g + step * other)
        states = branches(term)
        behind = term.forces(u - step * one, g - step * other)
        assert states == branches(term), "no branch changes between both"
        for found, a, b in ((forces, ahead[0], behind[0]), (own, ahead[1], behind[1])):
            difference = (a - b) / (2.0 * step)
            largest = np.abs(difference).max(initial=0.0)
            round_off = 1e-14 * np.abs(a).max(initial=0.0) / step
            np.testing.assert_allclose(
                found, difference, rtol=0, atol=2e-6 * largest + round_off + 1e-12
            )


EXPECTED = {
    "smooth": {"open", "slip"}, "friction": {"open", "slip", "stick"},
    "limited": {"open", "slip", "stick"}, "adhesion": {"open", "slip", "stick"},
    "rough": {"open", "slip", "stick"}, "bonded": {"open", "slip", "stick"},
    "cut-off": {"open", "slip", "stick"}, "held friction": {"slip", "stick"},
    "held adhesion": {"slip", "stick"}, "held smooth": {"slip"}, "glued": {"stick"},
}  # fmt: skip


@every_kind
@every_law
def test_the_states_have_all_branches(
    kind: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The derivatives above are those of each branch of each law."""
    seen = set()
    for size in SIZES:
        balance, term, u, g = case(kind, law, size, monkeypatch)
        linearised(term, balance, u, g)
        seen |= branches(term)
    assert seen == EXPECTED[law]


@every_kind
@every_law
def test_results_do_not_depend_on_the_units(
    kind: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lengths a thousand times and stresses seven times as large in their numbers."""
    length, stress = 1000.0, 7.0
    found = []
    for units in ((1.0, 1.0), (length, stress)):
        simulation = pressed(kind, law, FREE, *units)
        simulation.advance(0.0, 0.25)
        found.append(next_contact(simulation, 0.25, 0.5, monkeypatch))
    (one, term), (other, scaled) = found
    force = stress * length ** (1 if kind == "plane_strain" else 2)
    random = np.random.default_rng(5)
    u = 1e-4 * random.normal(size=(one.active.nodes, one.active.grid.dim))
    unit = np.where(term.scale == 1.0, length, 1.0)  # of a translation, of an angle
    g = 1e-4 * random.normal(size=len(term.scale))
    nodal, own = term.forces(u, g)
    in_units = scaled.forces(length * u, unit * g)
    size = np.abs(nodal).max()
    np.testing.assert_allclose(in_units[0] / force, nodal, rtol=0, atol=1e-7 * size)
    expected = own * np.where(term.scale == 1.0, 1.0, length)
    np.testing.assert_allclose(
        in_units[1] / force, expected, rtol=0, atol=1e-7 * np.abs(expected).max()
    )
    assert other.active.nodes == one.active.nodes


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
    term.forces(u, np.concatenate([shift, turn]))
    for support, _, each in term._each():
        assert (support.active == support.part.touch.closed).all()
        taking_part = support.area > 0.0
        assert taking_part.any()
        np.testing.assert_allclose(each.slip[taking_part], 0.0, rtol=0, atol=1e-14)
        closed = taking_part & each.response.closed
        before = support.before[closed]
        np.testing.assert_allclose(
            each.response.traction[closed], before, rtol=0, atol=1e-6 * np.abs(before).max()
        )


@every_kind
@every_law
@pytest.mark.parametrize("way", [FREE, DRIVEN])
def test_action_is_reaction(kind: str, law: str, way: str) -> None:
    """The nodal forces' resultant is that on the body, and its moment that of the same tractions.

    The tractions act on the body at its points and on the soil where its points have moved to, with
    the same normal but apart by what slipped in the step.
    """
    simulation = pressed(kind, law, way)
    for step in range(3):
        result = simulation.advance(0.25 * step, 0.25 * (step + 1))
        (body,) = simulation.rigid_bodies.values()
        force = result.resultant("body")
        if kind == "axisymmetric":  # radial forces have no resultant
            force, other = force[1:], body.force[1:]
        else:
            other = body.force
        size = np.abs(result.forces["body"]).sum()
        assert size > 0.0
        np.testing.assert_allclose(force, -other, rtol=0, atol=1e-13 * size)
        # of free bodies: it balances what is declared
        if way == FREE:
            moving = simulation.bodies[0]
            applied = moving.applied(np.zeros(len(moving._increments)), moving.time)
            soil = np.concatenate([body.force, moving.moment])[moving._axis[moving.free]]
            np.testing.assert_allclose(soil, -applied, rtol=0, atol=1e-8 * size)
