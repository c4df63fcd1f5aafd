# SPDX-License-Identifier: BSD-3-Clause
"""When a step tells its terms that a solution begins, and that the matrix was filled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from newton_problems import leaning_block, pressed_block

from tilth.algebra.unknowns import Unknowns
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_terms import TERMS
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.mpm.pattern import Elements
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Term
from tilth.terms.space import Space


class Listener(Term, DisplacementTerm):
    """A term without force that notes what it is told, and where: still or moved.

    Attributes:
        heard: names of calls, each with whether a node has moved.
        refuses: whether it has no force at the next displacement that is not 0.
    """

    label = "listener"

    def __init__(self) -> None:
        self.heard: list[tuple[str, bool]] = []
        self.refuses = False

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        return self

    def begin(self, x: Unknowns) -> None:
        assert x.globals.shape == (0,)
        self.heard.append(("begin", bool(x.u.any())))

    def force(self, displacement: Floats) -> Floats:
        self.heard.append(("force", bool(displacement.any())))
        if self.refuses and displacement.any():
            self.refuses = False
            raise StepFailed("no force there")
        return np.zeros_like(displacement)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        self.heard.append(("add_stiffness", bool(displacement.any())))

    def linearised(self) -> None:
        self.heard.append(("linearised", self.heard[-1][1]))


def pressed() -> Simulation:
    """A block whose top is prescribed to move."""
    return pressed_block("plane_strain", "gimp", "hencky_elastic")


def pulled() -> Simulation:
    """A block that loads move."""
    return leaning_block("plane_strain", "gimp", "hencky_elastic", 60.0)


STILL, MOVED = False, True
BEGUN = {
    moved: [("begin", moved), ("force", moved), ("add_stiffness", moved), ("linearised", moved)]
    for moved in (STILL, MOVED)
}
"""What is heard at first of a solution that begins there."""


def heard(simulation: Simulation, refuses: bool = False) -> list[list[tuple[str, bool]]]:
    """What is heard in each of two steps; refuses: in the second one at its first guess."""
    listener = Listener()
    simulation.setup = replace(simulation.setup, terms=[*TERMS, lambda _: [listener]])
    found = []
    for step in range(2):
        listener.heard = []
        listener.refuses = refuses and step == 1
        simulation.advance(0.5 * step, 0.5 * (step + 1))
        found.append(listener.heard)
    return found


def test_a_solution_begins_where_prescribed_nodes_have_yet_to_move() -> None:
    """Without and with a guess, which is evaluated after it."""
    first, second = heard(pressed())
    assert first[:4] == BEGUN[STILL]
    assert second[:5] == [*BEGUN[STILL][:2], *BEGUN[MOVED][1:]]
    for each in (first, second):
        assert [name for name, _ in each].count("begin") == 1


def test_a_solution_begins_at_the_guess_where_nothing_is_prescribed_to_move() -> None:
    first, second = heard(pulled())
    assert first[:4] == BEGUN[STILL]
    assert second[:4] == BEGUN[MOVED]


def test_a_guess_without_forces_is_no_beginning() -> None:
    _, second = heard(pulled(), refuses=True)
    assert second[:6] == [*BEGUN[MOVED][:2], *BEGUN[STILL]]


@pytest.mark.parametrize("make", [pressed, pulled])
def test_every_matrix_that_is_filled_is_told_of(make: Any) -> None:
    for each in heard(make()):
        names = [name for name, _ in each if name != "force"]
        assert names.count("add_stiffness") >= 2
        assert names[1:] == ["add_stiffness", "linearised"] * names.count("linearised")
