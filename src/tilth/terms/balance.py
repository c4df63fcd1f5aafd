# SPDX-License-Identifier: BSD-3-Clause
"""The balance of a load step: the sum of all its terms, which `TERMS` lists."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.border import Border
from tilth.algebra.field import DISPLACEMENT, Field
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats
from tilth.comm import count, norm
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.motion import NodalMotion
from tilth.terms.outcome import Outcome
from tilth.terms.protocol import (
    SIZES,
    AssembledTerm,
    Changes,
    GlobalUnknowns,
    Role,
    Term,
    union,
)
from tilth.terms.space import Coupled, Space, displacement_of


@dataclass(frozen=True, eq=False)
class Residual(Unknowns):
    """Internal minus external, of all fields and global unknowns: those times their scale.

    Attributes:
        sums: the parts of it by role, then by the name of the field; of the roles `SIZES`.
    """

    sums: Mapping[Role, Mapping[str, Floats]] = field(default_factory=dict)

    def sum_of(self, role: Role, name: str = DISPLACEMENT) -> Floats:
        """Returns what the terms of a role add to a field's residual, (nodes, components)."""
        found = self.sums.get(role, {}).get(name)
        return np.zeros_like(self.of[name]) if found is None else found

    @property
    def load(self) -> Floats:
        """The external force on the soil [force], shape (nodes, dim)."""
        return 0.0 - self.sum_of(Role.LOAD)


class Balance:
    """The sum of all terms of a step, in the order in which they are given.

    Args:
        active: the grid of the step.
        terms: of the step, gathered on this grid.
        fields: of the step, the displacement first, with what is prescribed of them; the
            displacement without conditions if None.

    Attributes:
        active: the grid of the step, with the pattern of the displacement.
        space: all fields and the patterns of the matrix.
        terms: the assembled terms.
        comm: communicator of the processes that share the grid.
        load_before, inertia_before: external force and inertia force at the start of the step
            [force], shape (nodes, dim).
        global_scale: of the global unknowns of all terms, one term after the other
            (`Border.scale`), shape (m,).
        kept: the nodal force of each term on the displacement's nodes at the last evaluation
            [force], shape (nodes, dim) each; None unless an observer asks for them by
            `keep_forces`.
    """

    def __init__(
        self, active: ActiveGrid, terms: Sequence[Term], fields: Sequence[Field] | None = None
    ) -> None:
        fields = [displacement_of(active)] if fields is None else fields
        names = [each.name for each in fields]
        if len(set(names)) < len(names):
            raise ValueError(f"two fields have the same name: {', '.join(names)}")
        coupled = [list(term.coupled) for term in terms]
        points = [pair for term in terms for pair in term.pairs_at_points]
        for term, of_term in zip(terms, coupled, strict=True):
            _require_known(term, of_term, names)
        self.space = Space(active, fields, [each for of in coupled for each in of], points)
        self.active = self.space.active
        elements = iter(self.active.elements)
        self.terms = [
            term.assembled(self.space, [next(elements) for each in of_term if each.of_displacement])
            for term, of_term in zip(terms, coupled, strict=True)
        ]
        for term, found in zip(terms, self.terms, strict=True):
            if not isinstance(found, AssembledTerm):
                raise TypeError(f"`assembled` of {type(term).__name__} returns no term")
        self.comm = active.comm
        self.load_before = self._sum(term.load_before() for term in self.terms)
        self.inertia_before = self._sum(term.inertia_before() for term in self.terms)
        scales = [t.scale if isinstance(t, GlobalUnknowns) else np.zeros(0) for t in self.terms]
        ends = np.cumsum([0, *map(len, scales)])
        self._slices = [slice(*pair) for pair in pairwise(ends)]  # of each term's global unknowns
        self.global_scale: Floats = np.concatenate([np.zeros(0), *scales])
        self.kept: list[Floats] | None = None
        self._are_known = False  # the shapes of what the terms return

    @property
    def fields(self) -> Mapping[str, Field]:
        """All fields by their names, the displacement first."""
        return self.space.fields

    def _zero(self) -> Floats:
        return np.zeros((self.active.nodes, self.active.grid.dim))

    def _sum(self, forces: Iterable[Floats | None]) -> Floats:
        total = self._zero()
        for force in forces:
            if force is not None:
                total += force
        return total

    def _of(self, x: Unknowns) -> list[tuple[AssembledTerm, Unknowns]]:
        """Returns each term with the unknowns that it is given."""
        if len(self.global_scale) == 0:
            return [(term, x) for term in self.terms]
        return [
            (term, x.with_globals(x.globals[own]))
            for term, own in zip(self.terms, self._slices, strict=True)
        ]

    def at(self, displacement: Floats, of_globals: Floats | None = None) -> Unknowns:
        """Returns unknowns with a nodal displacement, all other fields as the step starts.

        of_globals: increments of the global unknowns in the step, shape (m,); zero if not given.
        """
        of = {name: each.first() for name, each in self.fields.items() if name != DISPLACEMENT}
        if of_globals is None:
            of_globals = np.zeros_like(self.global_scale)
        return Unknowns({DISPLACEMENT: displacement, **of}, of_globals)

    def first(self) -> Unknowns:
        """Returns where the iteration begins: the start of the step."""
        parts = [t.first_unknowns() for t in self.terms if isinstance(t, GlobalUnknowns)]
        return self.at(self._zero(), np.concatenate([np.zeros(0), *parts]))

    def of_role(self, role: Role) -> list[AssembledTerm]:
        """Returns the terms of one role, in their order."""
        return [term for term in self.terms if term.role is role]

    @property
    def motion(self) -> NodalMotion:
        """The motion of the nodes over the step; only where a term integrates it over time."""
        return next(term.motion for term in self.terms if term.motion is not None)

    def outcomes(self, x: Unknowns) -> list[Outcome]:
        """Returns what the terms tell of a converged step, in their order.

        At the unknowns of the last evaluation, before the step is committed.
        """
        found = (term.outcome(own) for term, own in self._of(x))
        return [each for each in found if each is not None]

    def carried_force(self, role: Role) -> Floats:
        """Returns the internal force of contact's tractions at the step's start, (nodes, dim).

        role: `CONTACT` or `BETWEEN_BODIES`, of which the terms are. In [force].
        """
        return self._sum(term.carried_force() for term in self.of_role(role))

    def stabilisation(self, displacement: Floats) -> Floats:
        """Returns the internal force of stabilisation at a displacement [force], (nodes, dim)."""
        x = self.at(displacement)
        parts = (term.evaluate(x) for term in self.of_role(Role.STABILISATION))
        return self._sum(part.of.get(DISPLACEMENT) for part in parts)

    def keep_forces(self) -> None:
        """Keeps, from now on, the forces of the terms that `evaluate` sums up, in `kept`."""
        self.kept = [self._zero() for _ in self.terms]

    def constant_force(self) -> Floats:
        """Returns the force of all linear terms at zero displacement [force], (nodes, dim)."""
        return self._sum(term.constant_force() for term in self.terms)

    def evaluate(self, x: Unknowns) -> Residual:
        """Returns the residual.

        Raises:
            StepFailed: a term is not defined there.
        """
        residual = {name: each.zero() for name, each in self.fields.items()}
        sums: dict[Role, dict[str, Floats]] = {}
        of_globals = np.zeros_like(self.global_scale)
        for number, (term, own) in enumerate(self._of(x)):
            part = term.evaluate(own)
            if not self._are_known:
                _require_shapes(term, part, residual)
            of_globals[self._slices[number]] = part.globals
            if self.kept is not None:
                force = part.of.get(DISPLACEMENT)
                self.kept[number] = self._zero() if force is None else force
            for name, values in part.of.items():
                residual[name] += values
                if term.role in SIZES:
                    of_role = sums.setdefault(term.role, {})
                    of_role[name] = of_role[name] + values if name in of_role else values
        self._are_known = True
        return Residual(residual, of_globals, sums)

    def linearise(self, x: Unknowns, matrix: BlockMatrix) -> None:
        """Sets the matrix and its border to the derivative of the residual.

        At the unknowns of the last evaluation.
        """
        matrix.clear()
        for term, own in self._of(x):
            term.assemble(own, matrix)
        matrix.border = self.border(x)

    def schur(self, x: Unknowns, matrix: BlockMatrix) -> dict[str, Floats]:
        """Returns, by field, what is left of the matrix without the displacement, roughly.

        As `CoupledSystem.schur`; at the unknowns of the last evaluation and its matrix.
        """
        others = [name for name in self.fields if name != DISPLACEMENT]
        found = {name: matrix[name, name].values.copy() for name in others}
        for term, own in self._of(x) if others else ():
            term.add_schur(own, found)
        return found

    def of_bodies(self, values: Floats) -> list[tuple[GlobalUnknowns, Floats]]:
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

    def start(self, of_globals: Floats, size: float) -> None:
        """Hands out the accelerations at the start, see `GlobalUnknowns.start`.

        of_globals: of all terms, shape (m,); size: of the first step [time].
        """
        for term, own in self.of_bodies(of_globals):
            term.start(own, size)

    def begin_at_guess(self) -> None:
        """Tells the terms that the next unknowns are a guess."""
        for term in self.terms:
            if isinstance(term, GlobalUnknowns):
                term.begin_at_guess()

    def restart(self, changes: Changes) -> None:
        """Undoes what terms changed in a solution; from now on they change as given."""
        for term in self.terms:
            term.restart(changes)

    def begin(self, x: Unknowns) -> None:
        """Begins a solution at these unknowns."""
        for term, own in self._of(x):
            term.begin(own)

    def adapt(self, x: Unknowns) -> bool:
        """Returns whether a term changed, so that its residual is another one."""
        changed = [term.adapt(own) for term, own in self._of(x)]
        return self.comm.max(float(any(changed))) > 0.0

    def linearised(self) -> None:
        """Tells the terms that the matrix is that at the last unknowns."""
        for term in self.terms:
            term.linearised()

    def revise(self, x: Unknowns) -> bool:
        """Returns whether a term changed at a solution, so that it is none any more.

        Raises:
            StepFailed: a term does not settle.
        """
        changed = [term.revise(own) for term, own in self._of(x)]
        return self.comm.max(float(any(changed))) > 0.0

    def refine(self, x: Unknowns) -> float:
        """Makes terms more exact at a solution; returns how much, see `AssembledTerm.refine`."""
        return self.comm.max(max(term.refine(own) for term, own in self._of(x)))

    def check(self, x: Unknowns) -> list[Any]:
        """Checks that all terms can commit a converged step; returns what `commit` needs of it.

        Raises:
            StepFailed: a term cannot commit the step.
        """
        return [term.check(own) for term, own in self._of(x)]

    def commit(self, x: Unknowns, checked: Sequence[Any]) -> None:
        """Commits a converged step in all terms; checked: what `check` has returned for it."""
        for (term, own), of_term in zip(self._of(x), checked, strict=True):
            term.commit(own, of_term)

    def border(self, x: Unknowns) -> Border | None:
        """Returns the border of the matrix for the global unknowns; None without such unknowns.

        At the unknowns of the last evaluation.
        """
        total = len(self.global_scale)
        if total == 0:
            return None
        columns, rows = (np.zeros((total, *x.u.shape)) for _ in range(2))
        corner = np.zeros((total, total))
        others: dict[str, Floats] = {}
        for term, own in zip(self.terms, self._slices, strict=True):
            if isinstance(term, GlobalUnknowns):
                border = term.border(x.u, x.globals[own])
                columns[own], rows[own] = border.columns, border.rows
                corner[own, own] = border.corner
                for name, of_other in border.others.items():
                    shape = (total, *self.fields[name].shape)
                    others.setdefault(name, np.zeros(shape))[own] = of_other
        return Border(columns, rows, corner, self.global_scale, others)

    def round_off(self, x: Unknowns, fields: Iterable[Field]) -> float:
        """Returns the norm of the residual of fields that round-off may cause in stiff terms.

        fields: of one equation, in the unit of its residual.
        """
        sizes = [term.magnitude(own) for term, own in self._of(x)]
        total = 0.0
        for each in fields:
            parts = [size[each.name] for size in sizes if each.name in size]
            summed = sum(parts, each.zero())
            total = float(np.hypot(total, norm(self.comm, each.over_scale(summed)[each.owned])))
        return float(np.finfo(np.float64).eps * total)

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


def _require_known(term: Term, coupled: Sequence[Coupled], names: Sequence[str]) -> None:
    """Checks that the fields that a term couples are those of the step; raises `ValueError`."""
    pairs = term.pairs_at_points
    if not all(isinstance(pair, tuple) and len(pair) == 2 for pair in pairs):
        raise ValueError(f"`pairs_at_points` of {type(term).__name__} is no list of pairs: {pairs}")
    for pair in (*pairs, *(each.pair for each in coupled)):
        for name in pair:
            if name not in names:
                raise ValueError(
                    f"{type(term).__name__} couples a field {name!r} that the step does not have; "
                    f"it has {', '.join(names)}: a further one needs an owner in `fields`"
                )


def _require_shapes(term: AssembledTerm, part: Unknowns, residual: Mapping[str, Floats]) -> None:
    """Checks what a term returns; raises `TypeError` or `ValueError`."""
    if not isinstance(part, Unknowns):
        raise TypeError(f"`evaluate` of {type(term).__name__} returns no `Unknowns`")
    for name, values in part.of.items():
        if name not in residual:
            raise ValueError(
                f"{type(term).__name__} returns a residual of {name!r}, a field that the step does "
                f"not have; it has {', '.join(residual)}"
            )
        if values.shape != residual[name].shape:
            raise ValueError(
                f"{type(term).__name__} returns a residual of {name!r} of the shape {values.shape} "
                f"instead of {residual[name].shape}"
            )
