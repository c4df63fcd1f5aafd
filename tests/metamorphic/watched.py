# SPDX-License-Identifier: BSD-3-Clause
"""The balance of each step as it was committed: what the aids of the solution bear in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

import tilth.analysis.step_terms as step_terms
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.terms.balance import Balance
from tilth.terms.inertia import AssembledInertia
from tilth.terms.protocol import AssembledTerm, Role

SPRINGS = -1
"""Place of the weak springs in `terms_of`."""


class WatchedBalance(Balance):
    """A balance that keeps the forces of the last committed step.

    Attributes:
        aids: force of stabilisations and weak springs on the soil [force], (nodes, dim).
        spring_work: work of the soil on weak springs in the step [force length].
        kinetic_change: of the grid in the step, without that of the ghost mass, which is stated
            as an energy of the stabilisation [force length].
        size: largest norm of the forces of soil and boundaries [force].
    """

    aids: Floats
    spring_work: float
    kinetic_change: float
    size: float

    def commit(self, x: Unknowns, checked: Sequence[Any]) -> None:
        """As `Balance.commit`."""
        global _last
        displacement = x.u

        def force(term: AssembledTerm, of: Floats) -> Floats:
            return term.evaluate(self.at(of)).u

        springs = self.terms[SPRINGS]
        aids = [springs, *(term for term in self.terms if term.role is Role.STABILISATION)]
        self.aids = -sum(force(term, displacement) for term in aids)  # type: ignore[assignment]
        mean = force(springs, np.zeros_like(displacement)) + force(springs, displacement)
        self.spring_work = 0.5 * float(np.sum(mean * displacement))
        inertia = [term for term in self.terms if isinstance(term, AssembledInertia)]
        change = [t.kinetic_change(displacement) - t.ghost_energy(displacement) for t in inertia]
        self.kinetic_change = sum(change)
        soil = [np.linalg.norm(force(term, displacement)) for term in self.terms[:2]]
        self.size = float(max(soil))
        _last = self
        super().commit(x, checked)


_last: WatchedBalance | None = None


def last_balance() -> WatchedBalance:
    """The balance of the step that was committed last."""
    assert _last is not None
    return _last


@contextmanager
def watched() -> Iterator[None]:
    """Runs within it keep the balance of their last step."""
    original = step_terms.Balance
    step_terms.Balance = WatchedBalance  # type: ignore[misc]
    try:
        yield
    finally:
        step_terms.Balance = original  # type: ignore[misc]
