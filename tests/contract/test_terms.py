# SPDX-License-Identifier: BSD-3-Clause
"""Every term of the balance: its derivative, its place in the sum, that it leaves the others."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from balances import blocks_at, residual_at
from contact_terms import next_balance
from implicit_blocks import flat, implicit
from small_problems import material_entries

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.active_grid import Buffers, locate
from tilth.terms.balance import Balance
from tilth.terms.linear import AssembledLinearForces
from tilth.terms.protocol import AssembledTerm, Role

KINDS = ["plane_strain", "axisymmetric"]
TERMS = ["soil", "boundaries", "ghost", "axis", "point loads", "surface loads", "water loads"]
TERMS += ["weak springs"]
"""In the order of `terms_of`."""
ABSENT = {"plane_strain": {"axis"}, "axisymmetric": set[str]()}


def loaded(kind: str, gamma: float = 0.005, length: float = 1.0, stress: float = 1.0) -> Simulation:
    """A block with every term after its first step: cells of 0.5, slivers at its top.

    It stands on a moving boundary between grid lines, next to the axis of symmetry between two.
    With ghost stabilisation (`gamma`) there are no weak springs. `length` and `stress` are units:
    how often the ones of the numbers below go into them.
    """
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.03], [0.0, 2.03]])
    square = {"type": "polygon", "vertices": (length * corners).tolist()}
    base = implicit(
        "base", flat([0.0, 0.12 * length], [-0.1, 1.0]), "fixed",
        displacement={"y": 0.04 * length},
    )  # fmt: skip
    soil = material_entries("von_mises")
    soil["saturated_density"] = 1.5 * soil["density"]
    level = np.array([[-1.0, 1.1], [0.9, 1.3], [4.0, 0.9]])  # cuts the domains of points
    for parameter in ("young_modulus", "yield_stress", "hardening_modulus"):
        soil[parameter] *= stress
    axisymmetric = kind == "axisymmetric"
    force = stress * length ** (2 if axisymmetric else 1)
    wall = implicit("wall", flat([0.0, 0.0], [1.0, 0.0]), "roller")
    entries: dict[str, Any] = {
        "analysis": {"kind": kind, "ghost_stabilisation": gamma, "tolerance": 1e-12},
        "grid": {"cell_size": 0.5 * length, "origin": [-0.2 * length, 0.0]},
        "materials": {"soil": soil},
        "bodies": [
            {"name": "block", "material": "soil", "shape": square, "basis": "gimp",
             "spacing": 0.125 * length, "surface": {}}
        ],
        "boundaries": [base] if axisymmetric else [base, wall],
        "loads": [
            {"type": "body_force", "acceleration": [0.0, -0.02 * stress / length]},
            {"type": "surface", "body": "block", "pressure": 0.05 * stress,
             "start": [2.0 * length, 2.03 * length], "end": [0.0, 2.03 * length]},
            {"type": "seismic", "coefficient": [0.0 if axisymmetric else 0.3, -0.1],
             "factor": [[0.0, 1.0], [1.0, 1.0]]},
            {"type": "point_force", "body": "block", "at": [1.1 * length, 2.03 * length],
             "force": [0.002 * force, -0.005 * force]},
        ],
        "water": {"level": (length * level).tolist(), "unit_weight": 0.03 * stress / length,
                  "factor": [[0.0, 0.0], [1.0, 1.0]]},
        "schedule": {"steps": 4},
    }  # fmt: skip
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    simulation.advance(0.0, 0.25)
    return simulation


def balance_of(kind: str, monkeypatch: pytest.MonkeyPatch, *options: float) -> Balance:
    """The balance of the second step of that block."""
    return next_balance(loaded(kind, *options), 0.25, 0.5, monkeypatch)


def bedded() -> Balance:
    """The balance of the how-to's block on Winkler springs, at the start of its first step."""
    page = Path(__file__).parents[2] / "docs" / "howto" / "add_a_term.md"
    names: dict[str, Any] = {"__name__": "documented"}
    for block in re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL):
        exec(compile(block, str(page), "exec"), names)
    simulation = names["block"](-0.05)
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    return Balance(active, [names["WinklerBed"](simulation.soil_on(active), 2e5, 0.0)])


def test_a_term_of_ones_own_is_held_to_the_same() -> None:
    """Springs of the how-to press, do not pull, and have the stiffness of their force."""
    balance = bedded()
    (bed,) = balance.terms
    u, direction = displacements(balance)
    pressed, lifted = (np.full_like(u, way) for way in (-0.01, 0.01))
    assert bed.force(pressed).sum(axis=0) == pytest.approx([0.0, -0.01 * 2e5 * 2.0], rel=1e-12)
    assert not bed.force(lifted).any()
    assert not product(bed, balance, lifted, direction).any()
    step = 1e-6
    found = product(bed, balance, u, direction)
    ahead, behind = (bed.force(u + sign * step * direction) for sign in (1.0, -1.0))
    difference = (ahead - behind) / (2.0 * step)
    assert 0 < np.count_nonzero(difference) < difference.size
    np.testing.assert_allclose(found, difference, rtol=0, atol=1e-6 * np.abs(difference).max())


def displacements(balance: Balance) -> tuple[Floats, Floats]:
    """A displacement of the step, and a direction."""
    random = np.random.default_rng(7)
    shape = (balance.active.nodes, balance.active.grid.dim)
    return 2e-3 * random.normal(size=shape), random.normal(size=shape)


def product(term: AssembledTerm, balance: Balance, u: Floats, direction: Floats) -> Floats:
    """The term's stiffness times a direction; the blocks hold something else before."""
    active = balance.active
    dim = active.grid.dim
    before = np.random.default_rng(8).normal(size=(len(active.column), dim, dim))
    blocks = before.copy()
    term.force(u)
    term.add_stiffness(u, blocks)
    rows = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    found = np.zeros_like(u)
    np.add.at(found, rows, np.einsum("nij,nj->ni", blocks - before, direction[active.column]))
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_every_term_has_a_label_of_its_own(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    labels = [term.label for term in balance_of(kind, monkeypatch).terms]
    assert all(labels)
    assert len(set(labels)) == len(labels)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", TERMS)
def test_stiffness_is_the_derivative_of_the_force(
    kind: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    balance = balance_of(kind, monkeypatch, 0.0 if name == "weak springs" else 0.005)
    assert len(balance.terms) == len(TERMS)
    term = balance.terms[TERMS.index(name)]
    u, direction = displacements(balance)
    assert term.force(u).any() == (name not in ABSENT[kind]), "the problem has every term"
    step = 1e-6
    ahead, behind = (term.force(u + sign * step * direction) for sign in (1.0, -1.0))
    difference = (ahead - behind) / (2.0 * step)
    found = product(term, balance, u, direction)
    size = np.abs(difference).max()
    # springs have a shift in the matrix alone, a thousandth of them
    share = 3e-3 if name == "weak springs" else 1e-6
    round_off = 1e-15 * np.abs(term.force(u)).max() / step + 1e-14  # of the blocks' other content
    if name == "weak springs":
        round_off = 1e-9
    np.testing.assert_allclose(found, difference, rtol=0, atol=share * size + 10.0 * round_off)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", TERMS)
def test_results_do_not_depend_on_the_units(
    kind: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lengths a thousand times and stresses seven times as large in their numbers."""
    length, stress = 1000.0, 7.0
    gamma = 0.0 if name == "weak springs" else 0.005
    one = balance_of(kind, monkeypatch, gamma)
    other = balance_of(kind, monkeypatch, gamma, length, stress)
    u, direction = displacements(one)
    stiffness = stress * (length if kind == "axisymmetric" else 1.0)  # force per length
    term, scaled = (balance.terms[TERMS.index(name)] for balance in (one, other))
    for found, expected in (
        (scaled.force(length * u), stiffness * length * term.force(u)),
        (product(scaled, other, length * u, direction),
         stiffness * product(term, one, u, direction)),
    ):  # fmt: skip
        size = np.abs(expected).max()
        assert name in ABSENT[kind] or size > 0.0 or "loads" in name
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * size + 1e-11 * stiffness)


def test_a_weak_spring_is_that_of_the_ring(monkeypatch: pytest.MonkeyPatch) -> None:
    """In axisymmetry 2 pi r times that of a plane, with r no less than half a cell."""
    plane, ring = (balance_of(kind, monkeypatch, 0.0) for kind in KINDS)
    number = TERMS.index("weak springs")
    found = []
    for balance in (plane, ring):
        ones = np.ones((balance.active.nodes, 2))
        found.append(balance.terms[number].force(ones)[:, 1])
    assert np.array_equal(plane.active.key, ring.active.key)
    radius = np.maximum(np.abs(plane.active.position[:, 0]), 0.25)
    both = (found[0] > 0.0) & (found[1] > 0.0)
    assert both.sum() > 2
    ratio = found[1][both] / found[0][both]
    np.testing.assert_allclose(ratio, 2.0 * np.pi * radius[both], rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_balance_is_the_sum_of_its_terms(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    balance = balance_of(kind, monkeypatch)
    u, direction = displacements(balance)
    forces = residual_at(balance, u)
    parts = {name: term.force(u) for name, term in zip(TERMS, balance.terms, strict=True)}
    scale = np.abs(forces.sum_of(Role.SOIL)).max()
    np.testing.assert_allclose(sum(parts.values()), forces.u, rtol=0, atol=1e-13 * scale)
    np.testing.assert_array_equal(forces.sum_of(Role.SOIL), parts["soil"])
    of_loads = -sum(part for name, part in parts.items() if name.endswith("loads"))
    np.testing.assert_allclose(forces.load, of_loads, rtol=0, atol=1e-15 * scale)
    whole = sum(product(term, balance, u, direction) for term in balance.terms)
    residual_at(balance, u)
    blocks = blocks_at(balance, u)
    rows = np.repeat(np.arange(balance.active.nodes), np.diff(balance.active.row_start))
    found = np.zeros_like(u)
    np.add.at(found, rows, np.einsum("nij,nj->ni", blocks, direction[balance.active.column]))
    np.testing.assert_allclose(found, whole, rtol=0, atol=1e-11 * np.abs(found).max())


@pytest.mark.parametrize("kind", KINDS)
def test_terms_say_what_they_are(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    balance = balance_of(kind, monkeypatch)
    u, _ = displacements(balance)
    for name, term in zip(TERMS, balance.terms, strict=True):
        before = term.load_before()
        assert (term.role is Role.SOIL) == (name == "soil")
        assert (term.role is Role.LOAD) == (before is not None) == name.endswith("loads"), name
        if before is not None:  # of half the load, on the same places
            at_rest = -term.force(np.zeros_like(u))
            np.testing.assert_allclose(2.0 * before, at_rest, rtol=1e-12, atol=1e-15)
        if isinstance(term, AssembledLinearForces):
            constant = term.constant_force()
            assert np.array_equal(term.force(np.zeros_like(u)), constant)
            assert (term.magnitude(balance.at(u))["u"] >= np.abs(constant)).all()
    joined = balance.terms[TERMS.index("boundaries")].joined_nodes()
    assert joined is not None
    assert joined.any()


def test_a_pattern_without_a_terms_nodes_is_another_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    """What terms couple makes a new grid: the one that they were gathered on is not changed."""
    active = balance_of("plane_strain", monkeypatch).active
    alone = active.with_couplings([])
    assert len(active.elements) > 0
    assert alone.elements == []
    assert len(alone.column) < len(active.column)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", TERMS)
def test_a_restored_term_has_the_same_force(
    kind: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the bit; without its state a term with a memory has another one."""
    if name in ABSENT[kind]:
        pytest.skip(f"no {name} in {kind}")
    simulation = loaded(kind)
    stored = {key: array.copy() for key, array in simulation.state.arrays().items()}
    restored = Simulation.restored(simulation.setup.model, stored)
    forgetful = Simulation(simulation.setup.model, restored.state.points)
    number = TERMS.index(name)
    balances = [next_balance(each, 0.25, 0.5, monkeypatch) for each in (simulation, restored)]
    u, _ = displacements(balances[0])
    force, again = (balance.terms[number].force(u) for balance in balances)
    np.testing.assert_array_equal(again, force)
    if name in ("boundaries", "ghost", "axis"):
        still = np.zeros_like(u)
        other = next_balance(forgetful, 0.25, 0.5, monkeypatch).terms[number].force(still)
        force = balances[0].terms[number].force(still)
        assert np.abs(other - force).max() > 1e-8 * np.abs(force).max()
