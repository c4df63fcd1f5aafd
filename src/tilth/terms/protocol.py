# SPDX-License-Identifier: BSD-3-Clause
"""The interface of the terms in the balance of a load step.

The residual of a step is the sum of all terms, internal minus external force; the matrix of
Newton's iteration is the sum of their derivatives. A step has three phases:

1. gather: each `Term` determines the nodes on which it acts, on the grid of the step;
2. pattern: `Balance` builds the matrix's pattern from the nodes that the terms couple;
3. assemble: each term receives the positions of its blocks in the matrix and computes its force and
   derivative in each iteration.

In the last phase a term is asked its force and derivative anywhere and as often as one likes: this
changes no state. What belongs to one evaluation, such as trial stresses, lasts until the next call
of `evaluate`; all calls "at the unknowns of the last evaluation" use it. State changes only in

* `restart`, before a step is solved once more, and `begin`, at a solution's first unknowns;
* `adapt`, before a linearisation, and `linearised`, after a matrix was really filled;
* `revise` and `refine`, at an equilibrium;
* `commit`, once the step has converged and every term's `check` has passed.

A `DisplacementTerm` has forces on the displacement's nodes that depend on nothing but it; a term of
other fields tells by their names what it adds to their residuals, and to which blocks of the
matrix. `GlobalUnknowns` are terms with unknowns that belong to no node, such as the motion of a
rigid body.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum, auto
from typing import Any

import numpy as np

from tilth.algebra.block_matrix import BlockMatrix, Pair
from tilth.algebra.border import Border
from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats
from tilth.mpm.pattern import Elements
from tilth.terms.motion import NodalMotion
from tilth.terms.outcome import Outcome
from tilth.terms.space import OF_DISPLACEMENT, Coupled, Space


class Role(Enum):
    """The sum, for the scale of the residual and for the energies, that a term is of."""

    SOIL = auto()
    LOAD = auto()
    INERTIA = auto()
    STORAGE = auto()
    """What a field that flows leaves in the soil."""
    FLOW = auto()
    """What of it flows, and its force on the soil."""
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


SIZES = frozenset({Role.SOIL, Role.LOAD, Role.INERTIA, Role.STORAGE, Role.FLOW})
"""Sums that the residual of an equation is compared with."""


class AssembledTerm(ABC):
    """A term with known positions in the matrix.

    Attributes:
        role: the sum to which it belongs.
        label: what it is, in the words of a table for the user; if empty the name of its class.
    """

    role = Role.OTHER
    label = ""

    @abstractmethod
    def evaluate(self, x: Unknowns) -> Unknowns:
        """Returns its parts of the residuals of the fields it acts on, internal minus external.

        Args:
            x: all fields; of the global unknowns its own, none but for `GlobalUnknowns`.

        Returns:
            Arrays of the shapes of these fields, and residuals of its own global unknowns. The
            caller does not change them. Nothing but what belongs to this evaluation changes.

        Raises:
            StepFailed: it is not defined there.
        """

    @abstractmethod
    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        """Adds the derivatives of `evaluate` to the blocks of the matrix.

        At the unknowns of the last evaluation; changes nothing. The border is that of
        `GlobalUnknowns.border`.
        """

    def add_schur(self, x: Unknowns, schur: Mapping[str, Floats]) -> None:  # noqa: B027
        """Adds to each other field's own block what elimination of the displacement adds to it.

        An approximation for the preconditioner of an iterative solver, see `CoupledSystem.schur`;
        nothing by default. At the unknowns of the last evaluation.

        schur: blocks by the names of fields, shape (entries, components, components).
        """

    def restart(self, changes: Changes) -> None:  # noqa: B027
        """Undoes what the calls from `begin` to `revise` changed, before a step is solved again.

        What `refine` changed stays, as a better start.

        changes: how it changes in this attempt.
        """

    def begin(self, x: Unknowns) -> None:  # noqa: B027
        """Determines what stays fixed from the first unknowns of a solution on.

        Before its first evaluation, at these values. Without `restart` before it the solution
        goes on from the last one, as in the pseudo-steps of soil that creeps.

        x: at the start of the step where prescribed values have yet to change, even if there is a
            guess.
        """

    def adapt(self, x: Unknowns) -> bool:
        """Determines anew, before each linearisation, what is fixed while a correction is tried.

        Such as which points of a surface are active in contact; only where changes are careful. At
        the unknowns of the last evaluation.

        Returns:
            Whether something changed: the forces are then others.
        """
        return False

    def linearised(self) -> None:  # noqa: B027
        """Takes note that the matrix is that at the unknowns of the last evaluation.

        Only where it was filled there: an iteration that keeps the last matrix does not say so.
        """

    def revise(self, x: Unknowns) -> bool:
        """Determines anew, at a solution, what is fixed during the iteration.

        At the unknowns of the last evaluation.

        Returns:
            Whether something changed: the balance must then be solved again.

        Raises:
            StepFailed: it does not settle.
        """
        return False

    def refine(self, x: Unknowns) -> float:
        """Makes the term more exact at a solution, where the iteration asks for it.

        At the unknowns of the last evaluation.

        Returns:
            How much it changed; at most 1 if it did not, because it is exact enough. Else the
            balance must be solved again.
        """
        return 0.0

    def check(self, x: Unknowns) -> Any:  # noqa: B027
        """Checks that a converged step can be committed; changes nothing.

        Returns:
            What `commit` needs of what it has computed.

        Raises:
            StepFailed: it cannot.
        """

    def commit(self, x: Unknowns, checked: Any) -> None:  # noqa: B027
        """Stores the state at the end of a converged step as that at the start of the next step.

        At the unknowns of the last evaluation. Terms are committed in any order.

        checked: what its `check` has returned for them.
        """

    @property
    def motion(self) -> NodalMotion | None:
        """The motion of the nodes, of a term that integrates it over time; None for all others."""
        return None

    def outcome(self, x: Unknowns) -> Outcome | None:
        """Returns forces, work and state of contact of a converged step; None if it has none.

        At the unknowns of the last evaluation, before the step is committed.
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

    def magnitude(self, x: Unknowns) -> Mapping[str, Floats]:
        """Returns the sums of the absolute values of the summands of `evaluate`, by field.

        The round-off error is proportional to it. None of a field where its part is no larger than
        that of the soil.
        """
        return {}

    def joined_nodes(self) -> Flags | None:
        """Returns which nodes of the grid it couples beyond their cells, (nodes,), or None."""
        return None

    def yielding_nodes(self) -> Flags | None:
        """Returns which nodes of the grid belong to yielding material, (nodes,); None for none.

        At the unknowns of the last evaluation.
        """
        return None


class DisplacementTerm(AssembledTerm):
    """A term of the displacement alone: forces on its nodes, and their derivatives by it."""

    @abstractmethod
    def force(self, displacement: Floats) -> Floats:
        """Returns its part of the residual for a nodal displacement of the step, (nodes, dim).

        Internal minus external force [force]; see `evaluate`.
        """

    @abstractmethod
    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """Adds the derivative of `force` to the node blocks (blocks, dim, dim) [force/length].

        At the displacement of the last call of `force`; changes nothing.
        """

    def evaluate(self, x: Unknowns) -> Unknowns:
        """As `AssembledTerm.evaluate`."""
        return Unknowns({DISPLACEMENT: self.force(x.u)})

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        """As `AssembledTerm.assemble`."""
        self.add_stiffness(x.u, matrix[OF_DISPLACEMENT].values)


class GlobalUnknowns(DisplacementTerm):
    """An assembled term with m unknowns of its own that belong to no node, and their equations.

    The unknowns are increments, zero at the start of each step; the term itself stores their total
    values.

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
        """As `DisplacementTerm.force`, for zero unknowns."""
        return self.forces(displacement, np.zeros_like(self.scale))[0]

    def evaluate(self, x: Unknowns) -> Unknowns:
        """As `AssembledTerm.evaluate`."""
        nodal, own = self.forces(x.u, x.globals)
        return Unknowns({DISPLACEMENT: nodal}, own)


class Term(ABC):
    """A part of the balance in one step, on the grid of this step."""

    @property
    def coupled(self) -> Sequence[Coupled]:
        """Nodes that its derivative couples, except those that have a material point in common."""
        return ()

    @property
    def pairs_at_points(self) -> Sequence[Pair]:
        """Pairs of fields that its derivative couples, both ways, at material points.

        Of the displacement with itself they are always coupled.
        """
        return ()

    def held_nodes(self) -> Flags | None:
        """Returns which nodes it holds, so that they need no weak spring, (nodes,), or None."""
        return None

    @abstractmethod
    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """Returns the assembled term in the pattern of the matrix.

        Args:
            space: the fields of the step and the patterns of their blocks.
            elements: positions of the blocks of each of `coupled` that is of the displacement
                alone; `Space.blocks_of` finds those of the others.
        """


def union(nodes: int, parts: Iterable[Flags | None]) -> Flags:
    """Returns which of the nodes are in at least one of the parts, shape (nodes,)."""
    total = np.zeros(nodes, dtype=bool)
    for part in parts:
        if part is not None:
            total |= part
    return total
