# SPDX-License-Identifier: BSD-3-Clause
"""The balance of a load step: the sum of all its terms."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.comm import SERIAL, norm
from tilth.mpm.grid import ActiveGrid
from tilth.terms.protocol import Role, Term, union


@dataclass(frozen=True)
class Forces:
    """Nodal forces at one displacement [force], shape (nodes, dim) each.

    Attributes:
        residual: internal minus external force of all terms.
        load: external force.
        soil: internal force of the soil.
    """

    residual: Floats
    load: Floats
    soil: Floats


class Balance:
    """The sum of all terms of a step, in the order in which they are given.

    Attributes:
        active: the grid of the step, with the pattern of all terms.
        terms: the assembled terms.
        load_before: external force at the start of the step [force], shape (nodes, dim).
    """

    def __init__(self, active: ActiveGrid, terms: Sequence[Term]) -> None:
        coupled = [list(term.coupled) for term in terms]
        self.active = active.with_couplings([each for of_term in coupled for each in of_term])
        elements = iter(self.active.elements)
        self.terms = [
            term.assembled(self.active, [next(elements) for _ in of_term])
            for term, of_term in zip(terms, coupled, strict=True)
        ]
        self.load_before = self._sum(term.load_before() for term in self.terms)

    def _zero(self) -> Floats:
        return np.zeros((self.active.nodes, self.active.grid.dim))

    def _sum(self, forces: Iterable[Floats | None]) -> Floats:
        total = self._zero()
        for force in forces:
            if force is not None:
                total += force
        return total

    def constant_force(self) -> Floats:
        """Returns the force of all linear terms at zero displacement [force], (nodes, dim)."""
        return self._sum(term.constant_force() for term in self.terms)

    def forces(self, displacement: Floats) -> Forces:
        """Returns the nodal forces for a nodal displacement of the step, shape (nodes, dim).

        Raises:
            StepFailed: a term has no force at this displacement.
        """
        residual, load, soil = self._zero(), self._zero(), self._zero()
        for term in self.terms:
            force = term.force(displacement)
            residual += force
            if term.role is Role.LOAD:
                load -= force
            elif term.role is Role.SOIL:
                soil += force
        return Forces(residual, load, soil)

    def fill_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """Sets node blocks (blocks, dim, dim) to the derivative of the residual [force/length].

        At the displacement for which `forces` was asked last.
        """
        blocks.fill(0.0)
        for term in self.terms:
            term.add_stiffness(displacement, blocks)

    def require_acceptable(self, displacement: Floats) -> None:
        """Checks that all terms can commit a converged step; changes nothing.

        Raises:
            StepFailed: one cannot.
        """
        for term in self.terms:
            term.require_acceptable(displacement)

    def commit(self, displacement: Floats) -> None:
        """Lets all terms carry a converged step on to the next one."""
        for term in self.terms:
            term.commit(displacement)

    def round_off(self, displacement: Floats) -> float:
        """Returns the force that round-off alone may leave where stiff terms cancel [force]."""
        total = self._sum(term.magnitude(displacement) for term in self.terms)
        return float(np.finfo(np.float64).eps * norm(SERIAL, total))

    def hard_nodes(self) -> list[Flags]:
        """Returns nodes where an iterative solver may need help, (nodes,): all, then fewer.

        Those of material that yields and those that terms couple beyond their cells, then the
        latter alone; nothing where no material yields.
        """
        yielding = union(self.active.nodes, (term.yielding_nodes() for term in self.terms))
        if not yielding.any():
            return []
        joined = union(self.active.nodes, (term.joined_nodes() for term in self.terms))
        return [yielding | joined, joined]
