# SPDX-License-Identifier: BSD-3-Clause
"""What a force must offer to take part in the balance of a load step.

The residual of a step is the sum of all terms, internal minus external force; the matrix of
Newton's iteration is the sum of their derivatives. A step has three phases:

1. gather: each `Term` finds the nodes that it acts on, on the grid of the step;
2. pattern: `Balance` makes the matrix's pattern from what all terms couple;
3. assemble: each term, told where its blocks stand, gives force and derivative as often as asked.

A step that has converged is committed by all terms, after each has found it acceptable.

A term may bring unknowns that belong to no node, as the motion of a rigid body: `GlobalUnknowns`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from enum import Enum, auto

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats
from tilth.mpm.border import Border
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.pattern import Elements

NodeLists = tuple[npt.NDArray[np.int64], npt.NDArray[np.int32]]
"""First entry of each element, shape (elements + 1,), among node numbers, shape (entries,)."""


class Role(Enum):
    """Which sum a term belongs to when the size of the residual is judged."""

    SOIL = auto()
    LOAD = auto()
    OTHER = auto()


class AssembledTerm(ABC):
    """A term whose place in the matrix is known.

    Attributes:
        role: the sum that it belongs to.
    """

    role = Role.OTHER

    @abstractmethod
    def force(self, displacement: Floats) -> Floats:
        """Returns its part of the residual for a nodal displacement of the step, (nodes, dim).

        Internal minus external force [force]. The caller may change the array.

        Raises:
            StepFailed: there is no such force at this displacement.
        """

    @abstractmethod
    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """Adds the derivative of `force` to the node blocks (blocks, dim, dim) [force/length].

        At the displacement of the last call of `force`.
        """

    def require_acceptable(self, displacement: Floats) -> None:  # noqa: B027
        """Checks that the displacement of a converged step can be committed; changes nothing.

        Raises:
            StepFailed: it cannot.
        """

    def commit(self, displacement: Floats) -> None:  # noqa: B027
        """Makes the state at the displacement of a converged step that of the next step's start.

        At the displacement of the last call of `force`. Terms are committed in any order.
        """

    def load_before(self) -> Floats | None:
        """Returns the external force at the start of the step [force], (nodes, dim); None for 0."""
        return None

    def constant_force(self) -> Floats | None:
        """Returns the force at zero displacement of a linear term, (nodes, dim); None of others."""
        return None

    def magnitude(self, displacement: Floats) -> Floats | None:
        """Returns the sum of the absolute values of what cancels in `force`, (nodes, dim).

        What round-off may leave of the force is in proportion to it [force]. None where the force
        is no larger than the soil's.
        """
        return None

    def joined_nodes(self) -> Flags | None:
        """Returns the nodes that it couples beyond their cells, shape (nodes,); None for none."""
        return None

    def yielding_nodes(self) -> Flags | None:
        """Returns the nodes of material that yields, shape (nodes,); None for none.

        At the displacement of the last call of `force`.
        """
        return None


class GlobalUnknowns(AssembledTerm):
    """An assembled term with unknowns of its own that belong to no node, and their equations.

    In each step they begin at zero; whatever they have been before the step the term remembers
    itself. An iteration asks for `forces`, not for `force`.

    Attributes:
        scale: what makes each of the m unknowns comparable with a displacement, see `Border.scale`,
            shape (m,).
    """

    scale: Floats

    @abstractmethod
    def forces(self, displacement: Floats, unknowns: Floats) -> tuple[Floats, Floats]:
        """Returns its part of the nodal residual, and the residual of its own equations.

        Args:
            displacement: of the nodes in the step [length], shape (nodes, dim).
            unknowns: its global unknowns' increments in the step, shape (m,).

        Returns:
            Internal minus external force, of the nodes [force], shape (nodes, dim), and of the
            global unknowns [force times their scale], shape (m,).

        Raises:
            StepFailed: there are no such forces.
        """

    @abstractmethod
    def border(self, displacement: Floats, unknowns: Floats) -> Border:
        """Returns all derivatives of `forces` beside that of the nodal force by the displacement.

        That one is `add_stiffness`. Both are asked for at the values of the last call of `forces`.
        """

    def force(self, displacement: Floats) -> Floats:
        """As `AssembledTerm.force`: with its unknowns zero."""
        return self.forces(displacement, np.zeros_like(self.scale))[0]


class Term(ABC):
    """A force of the balance in one step, gathered on the grid of this step."""

    @property
    def coupled(self) -> Sequence[NodeLists]:
        """Nodes that its derivative couples, beside those of the points' supports."""
        return ()

    def supported_nodes(self) -> Flags | None:
        """Returns the nodes that it supports so well that they need no weak spring, (nodes,).

        None for none.
        """
        return None

    @abstractmethod
    def assembled(self, active: ActiveGrid, elements: Sequence[Elements]) -> AssembledTerm:
        """Returns the term in the pattern of a grid.

        Args:
            active: the grid of the step, with the pattern of all terms.
            elements: where each of `coupled` stands in it.
        """


def union(nodes: int, parts: Iterable[Flags | None]) -> Flags:
    """Returns which of so many nodes any of the parts has, shape (nodes,)."""
    total = np.zeros(nodes, dtype=bool)
    for part in parts:
        if part is not None:
            total |= part
    return total
