# SPDX-License-Identifier: BSD-3-Clause
"""The interface of the terms in the balance of a load step.

The residual of a step is the sum of all terms, internal minus external force; the matrix of
Newton's iteration is the sum of their derivatives. A step has three phases:

1. gather: each `Term` determines the nodes on which it acts, on the grid of the step;
2. pattern: `Balance` builds the matrix's pattern from the nodes that the terms couple;
3. assemble: each term receives the positions of its blocks in the matrix and computes its force and
   derivative in each iteration.

In the last phase a term is asked its force and derivative anywhere and as often as one likes: this
changes no state. What belongs to one displacement, such as trial stresses, lasts until the next
call of `force`; all calls "at the displacement of the last call of `force`" use it. State changes
only in

* `restart`, before a step is solved once more, and `begin`, at a solution's first displacement;
* `adapt`, before a linearisation, and `linearised`, after a matrix was really filled;
* `revise` and `refine`, at an equilibrium;
* `commit`, once the step has converged and every term's `check` has passed.

`GlobalUnknowns` are terms with unknowns that belong to no node, such as the motion of a rigid body.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from enum import Enum, auto
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.algebra.border import Border
from tilth.arrays import Flags, Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.terms.motion import NodalMotion
from tilth.terms.outcome import Outcome

NodeLists = tuple[npt.NDArray[np.int64], npt.NDArray[np.int32]]
"""First entry of each element, shape (elements + 1,), and node numbers, shape (entries,)."""


class Role(Enum):
    """The sum of forces, for the scale of the residual and for the energies, that a term is of."""

    SOIL = auto()
    LOAD = auto()
    INERTIA = auto()
    STABILISATION = auto()
    CONTACT = auto()
    """Of soil with boundaries and rigid bodies."""
    BETWEEN_BODIES = auto()
    """Contact of soil with other soil."""
    OTHER = auto()


class Changes(Enum):
    """How terms change, in an attempt at a step, what is fixed while a correction is tried."""

    USUAL = auto()
    """At equilibria, all that should change at once."""
    CAREFUL = auto()
    """Before each linearisation; what couples parts of a term to each other is left out."""
    SINGLE = auto()
    """At equilibria, one part of a term at a time."""


class AssembledTerm(ABC):
    """A term with known positions in the matrix.

    Attributes:
        role: the sum of forces to which it belongs.
        label: what it is, in the words of a table for the user; if empty the name of its class.
    """

    role = Role.OTHER
    label = ""

    @abstractmethod
    def force(self, displacement: Floats) -> Floats:
        """Returns its part of the residual for a nodal displacement of the step, (nodes, dim).

        Internal minus external force [force]. The caller may change the array. Nothing but what
        belongs to this displacement changes.

        Raises:
            StepFailed: the force is not defined at this displacement.
        """

    @abstractmethod
    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """Adds the derivative of `force` to the node blocks (blocks, dim, dim) [force/length].

        At the displacement of the last call of `force`; changes nothing.
        """

    def restart(self, changes: Changes) -> None:  # noqa: B027
        """Undoes what the calls from `begin` to `revise` changed, before a step is solved again.

        What `refine` changed stays, as a better start.

        changes: how it changes in this attempt.
        """

    def begin(self, displacement: Floats, unknowns: Floats) -> None:  # noqa: B027
        """Determines what stays fixed from the first displacement of a solution on.

        Before its first call of `force`, at these values. Without `restart` before it the solution
        goes on from the last one, as in the pseudo-steps of soil that creeps.

        Args:
            displacement: of the nodes [length], shape (nodes, dim): 0 where prescribed ones have
                yet to move, even if there is a guess.
            unknowns: its global unknowns' increments, shape (m,); m = 0 but for `GlobalUnknowns`.
        """

    def adapt(self, displacement: Floats) -> bool:
        """Determines anew, before each linearisation, what is fixed while a correction is tried.

        Such as which points of a surface are active in contact; only where changes are careful. At
        the displacement of the last call of `force`.

        Returns:
            Whether something changed: the forces are then others.
        """
        return False

    def linearised(self) -> None:  # noqa: B027
        """Takes note that the matrix is that at the displacement of the last call of `force`.

        Only where it was filled there: an iteration that keeps the last matrix does not say so.
        """

    def revise(self, displacement: Floats) -> bool:
        """Determines anew, at a converged displacement, what is fixed during the iteration.

        At the displacement of the last call of `force`.

        Returns:
            Whether something changed: the balance must then be solved again.

        Raises:
            StepFailed: it does not settle.
        """
        return False

    def refine(self, displacement: Floats) -> float:
        """Makes the term more exact at a solution, where the iteration asks for it.

        At the displacement of the last call of `force`.

        Returns:
            How much it changed; at most 1 if it did not, because it is exact enough. Else the
            balance must be solved again.
        """
        return 0.0

    def check(self, displacement: Floats) -> Any:  # noqa: B027
        """Checks that the displacement of a converged step can be committed; changes nothing.

        Returns:
            What `commit` needs of what it has computed.

        Raises:
            StepFailed: the displacement cannot be committed.
        """

    def commit(self, displacement: Floats, checked: Any) -> None:  # noqa: B027
        """Stores the state at the end of a converged step as that at the start of the next step.

        At the displacement of the last call of `force`. Terms are committed in any order.

        checked: what its `check` has returned for this displacement.
        """

    @property
    def motion(self) -> NodalMotion | None:
        """The motion of the nodes, of a term that integrates it over time; None for all others."""
        return None

    def outcome(self, displacement: Floats) -> Outcome | None:
        """Returns forces, work and state of contact of a converged step; None if it has none.

        At the displacement of the last call of `force`, before the step is committed.
        """
        return None

    def carried_force(self) -> Floats | None:
        """Returns the internal force of the tractions of contact at the start of the step [force].

        Shape (nodes, dim); None for terms without contact.
        """
        return None

    def load_before(self) -> Floats | None:
        """Returns the external force at the start of the step [force], (nodes, dim); None for 0."""
        return None

    def inertia_before(self) -> Floats | None:
        """Returns the inertia force at the start of the step [force], (nodes, dim); None for 0."""
        return None

    def constant_force(self) -> Floats | None:
        """Returns a linear term's force at zero displacement [force], (nodes, dim), or None."""
        return None

    def magnitude(self, displacement: Floats) -> Floats | None:
        """Returns the sum of the absolute values of the summands of `force` [force], (nodes, dim).

        The round-off error of the force is proportional to it. None if the force is no larger than
        that of the soil.
        """
        return None

    def joined_nodes(self) -> Flags | None:
        """Returns which nodes it couples beyond their cells, shape (nodes,); None for none."""
        return None

    def yielding_nodes(self) -> Flags | None:
        """Returns which nodes belong to yielding material, shape (nodes,); None for none.

        At the displacement of the last call of `force`.
        """
        return None


class GlobalUnknowns(AssembledTerm):
    """An assembled term with m unknowns of its own that belong to no node, and their equations.

    The unknowns are increments, zero at the start of each step; the term itself stores their total
    values. An iteration calls `forces` instead of `force`.

    Attributes:
        scale: factor of each unknown for comparison with displacements, see `Border.scale`, (m,).
    """

    scale: Floats

    def first_unknowns(self) -> Floats:
        """Returns where the iteration for its unknowns begins, shape (m,); zero by default."""
        return np.zeros_like(self.scale)

    def begin_at_guess(self) -> None:
        """Tells that the solution goes on from a guess, after `begin`; nothing by default."""

    def come_down(self) -> bool:
        """Moves a loaded free body that is off the soil down on it, without forces.

        Returns:
            Whether it has moved; False by default.
        """
        return False

    def start(self, unknowns: Floats, size: float) -> None:
        """Takes the accelerations at the start from the very short step that finds them.

        Args:
            unknowns: its global unknowns' increments in that step, shape (m,).
            size: of the first step [time].
        """

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
            StepFailed: the forces are not defined at these values.
        """

    @abstractmethod
    def border(self, displacement: Floats, unknowns: Floats) -> Border:
        """Returns the derivatives of `forces` except that of the nodal force by the displacement.

        The latter is `add_stiffness`. Both at the values of the last call of `forces`.
        """

    def force(self, displacement: Floats) -> Floats:
        """As `AssembledTerm.force`, for zero unknowns."""
        return self.forces(displacement, np.zeros_like(self.scale))[0]


class Term(ABC):
    """A force of the balance in one step, on the grid of this step."""

    @property
    def coupled(self) -> Sequence[NodeLists]:
        """Nodes that its derivative couples, except those that have a material point in common."""
        return ()

    def held_nodes(self) -> Flags | None:
        """Returns which nodes it holds, so that they need no weak spring, (nodes,), or None."""
        return None

    @abstractmethod
    def assembled(self, active: ActiveGrid, elements: Sequence[Elements]) -> AssembledTerm:
        """Returns the assembled term in the pattern of a grid.

        Args:
            active: the grid of the step, with the pattern of all terms.
            elements: positions of the blocks of each of `coupled` in the matrix.
        """


def union(nodes: int, parts: Iterable[Flags | None]) -> Flags:
    """Returns which of the nodes are in at least one of the parts, shape (nodes,)."""
    total = np.zeros(nodes, dtype=bool)
    for part in parts:
        if part is not None:
            total |= part
    return total
