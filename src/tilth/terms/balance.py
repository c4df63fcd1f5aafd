# SPDX-License-Identifier: BSD-3-Clause
"""The balance of a load step: the sum of all its terms, which `Simulation.terms` lists."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from tilth.algebra.border import Border
from tilth.arrays import Flags, Floats
from tilth.comm import count, norm
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.motion import NodalMotion
from tilth.terms.outcome import Outcome
from tilth.terms.protocol import AssembledTerm, Changes, GlobalUnknowns, Role, Term, union


@dataclass(frozen=True)
class Forces:
    """Nodal forces at one displacement [force], shape (nodes, dim) each.

    Attributes:
        residual: internal minus external force of all terms.
        load: external force.
        soil: internal force of the soil.
        inertia: of the soil.
        global_residual: residual of the global unknowns' equations [force times scale], shape (m,).
    """

    residual: Floats
    load: Floats
    soil: Floats
    inertia: Floats
    global_residual: Floats


class Balance:
    """The sum of all terms of a step, in the order in which they are given.

    Args:
        active: the grid of the step.
        terms: of the step, gathered on this grid.

    Attributes:
        active: the grid of the step, with the pattern of all terms.
        terms: the assembled terms.
        comm: communicator of the processes that share the grid.
        load_before, inertia_before: external force and inertia force at the start of the step
            [force], shape (nodes, dim).
        global_scale: of the global unknowns of all terms, one term after the other
            (`Border.scale`), shape (m,).
        kept: the nodal force of each term at the last displacement [force], shape (nodes, dim)
            each; None unless an observer asks for them by `keep_forces`.
    """

    def __init__(self, active: ActiveGrid, terms: Sequence[Term]) -> None:
        coupled = [list(term.coupled) for term in terms]
        self.active = active.with_couplings([each for of_term in coupled for each in of_term])
        elements = iter(self.active.elements)
        self.terms = [
            term.assembled(self.active, [next(elements) for _ in of_term])
            for term, of_term in zip(terms, coupled, strict=True)
        ]
        self.comm = active.comm
        self.load_before = self._sum(term.load_before() for term in self.terms)
        self.inertia_before = self._sum(term.inertia_before() for term in self.terms)
        scales = [t.scale if isinstance(t, GlobalUnknowns) else np.zeros(0) for t in self.terms]
        ends = np.cumsum([0, *map(len, scales)])
        self._slices = [slice(*pair) for pair in pairwise(ends)]  # of each term's global unknowns
        self.global_scale: Floats = np.concatenate([np.zeros(0), *scales])
        self.kept: list[Floats] | None = None

    def _zero(self) -> Floats:
        return np.zeros((self.active.nodes, self.active.grid.dim))

    def _sum(self, forces: Iterable[Floats | None]) -> Floats:
        total = self._zero()
        for force in forces:
            if force is not None:
                total += force
        return total

    def of_role(self, role: Role) -> list[AssembledTerm]:
        """Returns the terms of one role, in their order."""
        return [term for term in self.terms if term.role is role]

    @property
    def motion(self) -> NodalMotion:
        """The motion of the nodes over the step; only where a term integrates it over time."""
        return next(term.motion for term in self.terms if term.motion is not None)

    def outcomes(self, displacement: Floats) -> list[Outcome]:
        """Returns what the terms tell of a converged step, in their order.

        At the displacement of the last call of `forces`, before the step is committed.
        """
        found = (term.outcome(displacement) for term in self.terms)
        return [each for each in found if each is not None]

    def carried_force(self, role: Role) -> Floats:
        """Returns the internal force of contact's tractions at the step's start, (nodes, dim).

        role: `CONTACT` or `BETWEEN_BODIES`, of which the terms are. In [force].
        """
        return self._sum(term.carried_force() for term in self.of_role(role))

    def keep_forces(self) -> None:
        """Keeps, from now on, the forces of the terms that `forces` sums up, in `kept`."""
        self.kept = [self._zero() for _ in self.terms]

    def constant_force(self) -> Floats:
        """Returns the force of all linear terms at zero displacement [force], (nodes, dim)."""
        return self._sum(term.constant_force() for term in self.terms)

    def forces(self, displacement: Floats, unknowns: Floats | None = None) -> Forces:
        """Returns the forces for a nodal displacement of the step, shape (nodes, dim).

        unknowns: increments of the global unknowns in the step, shape (m,); zero if not given.

        Raises:
            StepFailed: a term has no force at this displacement.
        """
        residual, load, soil, inertia = (self._zero() for _ in range(4))
        if unknowns is None:
            unknowns = np.zeros_like(self.global_scale)
        global_residual = np.zeros_like(self.global_scale)
        for number, (term, own) in enumerate(zip(self.terms, self._slices, strict=True)):
            if isinstance(term, GlobalUnknowns):
                force, global_residual[own] = term.forces(displacement, unknowns[own])
            else:
                force = term.force(displacement)
            if self.kept is not None:
                self.kept[number] = force
            residual += force
            if term.role is Role.LOAD:
                load -= force
            elif term.role is Role.SOIL:
                soil += force
            elif term.role is Role.INERTIA:
                inertia += force
        return Forces(residual, load, soil, inertia, global_residual)

    def fill_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """Sets node blocks (blocks, dim, dim) to the derivative of the residual [force/length].

        At the displacement of the last call of `forces`.
        """
        blocks.fill(0.0)
        for term in self.terms:
            term.add_stiffness(displacement, blocks)

    def first_unknowns(self) -> Floats:
        """Returns where the iteration for the global unknowns begins, shape (m,)."""
        parts = [t.first_unknowns() for t in self.terms if isinstance(t, GlobalUnknowns)]
        return np.concatenate([np.zeros(0), *parts])

    def unknowns(self, values: Floats) -> list[tuple[GlobalUnknowns, Floats]]:
        """Returns the terms with global unknowns, and these of all terms (m,) term by term."""
        return [
            (term, values[own])
            for term, own in zip(self.terms, self._slices, strict=True)
            if isinstance(term, GlobalUnknowns)
        ]

    def come_down(self) -> bool:
        """Moves loaded free bodies down on the soil; returns whether any has moved."""
        moved = [term.come_down() for term in self.terms if isinstance(term, GlobalUnknowns)]
        return any(moved)

    def start(self, unknowns: Floats, size: float) -> None:
        """Hands out the accelerations at the start, see `GlobalUnknowns.start`.

        unknowns: of all terms, shape (m,); size: of the first step [time].
        """
        for term, own in self.unknowns(unknowns):
            term.start(own, size)

    def begin_at_guess(self) -> None:
        """Tells the terms that the next displacement is a guess."""
        for term in self.terms:
            if isinstance(term, GlobalUnknowns):
                term.begin_at_guess()

    def restart(self, changes: Changes) -> None:
        """Undoes what terms changed in a solution; from now on they change as given."""
        for term in self.terms:
            term.restart(changes)

    def begin(self, displacement: Floats, unknowns: Floats | None = None) -> None:
        """Begins a solution at a displacement; arguments as of `forces`."""
        if unknowns is None:
            unknowns = np.zeros_like(self.global_scale)
        for term, own in zip(self.terms, self._slices, strict=True):
            term.begin(displacement, unknowns[own])

    def adapt(self, displacement: Floats) -> bool:
        """Returns whether a term changed at a displacement, so that its forces are others."""
        changed = [term.adapt(displacement) for term in self.terms]
        return self.comm.max(float(any(changed))) > 0.0

    def linearised(self) -> None:
        """Tells the terms that the matrix is that at the last displacement."""
        for term in self.terms:
            term.linearised()

    def revise(self, displacement: Floats) -> bool:
        """Returns whether a term changed at a converged displacement, so that it is none any more.

        Raises:
            StepFailed: a term does not settle.
        """
        changed = [term.revise(displacement) for term in self.terms]
        return self.comm.max(float(any(changed))) > 0.0

    def refine(self, displacement: Floats) -> float:
        """Makes terms more exact at a solution; returns how much, see `AssembledTerm.refine`."""
        return self.comm.max(max(term.refine(displacement) for term in self.terms))

    def check(self, displacement: Floats) -> list[Any]:
        """Checks that all terms can commit a converged step; returns what `commit` needs of it.

        Raises:
            StepFailed: a term cannot commit the step.
        """
        return [term.check(displacement) for term in self.terms]

    def commit(self, displacement: Floats, checked: Sequence[Any]) -> None:
        """Commits a converged step in all terms.

        displacement: shape (nodes, dim). checked: what `check` has returned for it.
        """
        for term, own in zip(self.terms, checked, strict=True):
            term.commit(displacement, own)

    def border(self, displacement: Floats, unknowns: Floats) -> Border | None:
        """Returns the border of the matrix for the global unknowns; None without such unknowns.

        At the displacement and the unknowns of the last call of `forces`.
        """
        total = len(self.global_scale)
        if total == 0:
            return None
        columns, rows = (np.zeros((total, *displacement.shape)) for _ in range(2))
        corner = np.zeros((total, total))
        for term, own in zip(self.terms, self._slices, strict=True):
            if isinstance(term, GlobalUnknowns):
                border = term.border(displacement, unknowns[own])
                columns[own], rows[own] = border.columns, border.rows
                corner[own, own] = border.corner
        return Border(columns, rows, corner, self.global_scale)

    def round_off(self, displacement: Floats) -> float:
        """Returns the norm of the residual that round-off may cause in stiff terms [force]."""
        total = self._sum(term.magnitude(displacement) for term in self.terms)
        own = self.active.owned
        return float(np.finfo(np.float64).eps * norm(self.comm, total[own]))

    def exact_nodes(self) -> list[Flags]:
        """Returns nodes whose equations an iterative solver may solve exactly, (nodes,) each.

        First the nodes of yielding material together with those that terms couple beyond their
        cells, then the larger and the smaller of the two alone; an empty list if no material
        yields. With several overlays those coupled in any case: multigrid has levels for
        each overlay by itself.
        """
        yielding = union(self.active.nodes, (term.yielding_nodes() for term in self.terms))
        yields = count(self.comm, int(yielding.sum())) > 0
        if not yields and self.active.overlays == 1:
            return []
        joined = union(self.active.nodes, (term.joined_nodes() for term in self.terms))
        if not yields:
            return [joined]
        alone = sorted([yielding, joined], key=lambda nodes: -count(self.comm, int(nodes.sum())))
        return [yielding | joined, *alone]
