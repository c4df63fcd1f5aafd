# SPDX-License-Identifier: BSD-3-Clause
"""Terms change no state while they are evaluated and assembled: the same bits however often.

Of every kind of term in a balance, and of whole steps with evaluations elsewhere in between.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from body_contacts import simulation_of, two_blocks
from contact_terms import DRIVEN, FREE, next_balance, next_contact, pressed
from free_bodies import falling
from purity import assert_pure, assert_same, disturbed, state_after
from readings import some_of
from rigid_plate import E, column, plate_balance
from small_problems import KINDS, MATERIALS, Laboratory, block_entries
from test_edge_support import sand, support
from test_terms import loaded
from test_wave_boundaries import ground, side

from tilth import Model
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_terms import TERMS
from tilth.arrays import Floats
from tilth.model.load_curve import LoadCurve
from tilth.mpm.pattern import Elements
from tilth.terms.balance import Balance
from tilth.terms.drag import Drag
from tilth.terms.outcome import Outcome
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Term
from tilth.terms.released import Release, ReleasedForces
from tilth.terms.soil_forces import SoilForces
from tilth.terms.space import Space

every_kind = pytest.mark.parametrize("kind", KINDS)

SOME_LAWS = ["friction", "adhesion", "cut-off", "bonded", "held friction"]

SMALL: dict[str, Any] = {"width": 0.3, "depth": 0.2}
"""Of a block under a falling ball in space."""


def fall(kind: str, **more: Any) -> Simulation:
    """A ball with inertia above soil with both kinds of damping."""
    entries = falling(kind, **((SMALL if kind == "3d" else {}) | more))
    entries["analysis"]["inertia"]["damping"] = {"mass": 1.0, "stiffness": 1e-4}
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    return simulation


# single terms


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_terms_of_soil_held_and_loaded(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Soil, implicit boundaries, ghost, axis, loads on points and surfaces, water, weak springs."""
    assert_pure(next_balance(loaded(kind), 0.25, 0.5, monkeypatch), 2e-3)


@every_kind
@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
def test_soil(kind: str, material: str, anti_locking: str) -> None:
    """Of every law: elastic and plastic points."""
    (body,) = block_entries(kind, "gimp", material)["bodies"]
    random = np.random.default_rng(4)
    bodies = [body | {"anti_locking": anti_locking}]
    laboratory = Laboratory.of(kind, "gimp", material, random, bodies=bodies)
    for _ in range(2):
        laboratory.step(laboratory.random_displacement(random, 0.03))
    assert_pure(Balance(laboratory.active, [SoilForces(laboratory.soil)]), 0.02)
    yields = laboratory.soil.yielding_nodes().any()
    assert yields == ("elastic" not in material)


@some_of(2, kind=KINDS, law=["friction", "adhesion"], way=[FREE, DRIVEN])
def test_contact(kind: str, law: str, way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where it holds a free body by a single multiplier."""
    simulation = pressed(kind, law, way)
    simulation.advance(0.0, 0.25)
    for size, lifted in ((0.1, 0.0), (1e-3, -0.2))[: 2 if way == FREE else 1]:
        balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
        assert_pure(balance, size, lifted)
        assert term._at.holds_one == (lifted < 0.0)


@every_kind
@pytest.mark.parametrize("law", ["friction", "adhesion"])
def test_contact_of_bodies(kind: str, law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = simulation_of(two_blocks(kind, law))
    simulation.advance(0.0, 0.25)
    assert_pure(next_balance(simulation, 0.25, 0.5, monkeypatch), 1e-4)


@every_kind
def test_inertia_and_damping(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of soil and a body that falls on it."""
    simulation = fall(kind)
    simulation.advance(0.0, 0.01)
    assert_pure(next_balance(simulation, 0.01, 0.02, monkeypatch), 1e-4)


@every_kind
@pytest.mark.parametrize("turned", [False, True])
def test_dashpots(kind: str, turned: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = ground(kind, [side(kind, turned)])
    simulation.advance(0.0, 0.005)
    assert_pure(next_balance(simulation, 0.005, 0.012, monkeypatch), 1e-3)


@every_kind
def test_edge_support_drag_and_released_forces(kind: str) -> None:
    simulation, active = sand(kind)
    soil = simulation.soil_on(active)
    drag = replace(Drag.of(soil), stiffness=np.ones(active.nodes), size=0.5)
    released = ReleasedForces(active.grid.dim, LoadCurve(((0.0, 0.0), (1.0, 1.0))))
    released.set(active, np.ones_like(active.position))
    terms = [support(simulation, active), drag, Release(released, active, 0.0, 0.5)]
    assert_pure(Balance(active, terms), 1e-3)


def test_a_plate_with_an_unknown_of_its_own() -> None:
    assert_pure(plate_balance(column("plane_strain"), E, 0.5, 10.0), 0.01)


# whole steps


def assert_undisturbed(
    make: Callable[[], Simulation], times: list[float], size: float, skipped: int = 0
) -> None:
    """Steps have the same bits as with evaluations elsewhere.

    skipped: number of the first attempts at a step that fail in their first iteration.
    """
    found = []
    for number in range(2):
        simulation = make()
        attempts = [
            replace(each, maximum_iterations=1) if i < skipped else each
            for i, each in enumerate(simulation.setup.attempts)
        ]
        simulation.setup = replace(simulation.setup, attempts=attempts)
        if number == 0:
            found.append(state_after(simulation, times))
            continue
        with disturbed(size) as count:
            found.append(state_after(simulation, times))
        assert count[0] > len(times)
    assert_same(*found)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_steps_of_soil_held_and_loaded(kind: str) -> None:
    assert_undisturbed(lambda: loaded(kind), [0.25, 0.5, 0.75], 2e-3)


@pytest.mark.slow
@some_of(1, kind=KINDS, law=SOME_LAWS, way=[FREE, DRIVEN], skipped=[0, 2, 3])
def test_steps_of_contact(kind: str, law: str, way: str, skipped: int) -> None:
    """In usual, careful and single attempts; far enough away that everything opens and closes."""
    assert_undisturbed(lambda: pressed(kind, law, way), [0.0, 0.25, 0.5], 0.05, skipped)


@pytest.mark.slow
@some_of(1, kind=KINDS, law=SOME_LAWS, skipped=[0, 2, 3])
def test_steps_of_contact_of_bodies(kind: str, law: str, skipped: int) -> None:
    assert_undisturbed(lambda: simulation_of(two_blocks(kind, law)), [0.0, 0.25], 0.02, skipped)


@pytest.mark.slow
@some_of(1, kind=["3d", "axisymmetric", "plane_strain"], skipped=[0, 2, 3])
def test_steps_of_a_falling_body(kind: str, skipped: int) -> None:
    """Until after its impact."""
    times = np.linspace(0.0, 0.02, 5).tolist()
    assert_undisturbed(lambda: fall(kind), times, 0.01, skipped)


@every_kind
def test_steps_of_waves(kind: str) -> None:
    assert_undisturbed(lambda: ground(kind, [side(kind, True)]), [0.0, 0.005, 0.01], 1e-3)


# terms that do change


class Ratchet(Term, DisplacementTerm):
    """Springs on all nodes, stiffer each time after one of its methods was called."""

    label = "ratchet"

    def __init__(self, method: str) -> None:
        self._stiffness = 1.0
        call = getattr(self, method)

        def turned(*arguments: Any) -> Any:
            found = call(*arguments)
            self._stiffness *= 1.0 + 1e-12  # little enough for Newton's iteration
            return found

        setattr(self, method, turned)

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        self._diagonal = space.active.diagonal
        return self

    def force(self, displacement: Floats) -> Floats:
        return self._stiffness * displacement

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        for k in range(displacement.shape[1]):
            blocks[self._diagonal, k, k] += self._stiffness

    def outcome(self, x: Unknowns) -> Outcome | None:
        return None


def ratcheted(method: str) -> Simulation:
    """The block of soil under loads with such springs."""
    simulation = loaded("plane_strain")
    terms = [*TERMS, lambda _: [Ratchet(method)]]
    simulation.setup = replace(simulation.setup, terms=terms)
    return simulation


ASKED = ["force", "add_stiffness", "magnitude", "outcome", "check", "constant_force"]


@pytest.mark.parametrize("method", ASKED)
def test_a_term_that_changes_while_it_is_asked_is_found(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    balance = next_balance(ratcheted(method), 0.25, 0.5, monkeypatch)
    with pytest.raises(AssertionError):
        assert_pure(balance, 2e-3)


@pytest.mark.parametrize("method", ["begin", "linearised", "adapt", "revise", "refine", "commit"])
def test_a_term_may_change_where_it_is_told_to(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert_pure(next_balance(ratcheted(method), 0.25, 0.5, monkeypatch), 2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("method", ASKED)
def test_it_is_found_in_whole_steps(method: str) -> None:
    with pytest.raises(AssertionError):
        assert_undisturbed(lambda: ratcheted(method), [0.25, 0.5], 2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["begin", "linearised"])
def test_what_may_change_is_the_same_in_whole_steps(method: str) -> None:
    assert_undisturbed(lambda: ratcheted(method), [0.25, 0.5], 2e-3)
