# SPDX-License-Identifier: BSD-3-Clause
"""Contact between two soil bodies: derivatives, balance of forces, both ways round, sliding."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from body_contacts import CELL, STRENGTH, simulation_of, two_blocks
from contact_terms import LAWS, branches_compared, next_contact
from small_problems import KINDS

from tilth.analysis.simulation import Simulation
from tilth.boundaries.contact.between_bodies import (
    BodyContact,
    motions_of_bodies,
    require_short_motion,
)
from tilth.comm import SERIAL
from tilth.errors import StepFailed

every_kind = pytest.mark.parametrize("kind", KINDS)
every_law = pytest.mark.parametrize("law", LAWS)

ONLY = {
    "smooth": {"open", "slip"}, "held smooth": {"slip"}, "glued": {"stick"},
    "held friction": {"slip", "stick"}, "held adhesion": {"slip", "stick"},
}  # fmt: skip
"""Branches of the laws that have not all three."""


@pytest.mark.slow
@every_kind
@every_law
@pytest.mark.parametrize("basis", ["gimp", "cpdi2"])
def test_derivatives(kind: str, law: str, basis: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the nodal forces on both bodies, in each branch of each law."""
    if kind == "3d" and basis == "cpdi2":
        pytest.skip("the trace is that of the plane with one more direction")
    simulation = simulation_of(two_blocks(kind, law, basis))
    simulation.advance(0.0, 0.25)
    balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    assert branches_compared(balance, term) == ONLY.get(law, {"open", "slip", "stick"})


@pytest.mark.slow
@every_kind
@every_law
def test_forces_on_both_bodies_are_opposite(
    kind: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their sum vanishes for any displacement; the results have that on the second body."""
    simulation = simulation_of(two_blocks(kind, law))
    result = simulation.advance(0.0, 0.25)
    on_second = result.resultant("pair")
    size = np.abs(result.forces["pair"]).sum()
    up = -1
    np.testing.assert_allclose(on_second[up], -result.resultant("base")[up], atol=1e-9 * size)
    assert on_second[up] < 0.0
    balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    random = np.random.default_rng(7)
    totals = []
    for size in (1e-9, 1e-6, 1e-4):
        u = size * random.normal(size=(balance.active.nodes, balance.active.grid.dim))
        nodal, _ = term.forces(u, np.zeros(0))
        totals.append(np.abs(nodal).sum())
        net = nodal.sum(axis=0)
        if kind == "axisymmetric":  # radial forces have no resultant
            net = net[1:]
        np.testing.assert_allclose(net, 0.0, rtol=0, atol=1e-13 * totals[-1])
    assert totals[0] > 0.0


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@every_law
def test_bodies_that_move_together_do_not_slip(
    kind: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = simulation_of(two_blocks(kind, law))
    simulation.advance(0.0, 0.25)
    balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    shift = np.array([0.1, -0.2, 0.05])[: balance.active.grid.dim]
    u = np.tile(shift, (balance.active.nodes, 1))
    for patch in term._patches:
        patch.gap[:] = 0.0
    term.forces(u, np.zeros(0))
    for patch, _, each in term._each():
        assert isinstance(patch.part, BodyContact)
        taking_part = patch.area > 0.0
        assert taking_part.any()
        np.testing.assert_allclose(each.slip[taking_part], 0.0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("basis", ["gimp", "cpdi2"])
@pytest.mark.parametrize("shift", [0.0, 0.13])
def test_uniform_pressure(basis: str, shift: float) -> None:
    """Two blocks of one width pressed between smooth plates: p = E' |ln(1 - d/H)| / (1 - nu^2).

    The Hencky stress of the force per initial width, with E/(1 - nu^2) of both blocks.
    """
    young, d = 1000.0, 0.016
    entries = two_blocks("plane_strain", "smooth", basis)
    boundaries = [dict(each) for each in entries["boundaries"]]
    for each in boundaries:
        each["condition"] = "roller"
    boundaries[1]["displacement"] = {"y": -d}
    side = {
        "name": "side", "type": "implicit", "condition": "roller",
        "geometry": {"type": "plane", "point": [0.0, 0.0], "normal": [1.0, 0.0]},
    }  # fmt: skip
    bodies = [dict(each) for each in entries["bodies"]]
    bodies[0]["shape"] = {"type": "box", "lower": [0.0, 0.8], "upper": [1.5, 1.6]}
    bodies[1]["shape"] = {"type": "box", "lower": [0.0, 0.0], "upper": [1.5, 0.8]}
    law = {"model": "hencky_elastic", "young_modulus": young, "poisson_ratio": 0.3}
    entries |= {
        "bodies": bodies, "boundaries": [*boundaries, side], "materials": dict.fromkeys(
            ("top", "ground"), law
        ), "grid": {"cell_size": 0.25, "origin": [-shift, -0.7 * shift]},
    }  # fmt: skip
    simulation = simulation_of(entries)
    for step in range(4):
        result = simulation.advance(0.25 * step, 0.25 * (step + 1))
    state = result.contacts["pair"]
    strain = np.log(1.0 - d / 1.6)
    stress = young / (1.0 - 0.3**2) * strain  # Kirchhoff, in the plane without sideways stress
    wide = np.exp(-0.3 / (1.0 - 0.3) * strain)
    expected = stress / (np.exp(strain) * wide)  # Cauchy
    pressure = state.normal_stress[state.in_contact]
    np.testing.assert_allclose(pressure, expected, rtol=5e-3)
    mean = float(state.weight[state.in_contact] @ pressure / state.area)
    assert mean == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("law", ["friction", "adhesion"])
def test_the_bodies_can_be_exchanged(law: str) -> None:
    """The contact is integrated on one surface or on the other: forces within 0.5 %."""
    forces = []
    for names in (["top", "ground"], ["ground", "top"]):
        entries = two_blocks("plane_strain", law)
        entries["bodies"] = [{**body, "surface": {}} for body in entries["bodies"]]
        entries["contact_pairs"] = [{"name": "pair", "bodies": names, "contact": LAWS[law]}]
        simulation = simulation_of(entries)
        for step in range(4):
            result = simulation.advance(0.25 * step, 0.25 * (step + 1))
        forces.append(result.resultant("base"))
    size = float(np.linalg.norm(forces[0]))
    np.testing.assert_allclose(forces[0], forces[1], rtol=0, atol=5e-3 * size)


def test_a_lifted_block_comes_off() -> None:
    entries: dict[str, Any] = two_blocks("plane_strain", "friction")
    entries["boundaries"][1]["displacement"] = {"y": 1.0}
    entries["boundaries"][1]["factor"] = [[0, 0], [0.5, -0.01], [1, 0.05]]
    simulation = simulation_of(entries)
    for step in range(4):
        result = simulation.advance(0.25 * step, 0.25 * (step + 1))
        if step == 1:
            assert result.contacts["pair"].area == pytest.approx(1.2, rel=0.01)
    assert result.contacts["pair"].area == 0.0
    assert np.abs(result.resultant("base")).max() < 1e-8 * STRENGTH
    assert result.contacts["pair"].gap.min() > 0.0


def test_a_long_way_in_one_step_is_refused() -> None:
    """Bodies near each other must not jump past each other."""
    entries = two_blocks("plane_strain", "smooth")
    simulation = simulation_of(entries)
    simulation.advance(0.0, 0.01)
    points = simulation.state.points
    moved = np.zeros_like(points.position)
    moved[points.of_body("top"), 0] = 0.9 * CELL
    _require_short_motion(simulation, moved)
    moved[points.of_body("top"), 0] = 1.1 * CELL
    with pytest.raises(StepFailed, match=r"1\.1 cells relative to each other") as failure:
        _require_short_motion(simulation, moved)
    assert failure.value.share == pytest.approx(0.9 / 1.1)
    _require_short_motion(simulation, np.full_like(moved, 5.0 * CELL))


def _require_short_motion(simulation: Simulation, moved: np.ndarray) -> None:
    pairs = simulation.state.body_contacts
    require_short_motion(pairs, motions_of_bodies(pairs, simulation.state.points, moved, SERIAL))
